"""Kinematics of any set of roller wheels: the wheel table, H, its solutions and its limits."""
