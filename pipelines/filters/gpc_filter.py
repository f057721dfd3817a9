"""gPC-EKF for any state-space model: what is uncertain, how the filter is set, and what it found (dissertation 3.2, 3.4).

The three improvements of 3.4 are each a setting: the covariance addition (49) is `GpcSettings.state_addition`, the additions
to the parameters' distributions (51), (58) are `Uncertain.addition` with its distribution `Uncertain.update`, and the noise on
the first states (52) is `Uncertain.start_noise`. None of them is needed with the square-root form, which keeps the spread.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from parsers.channels import IntArray
from pipelines.chaos.bases import Basis, legendre
from pipelines.chaos.collocation import WORST_CONDITION, Collocation, collocate
from pipelines.chaos.space import Space
from pipelines.filters.gpc_state_space import FilterArrays, Record, Work
from pipelines.filters.gpc_update import PUBLISHED, SQUARE_ROOT
from pipelines.results import FloatArray

LEGENDRE = legendre()
"""Uniform on -1..1: the basis of a quantity of which no more is said."""

Run = Callable[[FloatArray, FloatArray, FloatArray, IntArray, FilterArrays, Work, Record], int]


@dataclass(frozen=True)
class StateSpaceModel:
    """A model with its compiled filter. outputs: all that can be measured, in the order of their numbers.

    An output whose place is that of a state is that state (the addition (49) needs to know).
    """

    name: str
    states: tuple[str, ...]
    parameters: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    run: Run


@dataclass(frozen=True)
class Uncertain:
    """A state at the start, or a parameter: value = mean + spread mu, with mu the variable of `basis`.

    logarithm: value = exp(log(mean) + spread mu) instead: always positive, spread and addition are relative.
    addition: put on the distribution at each sample, times what `update` makes of mu (Q,) at the points ((51), (58); None: mu
    itself). start_noise: (52), standard deviation and mean of the noise on each coefficient before the first sample.
    With spread and addition 0 it is known. The printed m1, m2 and c1 are mean, spread and addition.
    """

    mean: float
    spread: float = 0.0
    basis: Basis = LEGENDRE
    logarithm: bool = False
    addition: float = 0.0
    update: Callable[[FloatArray], FloatArray] | None = None
    start_noise: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse what no distribution has."""
        numbers = (self.mean, self.spread, self.addition, *self.start_noise)
        if not all(np.isfinite(number) for number in numbers):
            raise ValueError("mean, spread, addition and noise are finite numbers")
        if self.logarithm and self.mean <= 0:
            raise ValueError(f"a quantity kept as its logarithm is positive, not {self.mean:g}")

    @property
    def varies(self) -> bool:
        """Whether it has a variable of its own."""
        return self.spread != 0 or self.addition != 0

    @property
    def centre(self) -> float:
        """The mean as the filter keeps it."""
        return float(np.log(self.mean)) if self.logarithm else self.mean


@dataclass(frozen=True)
class GpcSettings:
    """How the filter is set. order: of the expansion (PO). factor: points = factor x S (the tables' Q).

    noise: variance R of each measured output. form: `gpc_update`'s. state_addition: c of (49), on states and parameters
    alike. keep_every: samples between kept coefficients; 0: none. worst_condition: of the collocation matrix.
    """

    noise: tuple[float, ...]
    order: int = 2
    factor: float = 4.0
    form: int = SQUARE_ROOT
    state_addition: float = 0.0
    keep_every: int = 0
    worst_condition: float = WORST_CONDITION


@dataclass(frozen=True)
class StateSpaceRun:
    """What the filter found. Rows past `done` are NaN: the filter lost itself there.

    mean, std: (rows, n), states then parameters, of the logarithm where `logarithm` says so; innovation, innovation_std:
    (rows, m). coefficients: (kept, n, S). start_std: (n,) before the first sample.
    """

    names: tuple[str, ...]
    logarithm: tuple[bool, ...]
    time_s: FloatArray
    mean: FloatArray
    std: FloatArray
    innovation: FloatArray
    innovation_std: FloatArray
    coefficients: FloatArray
    collocation: Collocation
    start_std: FloatArray
    done: int

    @property
    def diverged(self) -> bool:
        """Whether the filter lost itself (no finite numbers any more)."""
        return self.done < len(self.time_s)

    def value(self, name: str) -> FloatArray:
        """The estimate over time, (rows,); of a logarithm its exponential (the median)."""
        i = self.names.index(name)
        return np.exp(self.mean[:, i]) if self.logarithm[i] else self.mean[:, i]

    def interval(self, name: str, widths: float = 1.96, factor: float = 1.0) -> tuple[FloatArray, FloatArray]:
        """mean -+ widths x factor standard deviations over time, each (rows,)."""
        i = self.names.index(name)
        half = widths * factor * self.std[:, i]
        low, high = self.mean[:, i] - half, self.mean[:, i] + half
        return (np.exp(low), np.exp(high)) if self.logarithm[i] else (low, high)


def _check(
    model: StateSpaceModel,
    rows: int,
    outputs: int,
    given: tuple[FloatArray, FloatArray],
    settings: GpcSettings,
) -> None:
    inputs, measured = given
    if inputs.shape != (rows, len(model.inputs)) or measured.shape != (rows, outputs) or rows < 1:
        raise ValueError(
            f"{rows} rows: inputs are (rows, {len(model.inputs)}), measured (rows, {outputs}), not {inputs.shape} and {measured.shape}"
        )
    if not np.isfinite(inputs).all():
        raise ValueError("the inputs have values that are not finite; fill or cut them first")
    if len(settings.noise) != outputs or not all(np.isfinite(r) and r > 0 for r in settings.noise):
        raise ValueError("a noise variance above 0 for each output")
    if settings.form not in (PUBLISHED, SQUARE_ROOT):
        raise ValueError("the form is 0 (published) or 1 (square root)")
    if settings.state_addition < 0:
        raise ValueError("the covariance addition is 0 or more")


