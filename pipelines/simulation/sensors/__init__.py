"""Simulated sensors: from true motion to a log with errors."""
