"""The platform carried by two differential robots (SOMIM 2013)."""
