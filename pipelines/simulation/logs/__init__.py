"""Simulated drives as logs, with their truth and vehicle file."""
