"""Roads: roughness, courses, and the speeds driven on them."""
