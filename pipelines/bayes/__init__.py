"""Bayesian estimation with polynomial surrogates of a model: the dissertation's gPC-Bayesian method (3.3)."""
