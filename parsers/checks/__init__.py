"""Checks of signals against physics: units, signs, spikes, offsets and stuck channels."""

from parsers.checks.check import check_signals, unchecked

__all__ = ["check_signals", "unchecked"]
