"""First stage: maximum a posteriori of the roll coefficients from the likelihood of the Kalman innovations.

Scoring (Gauss-Newton with the innovations' variances as unknowns too), from several starts; Huber's function keeps
single wild samples from steering. The spread is Laplace's, widened where the innovations are not white: the scores'
covariance with its correlation over time (Newey-West) takes the place of the ideal one wherever it is larger.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.signal import lfilter
from scipy.stats import t as student

from parsers.channels import IntArray
from pipelines.estimators.roll_map.climb import climb, level
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.held_out import FEWEST, SPAN_S
from pipelines.estimators.roll_map.likelihood import Problem, Slopes, named
from pipelines.estimators.roll_map.model import BANK_TIME_S, Known, run
from pipelines.estimators.roll_map.motion import handed_on
from pipelines.estimators.roll_map.open_slope import FRICTION, ROAD
from pipelines.estimators.roll_map.polish import refine
from pipelines.estimators.roll_map.select import Verdict
from pipelines.estimators.roll_map.spectrum import Shifter
from pipelines.estimators.roll_map.spread import coloured_covariance, honest_covariance, long_run_covariance
from pipelines.estimators.roll_map.yaw import OPEN
from pipelines.prepare.bends import LEANING_STD, road_share
from pipelines.results import FloatArray

CORRELATION_S = 2.0
START_ROWS = 3000
MOST_STEPS = 40
START_STEPS = 10
STRAYED = 15.0
"""Nats that the polished answer may cost; more than that means that it ran away (the noise of the squares alone costs up to 8 in a slalom)."""


FRICTION_MPS2, FRICTION_MISSED, UNFITTED_MPS2 = 0.015, 0.4, 0.03
"""Lateral acceleration that friction may be worth beyond what is fitted, m/s² and over that: wheels stick and slide each at a time of its
own, and a delay or the dampers take a part of what they hold (where simulated cars had 0.5 m/s² 0.1 to 0.2 was fitted, and a was 5 to 10 % off).
UNFITTED_MPS2: where the model has none."""

LASTS, FRICTION_LASTING = 0.9, 1.0
"""Share of slow motion from which on friction holds the lean in phase all along, and what may then be missed over what is fitted: braking
and driving off let the wheels go, so that roll alone shows half of it (steady circles on smooth roads had a 2 to 5 % too large by that)."""

UNCHOSEN = 0.025
"""What parts of the model are worth in a that nothing chose, as the motion is too short to hold stretches of it out: slaloms of 6 to 9 s of a
simulator that is not ours read 3 to 7 % off where they said 2."""

BANKED = 0.3
"""How closely the road's bank goes with the lateral acceleration on roads that bank into their bends."""

USUAL_BANK = 0.02
"""rad: spread of the bank along roads."""

INS_LEVEL_S, INS_LEAN = 20.0, 5e-4
"""Over how many seconds a navigation unit levels itself by its accelerometers, and by how much it then leans into a bend that lasts, rad
per m/s² (spread): 0.1 degrees at 3.5 m/s²."""


@dataclass(frozen=True)
class Mixed:
    """Coefficients over several models. mean (k,), covariance (k, k) with the spread between them, between (k, k): that alone."""

    mean: FloatArray
    covariance: FloatArray
    between: FloatArray


