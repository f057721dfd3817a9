"""Figures as the fleet report prints them."""

from __future__ import annotations

from datetime import UTC, datetime

from reports.fleet.view import finite
from reports.text import DASH, NARROW, NO_BREAK, decimals_for, number, significant, with_unit


def date_text(start: int | None, *, time: bool = False, local: bool = False) -> str:
    """A moment in UTC, as a date or with hours and minutes; — where it is not known. local: nobody says of which time zone."""
    if start is None:
        return DASH
    try:
        shown = datetime.fromtimestamp(start, UTC).strftime("%Y-%m-%d %H:%M" if time else "%Y-%m-%d")
    except (OverflowError, ValueError, OSError):
        return DASH
    return f"{shown} local" if time and local else shown


def spread_text(value: object, std: object, unit: str = "", earned: float | object = None) -> str:
    """Value ± standard deviation; without one, the value with the digits that the spread `earned` gives it."""
    known, spread, other = finite(value), finite(std), finite(earned)
    if known is None:
        return DASH
    wide = spread if spread else other
    if wide is None or wide <= 0:
        return with_unit(significant(known, 3), unit)
    decimals = decimals_for(wide, 3)
    text = number(known, decimals)
    return with_unit(f"{text}{NO_BREAK}±{NO_BREAK}{number(spread, decimals)}" if spread else text, unit)


def chance_text(probability: object) -> str:
    """A probability in percent; very small ones as less than 0.01 %."""
    known = finite(probability)
    if known is None:
        return DASH
    if known < 1e-4:
        return f"<{NO_BREAK}0.01{NARROW}%"
    return with_unit(significant(100 * known, 2), "%")


def hours_text(seconds: float) -> str:
    """A long time in hours; a short one in minutes."""
    if seconds < 3600:
        return with_unit(number(seconds / 60, 0), "min")
    hours = seconds / 3600
    return with_unit(number(hours, 1 if hours < 100 else 0), "h")
