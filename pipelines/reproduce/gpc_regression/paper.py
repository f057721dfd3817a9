"""`cogest reproduce gpc_regression`: sections 3.6-3.9 of the gPC dissertation, its filter beside RLS and all samples at once."""

from __future__ import annotations

import numpy as np

from pipelines.reproduce.base import Progress, Reproduction
from pipelines.reproduce.gpc_regression.claims import claims
from pipelines.reproduce.gpc_regression.setup import (
    BAND_HZ,
    DURATION_S,
    NOISE,
    PLANE,
    SINES,
    TRUTH,
    clean_drive,
)
from pipelines.reproduce.gpc_regression.study import study
from pipelines.reproduce.gpc_regression.tables import table_of_noise, tables


class GpcRegression:
    """The paper "gpc_regression"."""

    name: str = "gpc_regression"
    title: str = "gPC-EKF for regression systems and RLS (dissertation 3.6-3.9)"

    def reproduce(self, runs: int, rng: np.random.Generator, progress: Progress) -> Reproduction:
        """Tables 3.8-3.10, Figures 3.32-3.39, the claims, and a study of `runs` noise seeds."""
        progress("drive", 0.0)
        drive = clean_drive(rng)
        shown = tables(drive, rng, progress)
        rows, other_height = study(drive, runs, rng, progress)
        return Reproduction(
            paper=self.name,
            title=self.title,
            citation=(
                "Dissertation on generalised polynomial chaos for vehicle parameter estimation (gPC-EKF, gPC-Bayesian MAP, "
                "load transfer, suspension mapping), sections 3.6 to 3.9"
            ),
            setup=(
                f"Simple roll-plane model (71)-(73), {DURATION_S:g} s at 10 ms. Not printed, so ours: {SINES} sines a channel "
                f"from {BAND_HZ[0]:g} to {BAND_HZ[1]:g} Hz, l = r = {PLANE.left:g} m, a = {PLANE.front:g} m, b = {PLANE.rear:g} m.",
                f"True mass {TRUTH[0]:g} kg, pitch inertia {TRUTH[1]:g} and roll inertia {TRUTH[2]:g} kg·m², height {TRUTH[3]:g} m, "
                "inside the printed priors (77); Legendre basis, order 2, 15 terms, 60 points.",
                f"White noise of variance {NOISE:g} on the outputs, then on all channels.",
                "Published: (40) with the additions (78); RLS (81)-(85) with its errata put right.",
                "Companions: the square-root form of the filter; non-linear least squares of all samples; each of the three with "
                "the known noise of the inputs taken out.",
            ),
            tables=(*shown.tables, table_of_noise(rows)),
            claims=claims(drive, shown, rows, other_height, rng),
            study=rows,
            traces=shown.traces,
            notes=(
                "The names J_theta and J_phi are swapped in the text and (75); H in (79) is printed transposed.",
                "In (78) m², J² and h² are the second coefficients of the prior, not squares.",
                "With noise on all channels the bound counts the true inputs as unknowns, sample by sample.",
            ),
        )
