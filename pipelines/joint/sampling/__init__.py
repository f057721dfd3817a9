"""Draws from a posterior that is not normal: sequential Monte Carlo from the prior's side, mode by mode."""
