"""Turning: instantaneous centres, pivots and two-wheel turns (source T eq. 24-33, corrected)."""
