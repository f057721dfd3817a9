"""What the roll fit minimises: two blocks that take turns (`climb`), the motion's parameters and the noises' levels.

The accelerometer's own noise goes into the simulation and not into the body: noise in a regressor. Left alone it is taken for motion
that the body does not follow, and b, c and the delay came out by four of their bounds too large in a slow slalom, however exact
the filter. Its level is known (the floor of its spectrum), and so what it adds to the squares of the innovations is known for every
motion: that much is taken off (corrected least squares). The weights come from the motion of the turn before, so that the colour of
what is left over decides on weights and on nothing else. The levels come from the whole likelihood, with the motion held.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.model import CLIP, NOISES, Known, Whitener, whitened, whitener
from pipelines.estimators.roll_map.motion import offset_slope, simulated
from pipelines.results import FloatArray

RAN_OFF = 1e6
"""Standard deviations beyond which a motion has run away."""

STANDING = (2.0, 5.0, 12.0)
"""b, in m/s per rad/s, from weak damping to strong, tried in turn where a model runs away from its start."""

QUIET = ("stiffening", "friction", "knee", "lever", "roll_offset", "rate_offset", "yaw_leak", "delay")
"""What a single sample of noise has nothing to do with."""


def named(known: Sequence[Known], x: FloatArray) -> dict[str, float]:
    """Values by name."""
    return {k.name: float(value) for k, value in zip(known, x, strict=True)}


def huber(square: FloatArray) -> FloatArray:
    """Half of normalised squares, with Huber's loss."""
    size = np.sqrt(square)
    return np.asarray(np.where(size <= CLIP, 0.5 * square, CLIP * size - 0.5 * CLIP * CLIP))


def _squares(error: FloatArray, variance: FloatArray) -> float:
    """Half the sum of the normalised squares, with Huber's loss."""
    return float(np.nansum(huber(error * error / variance)))


@dataclass(frozen=True)
class Slopes:
    """At one point: normalised innovations (n, m), their slopes and those of the log variances (p, n, m) in a block's parameters.

    given: (p,) slope of the half of the squares that the input's noise adds.
    """

    normalised: FloatArray
    slope: FloatArray
    growth: FloatArray
    given: FloatArray | None = None

    def scores(self) -> FloatArray:
        """(n, p) the gradient of the log-likelihood, row by row."""
        nu = np.nan_to_num(self.normalised)
        psi = np.clip(nu, -CLIP, CLIP)
        found = -(self.slope * psi + 0.5 * self.growth * (1 - psi * nu)).sum(axis=2).T
        return np.asarray(
            found if self.given is None else found + self.given * self.normalised_rows()[:, None]
        )

    def normalised_rows(self) -> FloatArray:
        """(n,) each row's share of the sum over all rows."""
        there = np.isfinite(self.normalised).any(axis=1)
        return np.asarray(there / max(int(there.sum()), 1))

    def information(self) -> FloatArray:
        """(p, p) expected."""
        flat, growth = self.slope.reshape(len(self.slope), -1), self.growth.reshape(len(self.growth), -1)
        return np.asarray(flat @ flat.T + 0.5 * growth @ growth.T)


