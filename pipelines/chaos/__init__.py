"""Generalised polynomial chaos on arrays: bases, index sets, collocation, expansions. Nothing in here knows a vehicle."""
