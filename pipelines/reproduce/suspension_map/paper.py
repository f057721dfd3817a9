"""`cogest reproduce suspension_map`: Chapter 9's tables and claims beside ours, and the study over vehicles and loads."""

from __future__ import annotations

import numpy as np

from pipelines.reproduce.base import Progress, Reproduction
from pipelines.reproduce.suspension_map.claims import claims
from pipelines.reproduce.suspension_map.drives import KINDS
from pipelines.reproduce.suspension_map.study import (
    JUDGE_S,
    MANOEUVRES,
    TRAIN_S,
    run_study,
    study_rows,
    study_table,
)
from pipelines.reproduce.suspension_map.tables import tables


class SuspensionMapping:
    """The paper "suspension_map"."""

    name: str = "suspension_map"
    title: str = "Tyre normal forces by suspension mapping"

    def reproduce(self, runs: int, rng: np.random.Generator, progress: Progress) -> Reproduction:
        """All of it; deterministic for a given generator. runs: vehicles of the study."""
        shown = tables(rng, progress)
        found = run_study(runs, rng, progress)
        progress("done", 1.0)
        return Reproduction(
            self.name,
            self.title,
            "Dissertation on generalized polynomial chaos estimation of vehicle parameters, Chapter 9: Axle Normal Force "
            "Estimate and Suspension Mapping, (145)-(150), Tables 9.1 to 9.9, Figures 9.1 to 9.10",
            (
                "Plant: the full vehicle with Dahl's dry friction (half to twice the preset's, turning over in 1 to 4 mm), data "
                "drawn anew for each vehicle; the struts do not feel 20 to 100 % of the friction, nor, in every second vehicle, "
                "the anti-roll bar.",
                "Instruments stay with a vehicle: strut cells and measuring wheels off by 0.5 % of scale, zeros drifting by 12 N "
                "from drive to drive, slip rings by 8 N within one; ride heights, inertial unit and speed as in series production.",
                "Mapped and measured forces are compared below 10 Hz.",
                f"Study: {len(KINDS)} kinds of vehicle in turn ({', '.join(KINDS)}); {TRAIN_S:.0f} s of handling track with the driver "
                f"alone, then {JUDGE_S:.0f} s or one round (to one side) of one of {', '.join(MANOEUVRES)} with 5 to 20 % of the sprung mass loaded.",
            ),
            (*shown.tables, study_table(found)),
            claims(shown, found),
            study_rows(found),
            shown.traces,
            notes=(
                "There is no Cramér-Rao bound here: the error is the model's own. The yardstick is the training's RMS error.",
            ),
        )
