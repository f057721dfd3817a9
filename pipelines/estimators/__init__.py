"""Estimators: one file a method, one line each in the registry."""
