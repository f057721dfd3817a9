"""The registry's records: a model function with its parameters, signals, given figures and usual priors, one file each."""
