"""What a reproduction of a paper is made of: tables beside ours, claims, and a study against the Cramér-Rao bound."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from pipelines.results import Scatter, Trace

Cell = str | float | None
Agreement = Literal["agrees", "differs", "not shown"]
TargetMet = Literal["kept", "open", "missed"]
Progress = Callable[[str, float], None]
CRAMER_RAO = "Cramér-Rao bound"


@dataclass(frozen=True)
class Column:
    """A column's heading, unit ("" = none) and digits after the point for numbers."""

    heading: str
    unit: str = ""
    digits: int = 1


@dataclass(frozen=True)
class ReproducedTable:
    """A published table beside ours. rows: as many cells as columns; None = not printed or not applicable.

    place: "Table III". remark: where ours differs and why, in a sentence or two; "" where it does not.
    """

    place: str
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    remark: str = ""


@dataclass(frozen=True)
class Claim:
    """One claim of the paper's text: what it says, what ours and the companion give, whether it agrees and why not."""

    place: str
    published: str
    ours: str
    companion: str
    agreement: Agreement
    remark: str = ""


@dataclass(frozen=True)
class StudyRow:
    """A method over many noise seeds on one set-up. Errors are estimate minus truth, in `unit`.

    bound: what the RMSE is held against, None where there is nothing; ratio = rmse / bound. yardstick says what it is: the
    Cramér-Rao bound of the standard deviation on that set-up, or in words what stands in its place.
    coverage: share of runs whose 95 % interval held the truth. target: the largest ratio aimed at, None without one.
    """

    setup: str
    method: str
    parameter: str
    unit: str
    truth: float
    runs: int
    bias: float
    rmse: float
    bound: float | None
    coverage: float | None
    target: float | None = None
    remark: str = ""
    yardstick: str = CRAMER_RAO

    @property
    def ratio(self) -> float | None:
        """RMSE over the bound."""
        return None if not self.bound else self.rmse / self.bound

    @property
    def ratio_std(self) -> float | None:
        """The ratio's sampling error: an RMSE of n errors that are normal scatters by a share of 1 / sqrt(2 n)."""
        return None if self.ratio is None or self.runs < 1 else self.ratio / math.sqrt(2 * self.runs)

    @property
    def target_met(self) -> TargetMet | None:
        """Whether the target is kept; "open" where the ratio is beyond it by no more than chance alone may make of one
        that keeps it (two sampling errors). None without a target.
        """
        if self.target is None or self.ratio is None:
            return None
        if self.ratio <= self.target:
            return "kept"
        return "open" if self.ratio <= self.target * (1 + 2 / math.sqrt(2 * self.runs)) else "missed"


@dataclass(frozen=True)
class Reproduction:
    """All that `cogest reproduce` prints for one paper, and a page of its report."""

    paper: str
    title: str
    citation: str
    setup: tuple[str, ...]
    tables: tuple[ReproducedTable, ...]
    claims: tuple[Claim, ...]
    study: tuple[StudyRow, ...]
    traces: tuple[Trace, ...] = ()
    scatters: tuple[Scatter, ...] = ()
    notes: tuple[str, ...] = field(default=())


class Paper(Protocol):
    """A paper that can be reproduced."""

    @property
    def name(self) -> str:
        """As on the command line: "pence"."""
        ...

    @property
    def title(self) -> str:
        """As the report's heading has it."""
        ...

    def reproduce(self, runs: int, rng: np.random.Generator, progress: Progress) -> Reproduction:
        """Do it. runs: noise seeds of the study. Deterministic for a given generator."""
        ...


def study_row(
    setup: str,
    method: str,
    parameter: str,
    unit: str,
    truth: float,
    estimates: np.ndarray[tuple[int], np.dtype[np.float64]],
    intervals: np.ndarray[tuple[int, int], np.dtype[np.float64]] | None,
    bound: float | None,
    target: float | None = None,
    remark: str = "",
) -> StudyRow:
    """Bias, RMSE and coverage of `estimates` (runs,) with `intervals` (runs, 2); NaN runs count as misses, said."""
    good = np.isfinite(estimates)
    error = estimates[good] - truth
    lost = int(np.sum(~good))
    if lost:
        remark = f"{remark} {lost} of {len(estimates)} runs gave no figure.".strip()
    coverage = None
    if intervals is not None:
        inside = (intervals[:, 0] <= truth) & (truth <= intervals[:, 1]) & good
        coverage = float(np.mean(inside))
    return StudyRow(
        setup, method, parameter, unit, truth, len(estimates),
        float(np.mean(error)) if len(error) else float("nan"),
        float(np.sqrt(np.mean(error**2))) if len(error) else float("nan"),
        bound, coverage, target, remark,
    )  # fmt: skip
