"""The vehicle as unknowns: what was known of it, and what follows for the vehicle as it was loaded."""
