"""The ways to estimate on the bench: with a domain that follows, over the fixed support, and with the log likelihood expanded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.bayes.priors import Known, Priors, Uniform
from pipelines.bayes.sequence import Choice, Found, estimate
from pipelines.bayes.surrogate import box, collocation_for
from pipelines.chaos.collocation import hammersley
from pipelines.models.base_excitation_3dof import corner_response
from pipelines.reproduce.gpc_map.setup import (
    NAMES,
    NOISE_MPS2,
    RATE_HZ,
    SETTLE_S,
    Bench,
    Setting,
    table_of,
)
from pipelines.results import FloatArray

SUPPORT = 0.4
"""Half the prior's width, as a share of its mean; not printed."""

FACTOR = 3.0
FEW, SMALLEST = 10, 1e-13


def priors_for(mean: tuple[float, float, float]) -> Priors:
    """Even priors about a row's means."""
    items = (
        Known(name, Uniform((1 - SUPPORT) * m, (1 + SUPPORT) * m), log=True)
        for name, m in zip(NAMES, mean, strict=True)
    )
    return Priors(tuple(items))


@dataclass(frozen=True)
class Measured:
    """What the accelerometers read: (n, 4) on the body, with noise; the hubs' are exact, as in the paper."""

    body: FloatArray


def measured(
    place: Bench, rng: np.random.Generator, *, seven: bool = False, noise: float = NOISE_MPS2
) -> Measured:
    """With a draw of noise. seven: of the seven-degree-of-freedom car in place of the model's own."""
    truth = place.seven if seven else place.matched
    return Measured(truth + noise * rng.standard_normal(truth.shape))


class Method:
    """One row of Table 5.1 on the bench. Predictions over the prior's support are kept: all noise seeds share them."""

    def __init__(
        self,
        place: Bench,
        setting: Setting,
        *,
        warp: bool = False,
        springs: float = 1.0,
        noise: float = NOISE_MPS2,
        follow: bool = True,
    ):
        self.place, self.setting, self.warp = place, setting, warp
        self.springs, self.noise = springs, noise
        self.priors = priors_for(setting.mean)
        self.choice = Choice(order=setting.order, near_order=3, factor=FACTOR, follow=follow)
        rows = round(setting.seconds * RATE_HZ)
        self.edges = np.linspace(0, rows, setting.intervals + 1).astype(int)
        self.kept: dict[int, tuple[FloatArray, FloatArray]] = {}

    def predicted(self, coordinates: FloatArray, interval: int) -> FloatArray:
        """Body accelerations (Q, rows of the interval, 4)."""
        begin, stop = int(self.edges[interval]), int(self.edges[interval + 1])
        early = max(0, begin - round(SETTLE_S * RATE_HZ))
        table = table_of(self.place.car, self.priors.values(coordinates), self.springs)
        hubs = self.place.hubs[early:stop]
        out = corner_response(table, hubs, self.place.geometry, 1 / RATE_HZ, warp=self.warp)
        return out[:, begin - early :]

    def residuals(self, data: Measured, coordinates: FloatArray, interval: int) -> FloatArray:
        """Normalised, (Q, N); over the prior's support as many figures as the predictions have dimensions, and one."""
        begin, stop = int(self.edges[interval]), int(self.edges[interval + 1])
        read = data.body[begin:stop].ravel() / self.noise
        low, high = self.priors.box()
        if len(coordinates) <= FEW or np.ptp(coordinates[:, 0]) < 0.5 * (high[0] - low[0]):
            out = self.predicted(coordinates, interval).reshape(len(coordinates), -1)
            return read - out / self.noise
        if interval not in self.kept or len(self.kept[interval][1]) != len(coordinates):
            out = self.predicted(coordinates, interval).reshape(len(coordinates), -1) / self.noise
            self.kept[interval] = _turned(out)
        axes, along = self.kept[interval]
        seen = axes @ read
        rest = np.sqrt(max(float(read @ read - seen @ seen), 0.0))
        return np.column_stack((seen - along, np.full(len(along), rest)))

    def fit(self, data: Measured, rng: np.random.Generator) -> Found:
        """The engine's result."""
        return estimate(
            self.priors, lambda c, i: self.residuals(data, c, i), self.setting.intervals, self.choice, rng
        )

    def of_the_logarithm(self, data: Measured, rng: np.random.Generator) -> FloatArray:
        """MAP (3,) where the log likelihood itself is expanded to the row's order over the fixed support."""
        collocation = collocation_for(3, self.setting.order, FACTOR, rng)
        domain = box(*self.priors.box())
        misfit = np.zeros(len(collocation.points))
        for interval in range(self.setting.intervals):
            out = self.residuals(data, domain.out(collocation.points), interval)
            misfit += np.sum(out**2, axis=1)
        coefficients = collocation.inverse @ misfit
        centre, half = np.zeros(3), 1.0
        for _ in range(10):
            points = np.clip(centre + half * (2 * hammersley(4000, 3) - 1), -1, 1)
            values = collocation.space.matrix(points, collocation.indices) @ coefficients
            centre, half = points[np.argmin(values)], 0.4 * half
        return np.asarray(self.priors.values(domain.out(centre[None]))[0])


def _turned(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Orthonormal axes (r, N) that hold all rows (Q, N), and the rows along them (Q, r): distances stay as they are."""
    sizes, vectors = np.linalg.eigh(rows @ rows.T)
    keep = sizes > SMALLEST * sizes[-1]
    axes = (vectors[:, keep].T @ rows) / np.sqrt(sizes[keep])[:, None]
    return axes, rows @ axes.T


def bound(place: Bench, seconds: float, noise: float = NOISE_MPS2) -> FloatArray:
    """Cramér-Rao bound (3,) of the standard deviations from so much of the matched body, hubs exact."""
    truth = place.car.truth
    rows = round(seconds * RATE_HZ)
    slopes = []
    for j in range(3):
        step = 1e-4 * truth[j] * np.eye(3)[j]
        table = table_of(place.car, np.vstack((truth + step, truth - step)))
        ahead, behind = corner_response(table, place.hubs[:rows], place.geometry, 1 / RATE_HZ, warp=False)
        slopes.append((ahead - behind).ravel() / (2e-4 * truth[j] * noise))
    columns = np.array(slopes)
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(columns @ columns.T))))
