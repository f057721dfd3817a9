"""Mass, CG position and height from the balances of forces."""