class Problem:
    """Cost and slopes of one set of data. motion, levels: places of the two blocks' parameters. outputs: numbers compared."""

    def __init__(self, data: RollData, known: tuple[Known, ...], held: frozenset[str] = frozenset()) -> None:
        """held: parameters that stay where they start."""
        self.data, self.known = data, known
        self.mean = np.array([k.mean for k in known])
        self.weight = np.array([1 / k.std**2 for k in known])
        self.low = np.array([k.low for k in known])
        self.high = np.array([k.high for k in known])
        self.step = np.array([k.step for k in known])
        self.probes = (data.probe(), data.probe(angle=True)) if data.holds_course else (data.probe(),)
        self.clean, self.clean_probes = data.cleaned(), tuple(probe.cleaned() for probe in self.probes)
        self._last: tuple[tuple[tuple[str, float], ...], tuple[Whitener, ...]] | None = None
        self.rows = int(np.isfinite(data.roll if data.has_roll else data.rate).sum())
        usual = named(known, self.near({}))
        none = np.zeros_like(simulated(data, usual))
        self.outputs = int(np.isfinite(whitened(data, usual, none)[1]).sum())
        free = [i for i, k in enumerate(known) if k.name not in held]
        self.motion: IntArray = np.array([i for i in free if known[i].name not in NOISES])
        self.levels: IntArray = np.array([i for i in free if known[i].name in NOISES])

    def near(self, values: Mapping[str, float]) -> FloatArray:
        """A point at these values; a parameter that they do not hold starts at its prior's mean, or off its bound."""
        start = [values.get(k.name, k.mean if k.mean != k.low else k.mean + 0.5 * k.std) for k in self.known]
        return np.asarray(np.clip(np.array(start), self.low, self.high))

    def standing(self, values: Mapping[str, float], weights: Mapping[str, float] | None) -> FloatArray:
        """As `near`, with as much more damping as the motion needs not to run away: weak dampers on tyres settle at once,
        and what is read some time earlier was then beyond all bounds.

        Raises LinAlgError where no damping helps.
        """
        for least in (0.0, *STANDING):
            x = self.near({**values, "b": max(values.get("b", 0.0), least)})
            if math.isfinite(self.cost(x, weights)):
                return x
        raise np.linalg.LinAlgError("the model runs away wherever it starts")

    def prior_cost(self, x: FloatArray) -> float:
        """Minus the log prior."""
        return 0.5 * float(np.sum(self.weight * (x - self.mean) ** 2))

    def whiteners(self, weights: Mapping[str, float]) -> tuple[Whitener, ...]:
        """Of the data, and of each probe, at these weights. A climb asks again and again for the same ones: the last are kept."""
        asked = tuple(weights.items())
        if self._last is None or self._last[0] != asked:
            self._last = asked, tuple(whitener(each, weights) for each in (self.data, *self.probes))
        return self._last[1]

    def innovations(self, x: FloatArray, weights: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
        """Innovations and variances of the motion x, weighed as at `weights`."""
        return self.whiteners(weights)[0](simulated(self.data, named(self.known, x)))

    def stands(self, error: FloatArray, variance: FloatArray) -> bool:
        """Whether a motion did not run away: most outputs compared, none farther off than numbers of any use are.

        Between samples of a channel with holes there are fewer than on them, so that a lag costs some.
        """
        there = variance > 0
        near = np.abs(error[there]) < RAN_OFF * np.sqrt(variance[there])
        return 2 * int(np.count_nonzero(there)) >= self.outputs and bool(near.all())

    def a_sample(self, weights: Mapping[str, float]) -> tuple[float, ...]:
        """Variance of what noise adds to one sample of the input, by probe: of the acceleration, and of the angle in it."""
        of_angle = math.exp(2 * weights.get("log_roll_noise", 0.0)) * self.data.every
        return (math.exp(2 * weights["log_input_noise"]) / self.data.step_s, of_angle)[: len(self.probes)]

    def carried(self, points: Sequence[FloatArray], weights: Mapping[str, float]) -> FloatArray:
        """(k,) what the input's noise adds to the sum of the normalised squares at each point, by the answer to a single sample of it."""
        quiet = dict.fromkeys(QUIET, 0.0)
        total = np.zeros(len(points))
        for probe, whiten, size in zip(
            self.probes, self.whiteners(weights)[1:], self.a_sample(weights), strict=True
        ):
            answers = [simulated(probe, named(self.known, x) | quiet) for x in points]
            error, variance = whiten(np.stack(answers), clip=1e9)
            total += size * np.nansum(error * error / variance, axis=(1, 2))
        return self.rows * self.data.every * total

    def cost(self, x: FloatArray, weights: Mapping[str, float] | None) -> float:
        """Half the squares less what the input's noise adds to them; without weights the whole likelihood. With the prior."""
        # a trial far off may run away: its cost is infinite
        with np.errstate(over="ignore", invalid="ignore"):
            error, variance = self.innovations(x, named(self.known, x) if weights is None else weights)
            if not self.stands(error, variance):
                return math.inf
            value = _squares(error, variance) + self.prior_cost(x)
            if weights is None:
                value += 0.5 * float(np.nansum(np.log(variance)))
            else:
                carried = float(self.carried([x], weights)[0])
                value -= 0.5 * carried if carried < RAN_OFF * self.rows else -math.inf
        return value if math.isfinite(value) else math.inf

    def _moved(self, x: FloatArray, i: int, *, back: bool = False) -> tuple[FloatArray, float]:
        step = float(self.step[i] if (x[i] + self.step[i] <= self.high[i]) != back else -self.step[i])
        other = x.copy()
        other[i] += step
        return other, step

    def of_levels(self, x: FloatArray) -> Slopes:
        """The levels' slopes, which are in the weights alone."""
        here = named(self.known, x)
        miss = simulated(self.data, here)
        error, variance = whitened(self.data, here, miss)
        slope, growth = (np.zeros((len(self.levels), *error.shape)) for _ in range(2))
        for row, i in enumerate(self.levels.tolist()):
            other, step = self._moved(x, i)
            moved, wider = whitened(self.data, named(self.known, other), miss)
            slope[row] = np.nan_to_num((moved - error) / step / np.sqrt(variance))
            growth[row] = np.nan_to_num(np.log(wider / variance) / step)
        return Slopes(error / np.sqrt(variance), slope, growth)

    def _beside(
        self, x: FloatArray, i: int, miss: FloatArray, *, back: bool = False
    ) -> tuple[FloatArray, float, FloatArray]:
        """A point beside x along one parameter, how far off it lies, and what it leaves over. miss: what x does."""
        other, step = self._moved(x, i, back=back)
        added = offset_slope(self.data, self.known[i].name)
        left = simulated(self.data, named(self.known, other)) if added is None else miss - step * added
        return other, step, left

    def of_motion(self, x: FloatArray, weights: Mapping[str, float]) -> Slopes:
        """The motion's slopes; what the input's noise adds is spread over the rows as `given`."""
        places = self.motion.tolist()
        loud = [row for row, i in enumerate(places) if self.known[i].name not in QUIET]
        whiten = self.whiteners(weights)[0]
        miss = simulated(self.data, named(self.known, x))
        with np.errstate(over="ignore", invalid="ignore"):
            beside = [self._beside(x, i, miss) for i in places]
            errors, variance = whiten(np.stack((miss, *(left for _, _, left in beside))))
            carried = self.carried([x, *(beside[row][0] for row in loud)], weights)
        error, noise = errors[0], float(carried[0])
        adds = np.full(len(places), noise)
        adds[loud] = carried[1:]
        slope = np.zeros((len(places), *error.shape))
        given = np.zeros(len(places))
        for row, i in enumerate(places):
            moved, step, more = errors[1 + row], beside[row][1], float(adds[row])
            # beside the last motion that stands only one of the two sides can be looked at
            if not self._can_be_seen(moved, variance, more):
                with np.errstate(over="ignore", invalid="ignore"):
                    other, step, left = self._beside(x, i, miss, back=True)
                    moved = whiten(left)[0]
                    more = float(self.carried([other], weights)[0]) if row in loud else noise
                if not self._can_be_seen(moved, variance, more):
                    continue
            slope[row] = np.nan_to_num((moved - error) / step / np.sqrt(variance))
            given[row] = 0.5 * (more - noise) / step
        return Slopes(error / np.sqrt(variance), slope, np.zeros_like(slope), given)

    def _can_be_seen(self, error: FloatArray, variance: FloatArray, carried: float) -> bool:
        """Whether a motion and what the input's noise adds to it are of any use."""
        with np.errstate(invalid="ignore"):
            return self.stands(error, variance) and abs(carried) < RAN_OFF * self.rows

    def taught_by(self, data: RollData, x: FloatArray, values: Mapping[str, float]) -> FloatArray:
        """(p, n, m) what the motion's parameters do to the normalised innovations of some data, weighed as at x.

        data: with the rows and channels of the problem's, or of one of its probes.
        """
        base = simulated(data, {**named(self.known, x), **values})
        changes = np.empty((len(self.motion), *base.shape))
        for row, i in enumerate(self.motion.tolist()):
            other, step = self._moved(x, i)
            changes[row] = (simulated(data, {**named(self.known, other), **values}) - base) / step
        error, variance = replace(self.whiteners(named(self.known, x))[0], data=data)(changes, clip=1e9)
        return np.nan_to_num(error / np.sqrt(variance))

    def taught(self, x: FloatArray) -> FloatArray:
        """(p, n, m) what the motion's parameters do to the normalised innovations, by the part of the input that is motion.

        The noise of the input teaches nothing: it is left out here, and so is what the parameters do to the weights.
        """
        return self.taught_by(self.clean, x, {})