@dataclass(frozen=True)
class RollFit:
    """The fit. values: by name. covariance: (p, p) in the order of `known`, with the white-noise one beside it.

    normalised: (n, m) innovations in standard deviations.
    explained: share of the roll signal's variance that the simulation gives (negative where it does worse than none).
    quickness: rad/s, of the input (RMS of its rate over its RMS). doubts: of a, relative: what friction and banked bends
    leave open (`_doubts`). whole_band: see `fit_best`. mixed: of this and other models, None where it stands alone.
    verdict: what spoke for the models' parts. names, handed (k,), jacobian (k, p): the coefficients
    that the second stage takes, and their slopes in the parameters. edges: (k,) rows up to which information (k, p, p) and gradient (k, p) are summed, for the running estimate.
    """

    known: tuple[Known, ...]
    values: Mapping[str, float]
    covariance: FloatArray
    white_covariance: FloatArray
    edges: IntArray
    information: FloatArray
    gradient: FloatArray
    cost: float
    normalised: FloatArray
    explained: float
    quickness: float
    names: tuple[str, ...]
    handed: FloatArray
    jacobian: FloatArray
    steps: int
    converged: bool
    whole_band: bool = False
    mixed: Mixed | None = None
    verdict: Verdict | None = None
    doubts: Mapping[str, float] = field(default_factory=dict)

    def index(self, name: str) -> int:
        """Place of a parameter in the matrices."""
        return [k.name for k in self.known].index(name)

    def std(self, name: str) -> float:
        """Standard deviation of a parameter."""
        i = self.index(name)
        return math.sqrt(self.covariance[i, i])

    @property
    def told(self) -> tuple[FloatArray, FloatArray]:
        """(k,) the coefficients of all models by weight, (k, k) their covariance; the model's own error is not in it."""
        if self.mixed is not None:
            return self.mixed.mean, self.mixed.covariance
        return self.handed, np.asarray(self.jacobian @ self.covariance @ self.jacobian.T)


