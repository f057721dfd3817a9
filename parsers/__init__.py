"""Read any drive log into one set of signals: formats, mapping, units, time, and the columnar store."""
