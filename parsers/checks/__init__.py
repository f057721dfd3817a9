"""Checks of signals against physics: units, signs, spikes, offsets and stuck channels."""

from parsers.checks.check import Checked, check_all, check_signals, unchecked

__all__ = ["Checked", "check_all", "check_signals", "unchecked"]
