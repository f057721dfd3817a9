"""Driving manoeuvres, one file a family."""
