"""From a drive's signals to clean, evenly sampled segments on one clock, and to derived signals."""
