"""CG height from braking and corners at once: the companion of Park & Choi."""
