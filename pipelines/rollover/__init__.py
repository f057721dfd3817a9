"""Rollover: static limits of the vehicle, how near a drive came to them, wheel lift (dissertation, Chapter 10)."""

from __future__ import annotations

from pipelines.rollover.assess import assess_rollover

__all__ = ["assess_rollover"]
