"""The logs of the import benchmark and what reads them: made from a seed, so that every machine has the same."""
