"""Numpy and the standard library only: the models and the estimator."""
