"""gpc_bayesian_map: any model of the registry, fitted by the dissertation's gPC-Bayesian method."""
