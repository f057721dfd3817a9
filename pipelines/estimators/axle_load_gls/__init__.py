"""CG height, position and mass from axle loads: the companion of Wu et al."""
