"""Measured vehicles (US NHTSA, public domain): CG heights and inertias."""
