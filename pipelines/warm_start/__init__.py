"""Berntorp et al., Algorithm 1: a distribution to start from, by Bayesian optimisation of a model's error over a box.

gaussian_process.py       regression with a squared exponential or Matérn covariance, hyperparameters by marginal likelihood
expected_improvement.py   which point to try next
density.py                kernel density over the points tried, its confidence box, draws
roll_cost.py              the error of a simulated roll motion
warm_start.py             the algorithm: `minimise`, `warm_start`
"""
