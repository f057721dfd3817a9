"""First stage: maximum a posteriori of the roll coefficients from the likelihood of the Kalman innovations.

Scoring (Gauss-Newton with the innovations' variances as unknowns too), from several starts; Huber's function keeps
single wild samples from steering. The spread is Laplace's, widened where the innovations are not white: the scores'
covariance with its correlation over time (Newey-West) takes the place of the ideal one wherever it is larger.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student

from parsers.channels import IntArray
from pipelines.estimators.roll_map.data import RollData, Shifter
from pipelines.estimators.roll_map.model import BANK_TIME_S, CLIP, Known, friction_damping, run
from pipelines.results import FloatArray

CORRELATION_S = 2.0
START_ROWS = 3000
MOST_STEPS = 40
SETTLED = 0.01
START_STEPS = 10


FRICTION_MPS2 = 0.08
BANKED = 0.12
"""FRICTION_MPS2: lateral acceleration that friction may be worth beyond what is fitted. BANKED: how closely the road's bank
goes with the lateral acceleration on roads that bank into their bends."""


@dataclass(frozen=True)
class RollFit:
    """The fit. values: by name. covariance: (p, p) in the order of `known`, with the white-noise one beside it.

    scores: (n, p) the log-likelihood's gradient, row by row. normalised: (n, m) innovations in standard deviations.
    explained: share of the roll signal's variance that the simulation gives (negative where it does worse than none).
    quickness: rad/s, of the input (RMS of its rate over its RMS). doubt: of a, relative: what friction and banked bends leave
    open (`_doubt`). friction_damping:
    linear damping (of b) that a unit of friction is worth over the drive. edges: (k,) rows up to which information (k, p, p) and gradient (k, p) are summed, for the running estimate.
    """

    known: tuple[Known, ...]
    values: Mapping[str, float]
    covariance: FloatArray
    white_covariance: FloatArray
    scores: FloatArray
    edges: IntArray
    information: FloatArray
    gradient: FloatArray
    cost: float
    normalised: FloatArray
    explained: float
    quickness: float
    doubt: float
    friction_damping: float
    steps: int
    converged: bool

    def index(self, name: str) -> int:
        """Place of a parameter in the matrices."""
        return [k.name for k in self.known].index(name)

    def std(self, name: str) -> float:
        """Standard deviation of a parameter."""
        i = self.index(name)
        return math.sqrt(self.covariance[i, i])


def _named(known: Sequence[Known], x: FloatArray) -> dict[str, float]:
    return {k.name: float(value) for k, value in zip(known, x, strict=True)}


def _cost(error: FloatArray, variance: FloatArray) -> float:
    """Minus the log-likelihood (without its constant), with Huber's loss."""
    square = error * error / variance
    size = np.sqrt(square)
    loss = np.where(size <= CLIP, 0.5 * square, CLIP * size - 0.5 * CLIP * CLIP)
    return float(np.nansum(loss) + 0.5 * np.nansum(np.log(variance)))


