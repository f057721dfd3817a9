"""The vehicle file, and what 1 270 measured vehicles say where it is silent."""
