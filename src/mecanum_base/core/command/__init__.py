"""From a wanted twist to wheel rates: limits, saturation, stopping, goals."""
