"""CG height, roll stiffness and damping by Berntorp et al.'s marginalised particle filter."""
