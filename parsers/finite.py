"""What a file from outside calls a number: TOML and JSON know whole numbers of any length, which no float can hold."""

from __future__ import annotations

import sys
from typing import TypeGuard


def is_number(value: object) -> TypeGuard[int | float]:
    """Whether a value is a number that a float can hold: no true or false, no infinity, no whole number of 400 digits."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max
