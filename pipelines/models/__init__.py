"""Vehicle models as pure functions on arrays."""
