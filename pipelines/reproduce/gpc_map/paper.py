"""`cogest reproduce gpc_map`: Chapter 5's tables and claims beside ours, and all settings over noise seeds."""

from __future__ import annotations

import numpy as np

from pipelines.reproduce.base import Progress, Reproduction
from pipelines.reproduce.gpc_map.claims import claims
from pipelines.reproduce.gpc_map.methods import SUPPORT
from pipelines.reproduce.gpc_map.setup import NOISE_MPS2, RATE_HZ, SPEED_MPS, SURFACE, bench
from pipelines.reproduce.gpc_map.study import study
from pipelines.reproduce.gpc_map.tables import densities, rows, tables, traces


class GpcMap:
    """The paper "gpc_map"."""

    name: str = "gpc_map"
    title: str = "gPC-Bayesian MAP estimation of mass and inertias (dissertation, Chapter 5)"

    def reproduce(self, runs: int, rng: np.random.Generator, progress: Progress) -> Reproduction:
        """Tables 5.1 and 5.2, the claims, and a study of `runs` noise seeds. Deterministic for a given generator."""
        progress("road", 0.0)
        place = bench(rng)
        found = rows(place, rng, progress)
        studied = study(place, runs, rng, progress)
        progress("claims", 0.98)
        truth = place.car.truth
        hub = float(np.std(place.hubs))
        return Reproduction(
            paper=self.name,
            title=self.title,
            citation=(
                "Dissertation on generalized polynomial chaos for vehicle parameters, load transfer and suspension mapping, section 3.3 "
                "and Chapter 5"
            ),
            setup=(
                "Car of Table 5.2 (1850 kg, 3000 and 800 kg·m²); what is not printed is a car's: springs 30 and 32 kN/m, dampers 2.0 "
                "and 2.2 kN·s/m, hubs 45 kg, tyres 220 kN/m, wheelbase 2.8 m, track 1.6 m.",
                f"Seven degrees of freedom over an ISO 8608 class {SURFACE} road at {SPEED_MPS:g} m/s, hubs {hub:.1f} m/s² RMS, {RATE_HZ:g} Hz; "
                "the matched body is the three-degree-of-freedom model on those hubs.",
                f"White noise of {NOISE_MPS2:g} m/s² on the body's four accelerometers; the hubs' are exact, as in the paper.",
                f"Priors: even, {100 * SUPPORT:.0f} % either side of Table 5.1's means; their widths are not printed.",
            ),
            tables=tables(found),
            claims=claims(place, found, studied, rng),
            study=tuple(studied),
            traces=traces(found, truth),
            scatters=densities(found, truth),
            notes=(
                "(89) needs -m z_u''; the second (97) is (98), for F_rr.",
                "(86)-(88) take the hubs as a plane: the warp of the road between them, which (95)-(98) need, is left out.",
                "Masses and inertias come in proportion to springs and dampers, which are exactly known here.",
            ),
        )
