"""`cogest reproduce load_transfer`: chapters 6-8 of the gPC dissertation."""

from __future__ import annotations

import numpy as np

from pipelines.estimators.load_transfer.kernels import HFLTM, LTM, MLTM
from pipelines.reproduce.base import Progress, Reproduction, StudyRow, study_row
from pipelines.reproduce.load_transfer.claims import Drives, claims_of, drives
from pipelines.reproduce.load_transfer.plant import MASS, SIZE
from pipelines.reproduce.load_transfer.rich import METHODS, Driven, run, suv
from pipelines.reproduce.load_transfer.study import study
from pipelines.reproduce.load_transfer.tables import settings_table
from pipelines.results import Trace

RICH_RUNS = 3
MODELS = (LTM, MLTM, HFLTM)
SHOWN = (("mass_kg", "kg"), ("cg_to_front_axle_m", "m"), ("cg_lateral_offset_m", "m"))


class LoadTransferPaper:
    """The paper "load_transfer"."""

    name: str = "load_transfer"
    title: str = "Mass, CG position and arms from strut forces: LTM, MLTM, HFLTM"

    def reproduce(self, runs: int, rng: np.random.Generator, progress: Progress) -> Reproduction:
        """All of it; deterministic for a given generator."""
        tables, traces = [], []
        for i, model in enumerate(MODELS):
            progress("settings of the tables", 0.05 * i)
            table, trace = settings_table(model, rng)
            tables.append(table)
            traces.append(trace)
        progress("drives with strut sensors", 0.15)
        found = drives(rng)
        claims = claims_of(found, rng)
        rows: list[StudyRow] = []
        for i, model in enumerate(MODELS):
            progress("study on the matched plant", 0.4 + 0.15 * i)
            rows += study(model, runs, rng)
        progress("study on the rich plant", 0.85)
        rows += rich_rows(found, max(1, min(runs, RICH_RUNS)), rng)
        progress("done", 1.0)
        return Reproduction(
            self.name, self.title,
            "Doctoral dissertation on vehicle parameter estimation by generalised polynomial chaos, chapters 6 to 8",
            _SETUP, tuple(tables), claims, tuple(rows), (*traces, *_arm_traces(found)), (), _NOTES,
        )  # fmt: skip


_SETUP = (
    f"Matched plant: {MASS:g} kg sprung, wheelbase {SIZE.wheelbase:g} m, track {SIZE.track:g} m; strut forces of the model itself "
    "with white noise; random cornering, braking and rough road from rest.",
    "Rich plant: the simulated SUV with friction, two-slope dampers, roll centres and anti-dive; strut forces with offset and "
    "scale errors, accelerometers over the struts, deflections, IMU, speed (sensor set `struts`); rural and urban with 30 kg "
    "moved from fl to fr and from rr to rl.",
    "First guesses of the tables on the matched plant; on the rich plant those of the first second's forces.",
)
_NOTES = (
    "theta is nose-up in the dissertation and nose-down here; an accelerometer in the leaning body reads A_y + phi, so that "
    "phi counts once. (102) and (104) lack 1/2, (105) writes A_x for A_y, (123) repeats (122), the HFLTM lists F_bounce "
    "without an equation: Table 8.1 has no R for it and we leave it out.",
    "c of the tables is taken times each first half width; at other rates than 1 kHz c and R are scaled so that the filter "
    "learns as much a second.",
    "Struts carry the sprung mass: the estimators add the vehicle file's unsprung masses.",
    "The estimator modified_load_transfer holds its masses while the lateral force is above 0.1 g, where roll centres carry weight, and "
    "its arms below it, as (8.2) has it for the HFLTM; gate_g = 0 is the published form, on which the claims are judged.",
    "64 drives of the rich plant are in benchmarks/load_transfer_study.py.",
)


def rich_rows(found: Drives, runs: int, rng: np.random.Generator) -> list[StudyRow]:
    """Errors on the rich plant over a few rural drives with the diagonal shift."""
    made: list[Driven] = [found.rural]
    for seed in rng.integers(1 << 30, size=runs - 1):
        made.append(run("rural", "rural", suv(30.0), int(seed)))
    rows = []
    for i, method in enumerate(METHODS):
        for parameter, unit in SHOWN:
            entries = [d.estimates[i].parameters[parameter] for d in made]
            nan = float("nan")
            values = np.array([nan if e.value is None else e.value for e in entries])
            intervals = np.array(
                [(nan if e.low is None else e.low, nan if e.high is None else e.high) for e in entries]
            )
            rows.append(
                study_row(
                    "rich plant, rural, 30 kg diagonal", method.name, parameter, unit, made[0].truth[parameter], values,
                    intervals, None,
                )
            )  # fmt: skip
    return rows


def _arm_traces(found: Drives) -> list[Trace]:
    """Roll and pitch arms of the HFLTM on the handling track."""
    traces = []
    for drive in (found.soft, found.stiff):
        (arms,) = (t for t in drive.estimates[0].traces if t.name.endswith("arms"))
        name = f"load_transfer: HFLTM arms, handling track, {drive.name}"
        traces.append(Trace(name, arms.time_s, arms.columns, arms.units, arms.note))
    return traces
