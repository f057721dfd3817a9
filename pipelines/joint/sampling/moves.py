"""Moves that leave a density as it is, all points at once: slices along ellipses, and jumps between a mixture's parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipelines.joint.sampling.gaussianity import LogDensity, quiet
from pipelines.joint.sampling.mixture import LOG_2PI, Mixture, log_sum, pick
from pipelines.results import FloatArray

SHRINKS = 6
"""Points tried on an ellipse before a point stays where it is; stopping there keeps the move reversible. With 14 as many effective draws took
a fifth to a third longer: the last few points cost a call each."""


@dataclass(frozen=True)
class Cloud:
    """The points. u: (n, k). value: (n,) log density at them. root: (n,) which first draw each descends from."""

    u: FloatArray
    value: FloatArray
    root: np.ndarray

    def rows(self, index: np.ndarray) -> Cloud:
        """A choice of points, repeats allowed."""
        return Cloud(self.u[index], self.value[index], self.root[index])


class Counted:
    """A log density that counts the rows asked of it."""

    def __init__(self, log_density: LogDensity) -> None:
        self.log_density = log_density
        self.count = 0

    def __call__(self, u: FloatArray) -> FloatArray:
        """(n,) of (n, k), -inf for what is not a number."""
        self.count += u.shape[0]
        return quiet(self.log_density, u)


def powered(u: FloatArray, value: FloatArray, power: float) -> FloatArray:
    """(n,) log of prior N(0, I) times likelihood to a power, from the log density at full power."""
    prior = -0.5 * np.einsum("nk,nk->n", u, u)
    return np.asarray(prior + power * (value - prior))


@dataclass(frozen=True)
class Guide:
    """A density near the one to sample, of which the moves need draws.

    basis: (k, k) orthonormal; x = u basis; the first d columns of x are those that the data inform. inner: their mixture.
    rest, width: (k-d,) mean and standard deviation of the others.
    """

    basis: FloatArray
    inner: Mixture
    rest: FloatArray
    width: FloatArray

    @property
    def informed(self) -> int:
        """d."""
        return int(self.inner.mean.shape[1])

    def log(self, x: FloatArray) -> FloatArray:
        """(n,) log density at the rows of x (n, k)."""
        return self.with_part(x, None)[0]

    def with_part(self, x: FloatArray, rng: np.random.Generator | None) -> tuple[FloatArray, np.ndarray]:
        """(n,) log density at the rows of x (n, k), and a part for each, drawn by its share there (0 without rng)."""
        white = (x[:, self.informed :] - self.rest) / self.width
        shift = float(np.sum(np.log(self.width))) + 0.5 * LOG_2PI * self.rest.size
        each = self.inner.each(x[:, : self.informed])
        part = np.zeros(len(x), dtype=np.intp) if rng is None else pick(each, rng)
        return log_sum(each) - 0.5 * np.einsum("nd,nd->n", white, white) - shift, part

    def centre(self, part: np.ndarray) -> FloatArray:
        """(n, k) centre of each row's part."""
        rest = np.broadcast_to(self.rest, (part.size, self.rest.size))
        return np.hstack([self.inner.mean[part], rest])

    def noise(self, part: np.ndarray, rng: np.random.Generator) -> FloatArray:
        """(n, k) draws about the centre."""
        white = rng.standard_normal((part.size, self.basis.shape[0]))
        d = self.informed
        return np.hstack([self.inner.spread(white[:, :d], part), self.width * white[:, d:]])


Ratio = Callable[[FloatArray], tuple[FloatArray, FloatArray]]


def _ratio(density: LogDensity, guide: Guide, power: float) -> Ratio:
    """x (n, k) -> log density at full power, and log of (density to sample over the guide's), both (n,)."""

    def at(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        u = x @ guide.basis.T
        value = density(u)
        return value, powered(u, value, power) - guide.log(x)

    return at


def slice_move(
    density: LogDensity, guide: Guide, power: float, cloud: Cloud, rng: np.random.Generator
) -> Cloud:
    """One move of each point along an ellipse (Nishihara, Murray & Adams 2014, with a mixture for their Student-t).

    A part is drawn for a point by the parts' shares in the guide at that point; given the part, the target is that
    Gaussian times (density / guide), for which elliptical slice sampling (Murray, Adams & MacKay 2010) is exact.
    """
    at = _ratio(density, guide, power)
    x = cloud.u @ guide.basis
    here, part = guide.with_part(x, rng)
    centre, noise = guide.centre(part), guide.noise(part, rng)
    start = x - centre
    n = x.shape[0]
    level = powered(cloud.u, cloud.value, power) - here + np.log(rng.random(n))
    angle: FloatArray = np.asarray(rng.uniform(0.0, 2 * np.pi, n))
    low, high = angle - 2 * np.pi, angle.copy()
    value, todo = cloud.value.copy(), np.arange(n)
    for _ in range(SHRINKS):
        turn = angle[todo, None]
        tried = centre[todo] + start[todo] * np.cos(turn) + noise[todo] * np.sin(turn)
        new, ratio = at(tried)
        good = ratio > level[todo]
        x[todo[good]], value[todo[good]] = tried[good], new[good]
        todo = todo[~good]
        if todo.size == 0:
            break
        low[todo] = np.where(angle[todo] < 0, angle[todo], low[todo])
        high[todo] = np.where(angle[todo] < 0, high[todo], angle[todo])
        angle[todo] = rng.uniform(low[todo], high[todo])
    return replace(cloud, u=x @ guide.basis.T, value=value)


def jump_move(
    density: LogDensity, guide: Guide, power: float, cloud: Cloud, rng: np.random.Generator
) -> Cloud:
    """Each point tries the same place in another part: as many standard deviations off its centre.

    With the part drawn by its share and the other by its weight, density / guide alone decides: the parts' own densities
    and the stretch from one to the other cancel.
    """
    at = _ratio(density, guide, power)
    x, d = cloud.u @ guide.basis, guide.informed
    here, part = guide.with_part(x, rng)
    other = rng.choice(guide.inner.weight.size, part.size, p=guide.inner.weight)
    there = guide.inner.mean[other] + guide.inner.spread(guide.inner.whiten(x[:, :d], part), other)
    tried = np.hstack([there, x[:, d:]])
    new, ratio = at(tried)
    now = powered(cloud.u, cloud.value, power) - here
    good = np.log(rng.random(part.size)) < ratio - now
    x[good] = tried[good]
    return replace(cloud, u=x @ guide.basis.T, value=np.where(good, new, cloud.value))
