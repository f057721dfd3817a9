"""Compiled filters on arrays. Nothing in here knows a vehicle."""
