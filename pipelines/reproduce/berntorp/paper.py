"""`cogest reproduce berntorp`: the Monte-Carlo study of the marginalised particle filter, Figs 2-8, and the bound."""

from __future__ import annotations

import numpy as np

from pipelines.reproduce.base import Progress, Reproduction
from pipelines.reproduce.berntorp.claims import claims
from pipelines.reproduce.berntorp.figures import densities, traces_of
from pipelines.reproduce.berntorp.filters import CLOUDS, KERNEL_PARTICLES
from pipelines.reproduce.berntorp.plant import HIGH_SUV, drive, effective
from pipelines.reproduce.berntorp.setup import MATCHED, STEP_S, RollBody, as_modelled
from pipelines.reproduce.berntorp.study import prepare, rows_of, run_all
from pipelines.reproduce.berntorp.tables import averages_table, model_error_table, truths, warm_table

RICH, AS_MODELLED = "richer plant", "plant as modelled"
PREPARED = 0.08
MATCHED_SHARE, RICH_SHARE, FEWEST_DRIVES = 0.2, 0.04, 2
"""Drives with several clouds each, as a share of the runs. On the plant as modelled they show whether intervals are honest."""


class Berntorp:
    """The paper "berntorp"."""

    name: str = "berntorp"
    title: str = "CG height, roll stiffness and damping by marginalised particle filter"

    def reproduce(self, runs: int, rng: np.random.Generator, progress: Progress) -> Reproduction:
        """All of it; deterministic for a given generator."""
        progress("plant", 0.0)
        motion, truth = drive(HIGH_SUV), effective(HIGH_SUV)
        model_error = model_error_table()
        progress("warm start", 0.02)
        rich = prepare(RICH, motion, truth, rng)
        progress("warm start", 0.05)
        matched = prepare(AS_MODELLED, as_modelled(motion, MATCHED), MATCHED, rng)
        half = (1 - PREPARED) / 2
        matched_drives, rich_drives = (
            max(round(share * runs), FEWEST_DRIVES) for share in (MATCHED_SHARE, RICH_SHARE)
        )
        first = run_all(
            rich, runs, rich_drives, rng, lambda what, share: progress(what, PREPARED + half * share)
        )
        second = run_all(
            matched,
            runs,
            matched_drives,
            rng,
            lambda what, share: progress(what, PREPARED + half * (1 + share)),
        )
        return Reproduction(
            paper=self.name,
            title=self.title,
            citation=(
                "K. Berntorp, A. Chakrabarty, S. Di Cairano: Vehicle center-of-gravity height and dynamics estimation with "
                "uncertainty quantification by marginalized particle filter"
            ),
            setup=_setup(truth, runs, matched_drives, rich_drives),
            tables=(warm_table((rich, matched)), averages_table(first), averages_table(second), model_error),
            claims=claims(first, second),
            study=(*rows_of(first, matched=False), *rows_of(second, matched=True)),
            traces=(*traces_of(first), *traces_of(second)),
            scatters=(*densities(rich), *densities(matched)),
            notes=(
                "(1)-(2): (I_x + m h²) φ'' + D φ' + K φ = m h (a_y cos φ + g sin φ); the weights of (10) have mean one.",
                "(K, D, h) times I_x / (m h²) has the same likelihood: the mirror image, from which the paper's two peaks may come. On the "
                "line h = sqrt(I_x / m) the two meet and the height has no sensitivity left.",
                "On the richer plant bias and coverage are against the truth as defined above: what they lack is the model's error, which no "
                "interval of the filter holds.",
            ),
        )


def _setup(truth: RollBody, runs: int, matched_drives: int, rich_drives: int) -> tuple[str, ...]:
    """The study in words."""
    return (
        f"Sine with dwell (FMVSS 126) at 80 km/h, 2 A, 2 s at {1 / STEP_S:g} Hz, {runs} runs, fresh noise each: roll 0.1 deg, "
        "roll rate 0.3 deg/s, lateral acceleration 0.1 m/s² (not printed, ours).",
        f"Richer plant: the full plant's SUV made higher and softer ({truth.mass:.0f} kg, I_x {truth.inertia:.0f} kg·m²): unsprung "
        "masses, tyres in series, stiffening springs with stops, dampers with a knee, dry friction, a roll axis above ground, "
        "tyres that saturate. The paper's own vehicle is in a reference that it does not print.",
        f"Its truth, as no such vehicle has one K, D and h: {truths(truth)}. h: CG height of the whole vehicle; K: m g h over the "
        "steady roll per g sensed, small angles, tyres included; D: what dampers (mean slope before the knee) and tyres take a "
        "unit of roll rate in the shape of a steady turn.",
        f"Plant as modelled: {truths(MATCHED)}, {MATCHED.mass:g} kg, I_x {MATCHED.inertia:g} kg·m², the same lateral acceleration. "
        "Mass and inertia are told to every method: they are not identifiable.",
        "Algorithm 2: 8 000 particles at first from the warm start, N* 1 000, at most 8 000; random walk 200 N·m/rad, 30 N·m·s/rad, "
        f"0.002 m a sample. {KERNEL_PARTICLES} particles in the kernel variant (resampling below N/2, Liu-West 0.4, no parameter "
        "noise, sensor offsets as states, from the whole box).",
        f"{CLOUDS} clouds joined, as `cogest analyze` joins them: {matched_drives} drives with noise of their own ({rich_drives} of the "
        f"richer plant), {CLOUDS} clouds on each with random numbers of their own. Estimate: the mean of their means; variance: the "
        "mean of theirs and 1 + 1/r times what parts their means (once for the particles that resampling lost, 1/r for where chance "
        "moved the mean). The truth is not used.",
    )
