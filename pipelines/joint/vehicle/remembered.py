"""Unknowns that remember what was reckoned of them: a dozen relations ask the same vehicle how far its load presses the springs."""

from __future__ import annotations

import functools
from collections.abc import Callable, Hashable
from typing import TypeVar

V = TypeVar("V")
P = TypeVar("P")
K = TypeVar("K", bound=Hashable)
R = TypeVar("R")


class Remembered(dict[str, V]):
    """Figures by name, of one vehicle or of many, that are not changed once they are asked (a changed one forgets all).

    memo: answers of the functions that `once` wraps.
    """

    __slots__ = ("memo",)

    def __init__(self, *given: object, **named: V) -> None:
        super().__init__(*given, **named)
        self.memo: dict[tuple[str, Hashable], object] = {}

    def __setitem__(self, name: str, value: V) -> None:
        """Set a figure, and forget what followed from the old one."""
        self.memo.clear()
        super().__setitem__(name, value)

    def __reduce__(self) -> tuple[type[dict[str, V]], tuple[dict[str, V]]]:
        """Sent elsewhere or copied as plain figures."""
        return dict, (dict(self),)


def once(function: Callable[[P, K], R]) -> Callable[[P, K], R]:
    """A function of figures and one key that is reckoned once for each `Remembered`; of any other mapping as ever.

    Its answers are handed out again: nobody may write into their arrays.
    """
    name = f"{function.__module__}.{function.__qualname__}"

    @functools.wraps(function)
    def asked(p: P, key: K) -> R:
        memo = getattr(p, "memo", None)
        if memo is None:
            return function(p, key)
        at = (name, key)
        if at not in memo:
            memo[at] = function(p, key)
        found: R = memo[at]
        return found

    return asked
