"""The dissertation's gPC-Bayesian MAP estimation (Chapter 5) beside ours."""
