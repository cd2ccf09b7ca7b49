"""The mecanum command: one file a verb."""
