"""Typed results of one drive: what estimators return, what the verdict says, and what reports are made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from statistics import NormalDist
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipelines.evidence import Evidence

FloatArray = NDArray[np.float64]
Identification = Literal["identified", "weak", "not_identifiable"]
RunStatus = Literal["ran", "skipped", "failed"]
Interval = tuple[float, float]

INNER, OUTER = (0.5, 0.8), 0.95
"""Shares of a parameter's probability that its central intervals hold: beside the usual 95 %, those that most answers lie in."""


@dataclass(frozen=True)
class Prior:
    """What was known before the log: mean and standard deviation, and where it came from, in words."""

    value: float
    std: float
    source: str


@dataclass(frozen=True)
class ParameterEstimate:
    """One parameter. value, std, low, high are None where there is nothing to say (no prior, not identifiable).

    low-high: 95 % interval. reason: in words, why this status, and what was missing. prior: None where nothing was
    known. reference: the truth from the vehicle file, for error tables. sources: estimators or relations behind it.
    inner: the 50 and the 80 % interval (`INNER`), where they are not those of a normal distribution to each side of the value.
    refused: why it may not be called identified however narrow it gets, as the vehicle file or the log must be wrong; a beginning of a
    reason, with its "; ". Empty where nothing says so.
    """

    name: str
    value: float | None
    std: float | None
    low: float | None
    high: float | None
    status: Identification
    reason: str
    prior: Prior | None = None
    reference: float | None = None
    sources: tuple[str, ...] = ()
    inner: tuple[Interval, ...] = ()
    refused: str = ""

    def interval(self, level: float) -> Interval | None:
        """The central interval of a level (0.95 or one of `INNER`), None without figures. Raises ValueError for others."""
        if level not in (*INNER, OUTER):
            raise ValueError(f"no interval of {100 * level:g} % is told")
        if self.value is None or self.std is None or self.low is None or self.high is None:
            return None
        if level == OUTER:
            return self.low, self.high
        if self.inner:
            low, high = self.inner[INNER.index(level)]
            return max(low, self.low), min(high, self.high)
        # to each side by its own reach: an interval that ends at nought, or is skew, holds the narrower ones
        share = NormalDist().inv_cdf(0.5 + level / 2) / NormalDist().inv_cdf(0.5 + OUTER / 2)
        return self.value - share * (self.value - self.low), self.value + share * (self.high - self.value)


@dataclass(frozen=True)
class Track:
    """A parameter's estimate over the drive, as data came in. All shape (n,); time_s from the drive's start."""

    parameter: str
    time_s: FloatArray
    value: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class Distribution:
    """A parameter's whole distribution over the drive, as data came in.

    time_s: (n,) from the drive's start. levels: q shares from 0 to 1, rising. quantiles: for each level (n,), in the
    parameter's unit. note: whose distribution it is, in words.
    """

    parameter: str
    time_s: FloatArray
    levels: tuple[float, ...]
    quantiles: tuple[FloatArray, ...]
    note: str = ""


@dataclass(frozen=True)
class Trace:
    """Named columns over time for a figure: signals, fits, residuals. time_s (n,), columns name -> (n,); NaN = gap.

    spread: filled by reports when a trace is thinned; the quantiles of each column before that, in equal steps from
    0 to 1, so that a histogram stays true.
    """

    name: str
    time_s: FloatArray
    columns: Mapping[str, FloatArray]
    units: Mapping[str, str] = field(default_factory=dict)
    note: str = ""
    spread: Mapping[str, FloatArray] = field(default_factory=dict)


@dataclass(frozen=True)
class Scatter:
    """A relation between two quantities with its fit and 95 % band (roll against lateral acceleration).

    x, y: (n,) points. fit_x, fit_y, band_low, band_high: (m,).
    """

    name: str
    title: str
    x_label: str
    y_label: str
    x: FloatArray
    y: FloatArray
    fit_x: FloatArray
    fit_y: FloatArray
    band_low: FloatArray
    band_high: FloatArray
    note: str = ""


@dataclass(frozen=True)
class Assumption:
    """One thing taken as given: a quantity or a choice, its value in words, and where it came from."""

    name: str
    value: str
    source: str


@dataclass(frozen=True)
class Estimate:
    """What one estimator says about one drive.

    parameters: by name. tracks, traces (fits and residuals), scatters: for the report. used_fraction: how much of the
    drive met the gates. diagnostics: named figures (log-likelihood, residual autocorrelation …). evidence: the
    relations behind it, for the joint posterior; dropped once the verdict is made. distributions: of parameters over the
    drive, where the method knows more of them than an interval.
    """

    estimator: str
    status: RunStatus
    reason: str
    parameters: Mapping[str, ParameterEstimate] = field(default_factory=dict)
    tracks: tuple[Track, ...] = ()
    traces: tuple[Trace, ...] = ()
    scatters: tuple[Scatter, ...] = ()
    assumptions: tuple[Assumption, ...] = ()
    diagnostics: Mapping[str, float] = field(default_factory=dict)
    used_fraction: float = 0.0
    runtime_s: float = 0.0
    witness: bool = False
    evidence: tuple[Evidence, ...] = ()
    distributions: tuple[Distribution, ...] = ()


@dataclass(frozen=True)
class Share:
    """What one relation brought to a parameter. bits: information lost without it. std_without: spread without it.

    std_alone: spread that the prior and this relation alone give.
    """

    relation: str
    bits: float
    std_without: float
    std_alone: float


@dataclass(frozen=True)
class NextMeasurement:
    """What would narrow a parameter: an action in words, and the spread that it would leave."""

    action: str
    std_after: float


@dataclass(frozen=True)
class Learned:
    """What a drive taught of one parameter. bits: log2 of the prior's over the posterior's spread.

    shares: relations by what they brought, the first the most. next: the most helpful first. grid, prior_density,
    density: (n,) for a figure.
    """

    parameter: str
    prior: Prior
    bits: float
    shares: tuple[Share, ...] = ()
    next: tuple[NextMeasurement, ...] = ()
    grid: FloatArray = field(default_factory=lambda: np.zeros(0))
    prior_density: FloatArray = field(default_factory=lambda: np.zeros(0))
    density: FloatArray = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class RelationCheck:
    """Does one relation go with all others and the priors? chi2 of `numbers` figures against what the rest predicts.

    probability: of a misfit as large or larger by chance. widened: factor on its standard deviations for a conflict.
    """

    relation: str
    source: str
    numbers: int
    chi2: float
    probability: float
    widened: float
    text: str


@dataclass(frozen=True)
class JointVerdict:
    """The joint posterior behind the verdict. learned: by parameter. relations: those counted, each checked.

    not_counted: (relation, why). far: unknowns that ended far from what was known, in words. method: how the posterior
    was found ("Laplace", "sampled: …"). runtime_s: of the inference. spoke_for: kinds of springs, tyres or sensors that the drive
    fits and the vehicle file or custom does not have, in words.
    """

    learned: Mapping[str, Learned]
    relations: tuple[RelationCheck, ...]
    not_counted: tuple[tuple[str, str], ...] = ()
    far: tuple[str, ...] = ()
    method: str = ""
    inflation: float = 1.0
    runtime_s: float = 0.0
    spoke_for: tuple[str, ...] = ()
