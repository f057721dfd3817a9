"""A suspension map whose errors on another drive are no more those of its training is said to be none for it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from reports.suspension_map_text import _warning


def judged(ratio: float, *coverage: float) -> Any:
    wheels = {w: SimpleNamespace(coverage=c) for w, c in zip(("fl", "fr", "rl", "rr"), coverage, strict=True)}
    return SimpleNamespace(ratio=ratio, wheels=wheels)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (judged(1.29, 0.95, 0.94, 0.93, 0.96), ""),
        (judged(2.62, 0.95, 0.94, 0.93, 0.96), "errors grow by more than 1.5 times: the map"),
        (judged(1.1, 0.77, 0.94, 0.93, 0.6), "the 95 % interval holds less than 85 % at fl, rr: the map"),
        (judged(2.0, 0.77, 0.94, 0.93, 0.9), "times and the 95 % interval holds"),
    ],
)
def test_what_does_not_carry_over_is_said(entry: Any, said: str) -> None:
    lines = _warning(entry)
    assert len(lines) == bool(said)
    assert said in "".join(lines)
