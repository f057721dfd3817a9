"""Drives with known truth."""
