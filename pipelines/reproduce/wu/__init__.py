"""Wu et al. beside ours."""
