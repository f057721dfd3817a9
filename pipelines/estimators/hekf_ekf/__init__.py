"""CG height and position by the HEKF-EKF of Wu et al., as published."""
