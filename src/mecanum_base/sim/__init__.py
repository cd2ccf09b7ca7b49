"""Simulated hardware: plant, sensors, faults, scenarios."""
