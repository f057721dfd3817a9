"""ASAM MDF 4 (MF4): the file's blocks, its records, and what is in them (measured channels and CAN frames)."""
