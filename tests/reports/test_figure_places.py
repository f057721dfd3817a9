"""Sparing matplotlib known places draws the same figure: labels, titles, and titles that a power of ten is in the way of."""

from __future__ import annotations

import re

import numpy as np
import pytest

from reports.figures import style
from reports.figures.style import new_figure, styled, to_svg


def _drawn(scales: tuple[float, ...], offset: float = 0.0, log: bool = False) -> str:
    with styled():
        figure = new_figure(6.0, 1.4 * len(scales))
        grid = figure.subplots(len(scales), 2, squeeze=False)
        x = np.linspace(0.0, 10.0, 50)
        for (left, right), scale in zip(grid, scales, strict=True):
            left.plot(x, offset + scale * (1.1 + np.sin(x)))
            left.set_title("a title")
            left.set_ylabel("y, N")
            right.plot(x, offset + scale * np.cos(x))
            right.set_title("no labels at all")
            right.tick_params(labelbottom=False)
            if log:
                left.set_yscale("log")
        grid[-1][0].set_xlabel("time, s")
        svg = to_svg(figure, "one", "a figure")
    # names of clips are hashes over the last digits of figures
    return re.sub(r"one-p[0-9a-f]{10}", "clip", svg)


def _decimals(svg: str) -> tuple[str, list[float]]:
    """The drawing without its figures, and its figures."""
    number = re.compile(r"-?\d+\.\d+")
    return number.sub("#", svg), [float(n) for n in number.findall(svg)]


@pytest.mark.parametrize(
    ("scales", "offset", "log"),
    [
        ((1.0, 0.02), 0.0, False),
        ((1e6, 1.0), 0.0, False),
        ((1e-6, 1e-2), 0.0, False),
        ((1e-4,), 1000.0, False),
        ((30.0,), 9000.0, False),
        ((20.0,), 0.0, True),
    ],
)
def test_the_same_figure(monkeypatch, scales, offset, log):
    quick = _drawn(scales, offset, log)
    monkeypatch.setattr(style, "_place_less", lambda figure: None)
    careful = _drawn(scales, offset, log)
    (text, ours), (expected_text, theirs) = _decimals(quick), _decimals(careful)
    assert text == expected_text
    assert ours == pytest.approx(theirs, abs=0.011)


def test_a_power_of_ten_is_left_to_matplotlib(monkeypatch):
    """The test above can fail: without the exception a title stands in the way."""
    careful = _drawn((1e6, 1.0))
    monkeypatch.setattr(style, "_labelled_plainly", lambda axes: True)
    assert _decimals(_drawn((1e6, 1.0)))[1] != pytest.approx(_decimals(careful)[1], abs=0.011)


def test_decimals_are_cut_not_rounded():
    match = style._PATH.search(' d="M 1.23456 -0.5L 12.345 7z"')
    assert match is not None
    assert style._short_path(match) == ' d="M 1.23 -0.5L 12.34 7z"'
