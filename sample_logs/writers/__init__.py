"""Writers of the sample logs: each format by its own writer library."""
