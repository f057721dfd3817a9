"""`cogest reproduce pence`: the tables and claims of Pence, Fathy & Stein beside ours, and a study over noise seeds.

Everything runs on the paper's own set-up: the quarter car of Table I on one terrain, 200 s at 5 ms. The terrain's ARIMA
coefficients are not printed, so that another terrain of like spectrum stands in, scaled to the one figure that the paper
gives of it (0.37 m/s² is 25 dB): expect the same trends, not the same digits.
"""

from __future__ import annotations

import numpy as np

from pipelines.reproduce.base import Progress, Reproduction
from pipelines.reproduce.pence.claims import claims
from pipelines.reproduce.pence.setup import NOISE_MPS2, bench
from pipelines.reproduce.pence.study import study
from pipelines.reproduce.pence.tables import tables
from pipelines.simulation.quarter_car import TERRAIN_STEP_M


class Pence:
    """The paper "pence"."""

    name: str = "pence"
    title: str = "Sprung mass by base excitation (Pence, Fathy & Stein)"

    def reproduce(self, runs: int, rng: np.random.Generator, progress: Progress) -> Reproduction:
        """Tables III to VII, the claims, and a study of `runs` noise seeds. Deterministic for a given generator."""
        progress("terrain", 0.0)
        place = bench(rng)
        shown = tables(place, rng, progress)
        rows = study(place, runs, rng, progress)
        return Reproduction(
            paper=self.name,
            title=self.title,
            citation=(
                "B. L. Pence, H. K. Fathy, J. L. Stein: Sprung Mass Estimation for Off-Road Vehicles via Base-Excitation "
                "Suspension Dynamics and Recursive Least Squares, American Control Conference, 2009"
            ),
            setup=(
                "Quarter car of Table I, two damper slopes, tyre that can leave the ground; 200 s at 5 ms, 8 m/s.",
                f"Terrain: spectrum (n² + 0.1²)^-1.5 / (1 + n²), n in cycles/m, points every {100 * TERRAIN_STEP_M:g} cm, in "
                "place of the unprinted ARIMA(8,1,0); as high as makes the hub's acceleration 6.6 m/s² RMS at 8 m/s, which "
                "is what 0.37 m/s² at 25 dB (Table II) says.",
                f"White noise of {NOISE_MPS2:g} m/s² on both accelerometers, or of the printed signal-to-noise ratio.",
                "Published: the filters (3)-(5) by Tustin's rule, discrete recursive least squares, P(0) = 1000 I, theta(0) = 0.",
                "Companion: output error with both damper slopes, whitened, all 200 s at once (base_excitation_batch), with "
                "gain and delay of the accelerometers pinned as in the paper; the last study rows free them.",
            ),
            tables=shown.tables,
            claims=claims(place, shown, rows),
            study=rows,
            traces=shown.traces,
            notes=(
                "Table VI prints 6.5 % for 775 kg at 4 m/s; it is 3.5 %. In section V, run 5 (too low) must be run 1.",
                "(6) and (7) as printed mix two forms and diverge under Euler's rule; the discrete form shows what the paper does.",
                "The mass comes in proportion to the assumed spring rate, which is exact here.",
            ),
        )
