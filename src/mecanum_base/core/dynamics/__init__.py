"""Forces, loads, motion and traction of a wheeled base (source T eq. 5-16, corrected)."""
