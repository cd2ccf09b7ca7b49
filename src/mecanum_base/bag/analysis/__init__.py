"""What a recording tells: findings, drift, wiring faults, calibration."""
