"""Slip in the terms of source T: effective rate, encoder constant, slip ratio (T eq. 1-4)."""
