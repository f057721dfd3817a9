"""Tyre normal forces by a suspension map."""
