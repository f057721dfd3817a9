"""`cogest reproduce gpc_filter`: Chapter 3.4-3.5 of the dissertation, every figure's message, and the study against the bound."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipelines.reproduce.base import Progress, Reproduction, StudyRow
from pipelines.reproduce.gpc_filter.asymmetric import asymmetric
from pipelines.reproduce.gpc_filter.basin import basin
from pipelines.reproduce.gpc_filter.convergence import convergence
from pipelines.reproduce.gpc_filter.excitation import SENSOR_M, excitation
from pipelines.reproduce.gpc_filter.improvements import improvements
from pipelines.reproduce.gpc_filter.part import Part
from pipelines.reproduce.gpc_filter.setup import DAMPING_NSPM, STIFFNESS_NPM, sine_force
from pipelines.reproduce.gpc_filter.study import GUESS, setups, study

PARTS: dict[str, Callable[[np.random.Generator], Part]] = {
    "improvements, Figures 3.1-3.15": improvements,
    "basin of attraction": basin,
    "asymmetric distributions, Figures 3.16-3.21": asymmetric,
    "excitation, Figures 3.22-3.27": excitation,
    "convergence test, Figures 3.28-3.30": convergence,
}


class GpcFilter:
    """The paper "gpc_filter"."""

    name: str = "gpc_filter"
    title: str = "gPC-EKF for state-space systems on a mass, spring and damper"

    def reproduce(self, runs: int, rng: np.random.Generator, progress: Progress) -> Reproduction:
        """All of it; deterministic for a given generator."""
        parts = []
        for number, (words, part) in enumerate(PARTS.items()):
            progress(words, 0.1 * number)
            parts.append(part(rng))
        rows: list[StudyRow] = []
        chosen = setups(rng, sine_force())
        for number, setup in enumerate(chosen):
            progress(f"study: {setup.words}", 0.5 + 0.5 * number / len(chosen))
            rows += study(setup, runs, rng)
        progress("done", 1.0)
        return Reproduction(
            self.name, self.title,
            "Dissertation on generalised polynomial chaos in vehicle parameter estimation, Chapters 3.2, 3.4, 3.5",
            _SETUP, tuple(t for part in parts for t in part.tables), tuple(c for part in parts for c in part.claims),
            tuple(rows), tuple(t for part in parts for t in part.traces), (), _NOTES,
        )  # fmt: skip


_SETUP = (
    f"Mass-spring system of 3.4.1, 200 sin(t) N, position measured at 100 Hz; plant by Runge-Kutta at 2 kHz, filter at 100 Hz. The "
    f"stiffness is not printed: {STIFFNESS_NPM:g} N/m is assumed (380-450 N/m give the figures' story). For 3.4.4 the truth is "
    f"not printed either: 100 kg, {STIFFNESS_NPM:g} N/m, {DAMPING_NSPM:g} N s/m are assumed.",
    "Q in the tables is the number of points for each term: 6 means 6 S points. c1 is in kg, added as c1 mu at each sample (58).",
    f"Study: {1000 * SENSOR_M:g} mm of position noise, 40 s, 0.05-3 Hz excitation, a random first guess in each run "
    f"({100 * GUESS:g} % standard deviation), first states known to 50 mm and 0.2 m/s. Bound: Cramér-Rao from finite differences of the "
    "plant, the first states unknown within that.",
)

_NOTES = (
    "(40) gives (I - K H) M (I - K H)' without K R K': that is the paradox of 3.4. The square-root gain on the higher coefficients "
    "gives the Kalman covariance exactly and needs no additions for a constant parameter.",
    "(49): with H picking the position only, c on a parameter's diagonal never enters K. (51) adds to coefficients, (58) to values at the "
    "points: the same for a linear addition. (63): -(c/m) x is -(c/m) v. H is printed transposed in (59), (67). (27), (32) lack a "
    "transpose, v and w swap roles in (21), (22), (29), (31); A in (12) is A(i,m).",
    "The spread of the filter as published is set by c, c1 and R, not by the noise: its interval says nothing about the error.",
    "Under a steady sine the square-root filter too takes for knowledge what it linearised on its way (an extended Kalman filter's known "
    "fault); the whole record at once does not, and says weak.",
)
