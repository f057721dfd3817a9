"""The full-vehicle plant."""
