"""When a drive began, as text: ISO 8601 with its offset, without one where nobody says of which time zone the clock is.

Such a start is the recorder's local time. Wherever drives are put in order it is taken as UTC, up to 14 hours off: a drive
that is some hours out of place tells more than one without any date.
"""

from __future__ import annotations

from datetime import datetime


def is_local(start: str | None) -> bool:
    """Whether a start is one, and of an unknown time zone."""
    try:
        return bool(start) and datetime.fromisoformat(start or "").tzinfo is None
    except ValueError:
        return False


def best_start(log: str | None, said: str | None) -> str | None:
    """A drive's start by its log, and by what a user said of it: the user knows better where the log names no time zone."""
    return said if said is not None and (log is None or is_local(log)) else log
