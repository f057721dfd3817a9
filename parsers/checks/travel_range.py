"""Deflections that span more, or lean more in bends, than any road vehicle's: mm called cm, whatever a gyro says or does not say.

A wrong unit is that of a whole set of sensors, so that wheels are left out together. One sensor whose own scale is wrong shows far
more than the others, and goes alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import MIN_CELLS, Grid
from parsers.checks.springs import DEFLECTIONS
from parsers.checks.travel import HINTS, LEANS, axle_leans, felt_over_driven
from parsers.drive import Decision
from parsers.quantiles import quantiles
from parsers.units import STANDARD_GRAVITY

MOST_M = 0.4
"""From full rebound to the stop: cars have 0.15 to 0.25 m, lorries and off-road vehicles up to 0.35 m."""
SHARE = 0.01
"""Of the cells, on either side, that stray values may be."""
USUAL_M = (0.01, 0.2)
"""What wheels span of that on a drive."""
ALIKE = 3.0
"""A wheel that spans less than the largest by this factor has another scale than that one."""
USUAL_LEANS = (0.002, 0.025)
"""What the springs of road vehicles lean in bends, rad per m/s²."""
AGREE = 1.45
"""How far lateral acceleration and yaw rate times speed may differ where both have the right unit."""
_LABELS = {0.01: ("called cm",), 0.0254: ("called inches",)}
"""Factor to SI of the unit that a signal was taken in -> what a mistake of it is called."""


def impossible_travel(grid: Grid, taken: Mapping[str, float]) -> list[Decision]:
    """Deflections left out that span more than `MOST_M`, or show a lean in bends that no vehicle has.

    taken: signal -> factor to SI of the unit that it was taken in (absent: SI).
    """
    spans = {name: _span(grid.columns[name]) for name in DEFLECTIONS if name in grid.columns}
    largest = max(spans.values(), default=0.0)
    if largest > MOST_M:
        wrong = [name for name, span in spans.items() if span * ALIKE > largest]
        text = f"{'deflections span' if len(wrong) > 1 else f'{wrong[0]} spans'} {largest:.2g} m, more than any road vehicle's wheel travels"
        shown = ", ".join(f"{name[-2:]} {spans[name]:.2g} m" for name in wrong)
        evidence = f"{shown} from {SHARE:.0%} to {1 - SHARE:.0%} of the time, of {MOST_M:g} m at most"
    elif (lean := _lean(grid)) is not None and lean[0] > LEANS[1]:
        wrong = list(spans)
        text = (
            f"deflections show a lean of {_degpg(lean[0]):.0f}° per g in bends, more than any road vehicle's"
        )
        evidence = f"over {lean[1]:.0f} s; road vehicles have 1.5 to {_degpg(LEANS[1]):.0f}° per g"
    else:
        return []
    hints = list(_hints(grid, largest, {taken.get(name, 1.0) for name in wrong}))
    text += f", as {' or '.join(hints)} would" if hints else ""
    action = "left out; say the unit, or a factor, in a mapping file"
    return [Decision(name, "range", text, action, evidence, applied=True) for name in wrong]


def _degpg(lean: float) -> float:
    return math.degrees(lean * STANDARD_GRAVITY)


def _span(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    if len(finite) < MIN_CELLS:
        return 0.0
    low, high = quantiles(finite, SHARE, 1 - SHARE)
    return float(high - low)


def _lean(grid: Grid) -> tuple[float, float] | None:
    """The smaller of both axles' leans by the springs, rad per m/s², and over how many seconds; None where bends do not tell it.

    Lateral acceleration and yaw rate times speed must agree: a wrong unit of one of them would look like one of the springs.
    """
    leans = axle_leans(grid)
    if len(leans) < 2 or not 1 / AGREE < felt_over_driven(grid) < AGREE:
        return None
    sizes = {abs(each.correlation) * each.ratio: each.seconds for each in leans.values()}
    return min(sizes.items())


def _hints(grid: Grid, largest: float, taken: set[float]) -> Iterator[str]:
    """Mistakes that leave a usual span, and a usual lean where that is told. taken: of the deflections."""
    labels = _LABELS.get(next(iter(taken)), ()) if len(taken) == 1 else ()
    lean = _lean(grid)
    for factor, words in HINTS:
        named = words.removesuffix(" would be")
        fits = USUAL_M[0] <= largest / factor <= USUAL_M[1]
        fits &= lean is None or USUAL_LEANS[0] <= lean[0] / factor <= USUAL_LEANS[1]
        if factor > 1 and fits and (not labels or named.endswith(labels)):
            yield named