def _part(data: RollData, most: int) -> RollData:
    """Up to `most` rows from the first segment on in which every channel is there, for finding where to start."""
    if data.size <= most:
        return data
    channels = [c for c, there in ((data.roll, data.has_roll), (data.rate, data.has_rate)) if there]
    heard = [
        all(np.isfinite(c[i:j]).any() for c in channels) for i, j in zip(data.starts, data.stops, strict=True)
    ]
    first = int(data.starts[heard.index(True)]) if any(heard) else 0
    stops = np.minimum(data.stops, first + most)
    later = (data.starts >= first) & (stops > data.starts)
    long = stops - data.starts >= min(50, most // 2)
    whole = later & long if (later & long).any() else later
    starts, stops = data.starts[whole] - first, stops[whole] - first
    rows = slice(first, first + int(stops[-1]))
    accel = data.accel[rows]
    return replace(
        data,
        rows=data.rows[rows],
        starts=starts,
        stops=stops,
        accel=accel,
        roll=data.roll[rows],
        rate=data.rate[rows],
        whole_roll=data.whole_roll[rows],
        whole_rate=data.whole_rate[rows],
        yaw=data.yaw[rows],
        shifter=(sent := Shifter(accel, starts, stops, 1 / data.step_s, held=True)),
        clean_shifter=sent,
        yaw_shifter=Shifter(data.yaw[rows], starts, stops, 1 / data.step_s, held=True)
        if data.has_yaw
        else None,
    )


def _starts(problem: Problem) -> list[FloatArray]:
    """Starting points: the angle's slope over the acceleration gives a; c and b around those of cars."""
    data = problem.data
    first = problem.mean.copy()
    names = [k.name for k in problem.known]
    for noise in ("log_roll_noise", "log_rate_noise"):
        if noise in names:
            column = data.roll if noise == "log_roll_noise" else data.rate
            there = column[np.isfinite(column)]
            # a channel that begins later is as usual here
            if len(there):
                first[names.index(noise)] = math.log(max(0.1 * float(np.std(there)), 2e-5))
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


def _few_banks(data: RollData) -> float:
    """By how much variances grow where bank and motion are equally slow (a slow circle).

    Three parameters (slope, its curve, offset) then take up part of few independent stretches of bank, whose spread
    comes out too small by that (the correction that a restricted likelihood makes), and is itself known from few:
    Student's interval in place of the normal one.
    """
    free = max(data.size * data.step_s / BANK_TIME_S, 5.0) - 3
    grown = (1 + 3 / free) * float(student.ppf(0.975, free) / 1.96) ** 2
    # it takes a slow motion and a slow bank: a manoeuvre with a few slow moments keeps what its quick ones teach
    return 1 + data.slow_share**2 * (grown - 1)


def _doubts(data: RollData, values: Mapping[str, float], explained: float) -> dict[str, float]:
    """Relative spread of a that the likelihood does not know of: by friction, and by roads.

    Dry friction holds part of a small motion back, in phase with it, and one amplitude cannot tell how much. Roads bank
    into their bends: an angle against the horizon holds a bank that goes with the lateral acceleration, which looks like
    softer or stiffer springs by its share of the roll. explained: share of the angle's variance that is the springs'.
    """
    spread = max(float(np.std(data.accel)), 1e-6)
    held = values.get("friction")
    lasting = min(max((data.slow_share - LASTS) / (1 - LASTS), 0.0), 1.0)
    share = FRICTION_MISSED + (FRICTION_LASTING - FRICTION_MISSED) * lasting
    missed = UNFITTED_MPS2 if held is None else math.hypot(FRICTION_MPS2, share * held)
    unchosen = UNCHOSEN if len(data.taken[0]) * data.every * data.step_s < FEWEST * SPAN_S else 0.0
    friction = math.hypot(missed / spread, unchosen)
    if data.against_axles:
        return {FRICTION: friction}
    roll = spread / max(values["a"], 1e-6)
    # bends last: a bank that goes with them is as slow as they are, and a slalom's are too quick for it
    slow = math.sqrt(min(max(data.slow_share, 0.0), 1.0))
    # a roll rate alone holds the banks' rates, and shows nothing of how large they are
    bank = math.exp(values["log_bank"]) if "log_bank" in values else USUAL_BANK
    if data.has_roll:
        # the fit knows a bank by how it changes from sample to sample: of one that wanders slowly and smoothly that is a small part,
        # and the rest is in what the springs leave of the angle
        left = math.sqrt(min(max(1 - explained, 0.0), 1.0)) * float(np.nanstd(data.roll))
        bank = max(bank, left)
    # a lean that goes with the bends altogether is no bank that the fit could find: it is in the angle as the springs' part is
    road = road_share(data.yaw if data.has_yaw else None, data.accel, data.step_s, data.starts)
    leant = INS_LEAN * values["a"] * _lasting(data) if data.has_roll else 0.0
    return {
        FRICTION: friction,
        ROAD: math.hypot(BANKED * slow * bank / roll, LEANING_STD * slow**2 * road, leant),
    }


def _lasting(data: RollData) -> float:
    """What a navigation unit's level takes for gravity of a lateral acceleration that lasts, over all of it: 1 in an endless bend."""
    share = min(data.step_s / INS_LEVEL_S, 1.0)
    held = np.concatenate(
        [
            lfilter([share], [1, share - 1], data.accel[start:stop])
            for start, stop in zip(data.starts, data.stops, strict=True)
        ]
    )
    accel = np.concatenate(
        [data.accel[start:stop] for start, stop in zip(data.starts, data.stops, strict=True)]
    )
    return float(abs(held @ accel) / max(accel @ accel, 1e-9))


def _explained(data: RollData, values: Mapping[str, float]) -> float:
    """How much of the first channel's variance the model makes of the acceleration alone; 0 for a dead channel."""
    miss = run(data, values)[2][:, 0]
    measured = data.roll if data.has_roll else data.rate
    variance = float(np.nanvar(measured))
    return 1 - float(np.nanvar(miss)) / variance if variance > 1e-14 else 0.0


def _summed(problem: Problem, taught: FloatArray) -> FloatArray:
    """(p, p) of all parameters, from the slopes of the motion's over some rows."""
    flat = taught.reshape(len(taught), -1)
    found = np.zeros((len(problem.known), len(problem.known)))
    found[np.ix_(problem.motion, problem.motion)] = flat @ flat.T
    return found


def _covariances(
    problem: Problem, x: FloatArray, taught: FloatArray, slopes: Slopes
) -> tuple[FloatArray, FloatArray]:
    """(p, p) of all parameters: of white noise, and the honest one. The levels stand for themselves."""
    motion, levels = problem.motion, problem.levels
    data = problem.data
    lags = round(CORRELATION_S / (data.step_s * data.every))
    taken = data.taken[0]
    white, wide = (np.zeros((len(x), len(x))) for _ in range(2))
    of_levels = problem.of_levels(x).information() + np.diag(problem.weight[levels])
    for matrix in (white, wide):
        matrix[np.ix_(levels, levels)] = np.linalg.inv(of_levels)
    flat = taught.reshape(len(taught), -1)
    block = np.ix_(motion, motion)
    white[block], wide[block] = honest_covariance(
        flat @ flat.T,
        problem.weight[motion],
        coloured_covariance(taught, slopes.normalised),
        long_run_covariance(slopes.scores()[taken], lags),
        1.5 * len(taken) / (lags + 1),
        float(np.clip(data.slow_share, 0.0, 1.0)),
    )
    wide[block] *= _few_banks(data)
    for matrix in (white, wide):
        _open_lever(problem, matrix)
    return white, wide


def _open_lever(problem: Problem, covariance: FloatArray) -> None:
    """Add, in place, what the lever's open part does to the others: they follow it by their covariance with it over its variance."""
    names = [k.name for k in problem.known]
    if "lever" in names:
        i = names.index("lever")
        follow = covariance[:, i] / covariance[i, i]
        covariance += OPEN**2 * np.outer(follow, follow)


def _cold_start(data: RollData, known: tuple[Known, ...]) -> FloatArray:
    """Three starts on a part of the data, the best of them."""
    part = Problem(_part(data, START_ROWS), known)
    tried = [climb(part, start, START_STEPS, 1)[0] for start in _starts(part)]
    return min(tried, key=lambda x: part.cost(x, None))


def _point(
    problem: Problem, near: Mapping[str, float] | None, *, close: bool
) -> tuple[FloatArray, int, bool]:
    """Where the fit ends, the steps and whether it settled. In the whole band by instruments (`refine`) where they lead anywhere."""
    data, known = problem.data, problem.known
    start = _cold_start(data, known) if near is None else problem.standing(near, None)
    if data.whole and near is not None:
        moved, steps, settled = refine(problem, start, MOST_STEPS)
        if settled or close:
            return moved, steps, settled
    # a start found on a part of the drive knows that part's noises: with them half an hour's motion ran to b's bound
    x, _, first = level(problem, start, MOST_STEPS) if near is None else (start, 0.0, 0)
    x, steps, converged = climb(problem, x, MOST_STEPS)
    steps += first
    if not data.whole:
        return x, steps, converged
    moved, more, settled = refine(problem, x, MOST_STEPS)
    weights = named(known, x)
    if settled and problem.cost(moved, weights) < problem.cost(x, weights) + STRAYED:
        return moved, steps + more, True
    return x, steps + more, converged


def fit_roll(
    data: RollData,
    known: tuple[Known, ...],
    edges: IntArray,
    near: Mapping[str, float] | None = None,
    *,
    close: bool = False,
) -> RollFit:
    """Fit. `edges` are rows up to which the running sums are wanted (the last is the data's size).

    near: values to start from (a part of the model that they do not hold starts at its prior); else the start is sought. close: whether
    the end is close to them or of no use, so that it is not sought farther off.
    Raises LinAlgError for a model that runs away wherever it starts.
    """
    problem = Problem(data, known)
    x, steps, converged = _point(problem, near, close=close)
    slopes = problem.of_motion(x, named(known, x))
    taught = problem.taught(x)
    scores = slopes.scores()
    explained = _explained(data, named(known, x))
    doubts = _doubts(data, named(known, x), explained)
    white, wide = _covariances(problem, x, taught, slopes)
    values = named(known, x)
    names, handed, jacobian = handed_on(data, values, tuple(k.name for k in known))
    pieces = list(itertools.pairwise([0, *(int(edge) for edge in edges)]))
    information = np.cumsum([_summed(problem, taught[:, i:j]) for i, j in pieces], axis=0)
    gradient = np.zeros((len(pieces), len(known)))
    gradient[:, problem.motion] = np.cumsum([scores[i:j].sum(axis=0) for i, j in pieces], axis=0)
    return RollFit(
        known=known,
        values=values,
        covariance=wide,
        white_covariance=white,
        edges=edges,
        information=information,
        gradient=gradient,
        cost=problem.cost(x, None),
        normalised=slopes.normalised,
        explained=explained,
        quickness=data.quickness,
        doubts=doubts,
        names=names,
        handed=handed,
        jacobian=jacobian,
        steps=steps,
        converged=converged,
    )