def start_coefficients(
    variables: tuple[Uncertain, ...], collocation: Collocation, rng: np.random.Generator | None
) -> tuple[FloatArray, FloatArray]:
    """Coefficients at the start and what is added at each sample, each (n, S). ValueError for noise without a generator."""
    inverse = collocation.inverse
    x = np.zeros((len(variables), len(inverse)))
    additions = np.zeros_like(x)
    place = 0
    for i, variable in enumerate(variables):
        x[i, 0] = variable.centre
        if variable.varies:
            mu = collocation.points[:, place]
            place += 1
            x[i] += variable.spread * (inverse @ mu)
            shape = mu if variable.update is None else np.asarray(variable.update(mu), dtype=float)
            if shape.shape != mu.shape:
                raise ValueError("the update of a distribution is one value for each point")
            additions[i] = variable.addition * (inverse @ shape)
        mean, std = variable.start_noise
        if std:
            if rng is None:
                raise ValueError("noise at the start needs a generator")
            x[i] += mean + std * rng.standard_normal(len(inverse))
        elif mean:
            x[i] += mean
    return x, additions


def estimate_state_space(
    model: StateSpaceModel,
    inputs: FloatArray,
    measured: FloatArray,
    step_s: float,
    states: tuple[Uncertain, ...],
    parameters: tuple[Uncertain, ...],
    settings: GpcSettings,
    *,
    outputs: tuple[str, ...] = ("position",),
    rng: np.random.Generator | None = None,
    remember_start: bool = False,
) -> StateSpaceRun:
    """Run a model's gPC-EKF over measured data.

    inputs (rows, inputs of the model), finite; measured (rows, outputs), NaN where there is nothing; step_s: of a sample.
    states, parameters: one Uncertain each, in the model's order. outputs: names of what the columns of `measured` are.
    Raises ValueError where they do not fit, ExpansionError for an expansion that is too large or badly conditioned.
    """
    if len(states) != len(model.states) or len(parameters) != len(model.parameters):
        raise ValueError(f"{model.name} has the states {model.states} and the parameters {model.parameters}")
    if step_s <= 0:
        raise ValueError("the step is above 0")
    if unknown := [name for name in outputs if name not in model.outputs]:
        raise ValueError(f"{model.name} has no output {unknown[0]!r}; it has {', '.join(model.outputs)}")
    kinds = np.array([model.outputs.index(name) for name in outputs], dtype=np.int64)
    rows, count, variables = len(measured), len(outputs), (*states, *parameters)
    _check(model, rows, count, (inputs, measured), settings)
    bases = tuple(variable.basis for variable in variables if variable.varies) or (legendre(),)
    collocation = collocate(
        Space(bases), settings.order, factor=settings.factor, worst_condition=settings.worst_condition
    )
    x, additions = start_coefficients(variables, collocation, rng)
    logs = np.array([float(variable.logarithm) for variable in variables])
    names = (*model.states, *model.parameters)
    if remember_start:
        x, names = np.vstack([x, x[: len(states)]]), (*names, *(f"first {name}" for name in model.states))
        additions, logs = (
            np.vstack([additions, np.zeros_like(x[: len(states)])]),
            np.append(logs, np.zeros(len(states))),
        )
    start_std = np.sqrt(np.sum(x[:, 1:] ** 2, axis=1))
    arrays = _arrays(logs, additions, collocation, kinds, settings, step_s, len(states))
    terms = x.shape[1]
    kept = 0 if settings.keep_every < 1 else (rows + settings.keep_every - 1) // settings.keep_every
    record = Record(
        np.full((rows, len(x)), np.nan), np.full((rows, len(x)), np.nan), np.full((rows, count), np.nan),
        np.full((rows, count), np.nan), np.full((kept, len(x), terms), np.nan), max(1, settings.keep_every),
    )  # fmt: skip
    work = Work(np.zeros((count, terms)), np.zeros((count, count + 4)), np.zeros(count), np.zeros(count))
    done = model.run(x, _column(inputs), _column(measured), kinds, arrays, work, record)
    return StateSpaceRun(
        names, tuple(bool(log) for log in logs),
        np.asarray(np.arange(rows) * step_s), record.mean, record.std, record.innovation, record.innovation_std,
        record.coefficients, collocation, start_std, int(done),
    )  # fmt: skip


def _column(values: FloatArray) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64)


def _arrays(
    logs: FloatArray, additions: FloatArray, collocation: Collocation, kinds: IntArray,
    settings: GpcSettings, step_s: float, states: int,
) -> FilterArrays:  # fmt: skip
    cross, inner = np.empty((0, 0)), np.empty((0, 0))
    if settings.state_addition > 0:
        select = (np.arange(len(logs))[:, None] == kinds[None, :]) & (kinds < states)[None, :]
        cross = settings.state_addition * select
        inner = settings.state_addition * (select.T @ select.astype(float))
    return FilterArrays(
        _column(collocation.matrix.T), _column(collocation.inverse.T), additions, logs, np.array(settings.noise, dtype=float),
        _column(cross), _column(inner), states, settings.form, float(step_s),
    )  # fmt: skip


def row(values: Any) -> FloatArray:
    """A single input or output as a column, (rows,) -> (rows, 1)."""
    return np.asarray(values, dtype=np.float64)[:, None]