class _Problem:
    """Cost, gradient and information of one set of data."""

    def __init__(self, data: RollData, known: tuple[Known, ...]) -> None:
        self.data, self.known = data, known
        self.mean = np.array([k.mean for k in known])
        self.weight = np.array([1 / k.std**2 for k in known])
        self.low = np.array([k.low for k in known])
        self.high = np.array([k.high for k in known])
        self.step = np.array([k.step for k in known])

    def prior_cost(self, x: FloatArray) -> float:
        return 0.5 * float(np.sum(self.weight * (x - self.mean) ** 2))

    def run(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        return run(self.data, _named(self.known, x))[:2]

    def cost(self, x: FloatArray) -> float:
        error, variance = self.run(x)
        value = _cost(error, variance) + self.prior_cost(x)
        return value if math.isfinite(value) else math.inf

    def jacobians(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Slopes (p, n, m) of the normalised innovations and of their log variances, and the innovations (n, m)."""
        error, variance = self.run(x)
        spread = np.sqrt(variance)
        slope = np.empty((len(x), *error.shape))
        growth = np.empty_like(slope)
        for i, step in enumerate(self.step):
            moved = x.copy()
            moved[i] += step if x[i] + step <= self.high[i] else -step
            other, wider = self.run(moved)
            slope[i] = np.nan_to_num((other - error) / (moved[i] - x[i]) / spread)
            growth[i] = np.nan_to_num((np.log(wider) - np.log(variance)) / (moved[i] - x[i]))
        return slope, growth, error / spread

    def scores(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Scores (n, p) of the data, then what `jacobians` gives."""
        slope, growth, normalised = self.jacobians(x)
        nu = np.nan_to_num(normalised)
        psi = np.clip(nu, -CLIP, CLIP)
        scores = -(slope * psi + 0.5 * growth * (1 - psi * nu)).sum(axis=2).T
        # a missing output has no variance, hence no score: its growth is zero already
        return scores, slope, growth, normalised


def _information(slope: FloatArray, growth: FloatArray) -> FloatArray:
    """(p, p) expected information of a stretch of rows."""
    flat, flat_growth = slope.reshape(len(slope), -1), growth.reshape(len(growth), -1)
    return np.asarray(flat @ flat.T + 0.5 * flat_growth @ flat_growth.T)


def _climb(problem: _Problem, x: FloatArray, most: int) -> tuple[FloatArray, float, int, bool]:
    """Damped scoring from x. Returns the point, its cost, the steps taken, and whether it settled."""
    cost = problem.cost(x)
    damping = 1e-3
    for count in range(most):
        scores, slope, growth, _ = problem.scores(x)
        information = _information(slope, growth)
        gradient = scores.sum(axis=0) - problem.weight * (x - problem.mean)
        curvature = information + np.diag(problem.weight)
        scale = np.sqrt(np.diag(curvature))
        gained = 0.0
        for _ in range(12):
            matrix = curvature / np.outer(scale, scale) + damping * np.eye(len(x))
            move = np.linalg.solve(matrix, gradient / scale) / scale
            trial = np.clip(x + move, problem.low, problem.high)
            trial_cost = problem.cost(trial)
            if trial_cost < cost:
                gained = cost - trial_cost
                x, cost = trial, trial_cost
                damping = max(damping / 8, 1e-9)
                break
            damping = max(damping, 1e-6) * 8
        if gained < SETTLED:
            return x, cost, count + 1, True
    return x, cost, most, False


def _part(data: RollData, most: int) -> RollData:
    """The first segments up to `most` rows, for finding where to start."""
    if data.size <= most:
        return data
    stops = np.minimum(data.stops, most)
    whole = stops - data.starts >= min(50, most // 2)
    starts, stops = data.starts[whole], stops[whole]
    n = int(stops[-1])
    accel = data.accel[:n]
    return replace(
        data,
        rows=data.rows[:n],
        starts=starts,
        stops=stops,
        accel=accel,
        roll=data.roll[:n],
        rate=data.rate[:n],
        whole_roll=data.whole_roll[:n],
        whole_rate=data.whole_rate[:n],
        yaw=data.yaw[:n],
        shifter=Shifter(accel, starts, stops, 1 / data.step_s, held=True),
        yaw_shifter=Shifter(data.yaw[:n], starts, stops, 1 / data.step_s, held=True)
        if data.has_yaw
        else None,
    )


def _starts(problem: _Problem) -> list[FloatArray]:
    """Starting points: the angle's slope over the acceleration gives a; c and b around those of cars."""
    data = problem.data
    first = problem.mean.copy()
    names = [k.name for k in problem.known]
    for noise in ("log_roll_noise", "log_rate_noise"):
        if noise in names:
            column = data.roll if noise == "log_roll_noise" else data.rate
            first[names.index(noise)] = math.log(max(0.1 * float(np.nanstd(column)), 2e-5))
    if data.has_roll:
        good = np.isfinite(data.roll)
        f, angle = data.accel[good] - data.accel[good].mean(), data.roll[good]
        slope = float(f @ angle / max(f @ f, 1e-9))
        first[0] = min(max(1 / slope if slope > 1e-3 else 300.0, 20.0), 400.0)
        first[names.index("roll_offset")] = float(angle.mean()) - float(data.accel[good].mean()) / first[0]
    starts = []
    for b, c in ((6.0, 0.8), (10.0, 0.4), (4.0, 1.5)):
        x = first.copy()
        x[1], x[2] = b, c
        starts.append(np.clip(x, problem.low + 1e-9, problem.high - 1e-9))
    return starts


def _long_run_covariance(scores: FloatArray, lags: int) -> FloatArray:
    """Sum of the scores' autocovariances up to `lags`, with Bartlett's weights (Newey-West): (p, p).

    Triangular weights are those of sums over windows of lags + 1 rows, so that no lag need be taken on its own.
    """
    centred = scores - scores.mean(axis=0)
    window = lags + 1
    nothing = np.zeros((window, scores.shape[1]))
    running = np.cumsum(np.concatenate((nothing, centred, nothing[1:])), axis=0)
    sums = running[window:] - running[:-window]
    return np.asarray(sums.T @ sums / window)


def _honest_covariance(
    information: FloatArray, prior: FloatArray, long_run: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Laplace's covariance, and the same widened in every direction in which the scores vary more than ideal."""
    curvature = information + np.diag(prior)
    scale = 1 / np.sqrt(np.diag(curvature))
    values, vectors = np.linalg.eigh(curvature * np.outer(scale, scale))
    root = (vectors / np.sqrt(np.maximum(values, 1e-12))).T * scale
    ratio = root @ (long_run + np.diag(prior)) @ root.T
    spread, axes = np.linalg.eigh(0.5 * (ratio + ratio.T))
    widened = axes @ np.diag(np.maximum(spread, 1.0)) @ axes.T
    return np.asarray(root.T @ root), np.asarray(root.T @ widened @ root)


def _few_banks(data: RollData) -> float:
    """By how much variances grow where bank and motion are equally slow (a slow circle).

    Three parameters (slope, its curve, offset) then take up part of few independent stretches of bank, whose spread
    comes out too small by that (the correction that a restricted likelihood makes), and is itself known from few:
    Student's interval in place of the normal one.
    """
    free = max(data.size * data.step_s / BANK_TIME_S, 5.0) - 3
    grown = (1 + 3 / free) * float(student.ppf(0.975, free) / 1.96) ** 2
    return 1 + data.slow_share * (grown - 1)


def _doubt(data: RollData, values: Mapping[str, float]) -> float:
    """Relative spread of a that the likelihood does not know of.

    Dry friction holds part of a small motion back, in phase with it, and one amplitude cannot tell how much. Roads bank
    into their bends: an angle against the horizon holds a bank that goes with the lateral acceleration, which looks like
    softer or stiffer springs by its share of the roll.
    """
    spread = max(float(np.std(data.accel)), 1e-6)
    friction = FRICTION_MPS2 / spread
    if data.against_axles or "log_bank" not in values:
        return friction
    roll = spread / max(values["a"], 1e-6)
    # bends last: a bank that goes with them is as slow as they are, and a slalom's are too quick for it
    slow = math.sqrt(min(max(data.slow_share, 0.0), 1.0))
    return math.hypot(friction, BANKED * slow * math.exp(values["log_bank"]) / roll)


def _explained(data: RollData, values: Mapping[str, float]) -> float:
    """How much of the first channel's variance the model makes of the acceleration alone; 0 for a dead channel."""
    miss = run(data, values)[2][:, 0]
    measured = data.roll if data.has_roll else data.rate
    variance = float(np.nanvar(measured))
    return 1 - float(np.nanvar(miss)) / variance if variance > 1e-14 else 0.0


def fit_roll(data: RollData, known: tuple[Known, ...], edges: IntArray) -> RollFit:
    """Fit; `edges` are rows up to which the running sums are wanted (the last is the data's size). Three starts on a part of the data, the best of them on all of it."""
    part = _Problem(_part(data, START_ROWS), known)
    tried = [_climb(part, start, START_STEPS) for start in _starts(part)]
    best = min(tried, key=lambda item: item[1])[0]
    problem = _Problem(data, known)
    x, cost, steps, converged = _climb(problem, best, MOST_STEPS)
    scores, slope, growth, normalised = problem.scores(x)
    cuts = [0, *(int(edge) for edge in edges)]
    pieces = list(itertools.pairwise(cuts))
    information = np.cumsum([_information(slope[:, i:j], growth[:, i:j]) for i, j in pieces], axis=0)
    gradient = np.cumsum([scores[i:j].sum(axis=0) for i, j in pieces], axis=0)
    lags = round(CORRELATION_S / data.step_s)
    white, wide = _honest_covariance(information[-1], problem.weight, _long_run_covariance(scores, lags))
    wide = wide * _few_banks(data)
    return RollFit(
        known=known,
        values=_named(known, x),
        covariance=wide,
        white_covariance=white,
        scores=scores,
        edges=edges,
        information=information,
        gradient=gradient,
        cost=cost,
        normalised=normalised,
        explained=_explained(data, _named(known, x)),
        quickness=data.quickness,
        doubt=_doubt(data, _named(known, x)),
        friction_damping=friction_damping(data, _named(known, x)),
        steps=steps,
        converged=converged,
    )
