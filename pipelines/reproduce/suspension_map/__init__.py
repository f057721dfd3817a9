"""Suspension mapping, Chapter 9 of the dissertation, beside ours."""
