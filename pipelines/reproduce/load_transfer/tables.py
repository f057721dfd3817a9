"""Tables 6.1, 7.1 and 8.1: the filters with the printed settings and with those that work, on the matched plant."""

from __future__ import annotations

import numpy as np

from pipelines.estimators.load_transfer.filtering import FORCE_VARIANCE, NAMES, run_filter, table_settings
from pipelines.estimators.load_transfer.kernels import HFLTM, LTM, MLTM
from pipelines.reproduce.base import Cell, Column, ReproducedTable
from pipelines.reproduce.load_transfer.plant import RATE_HZ, SIZE, forces, matched_drive, truth
from pipelines.reproduce.load_transfer.study import TITLES, least_squares, working_settings
from pipelines.results import Trace

SECONDS = 40.0
PLACES = {LTM: "Table 6.1", MLTM: "Table 7.1", HFLTM: "Table 8.1"}
REMARKS = {
    LTM: "With first order and as many points as terms the products m a l, h_r m, h_p C are not resolved: mass and lateral "
    "place come out, a, h_p and C drift. Second order with four times as many points as terms puts that right.",
    MLTM: "Linear in the corner masses but for the arms: first order does better here; C is small beside h_p.",
    HFLTM: "Products of masses and arms alone, and quick arms: the printed settings serve. With the square root and R this small the "
    "first seconds lock masses and arms of one axle together, and it takes longer to let go.",
}


def settings_table(model: int, rng: np.random.Generator) -> tuple[ReproducedTable, Trace]:
    """Errors of each parameter by three ways on one drive of 1 kHz with the table's own noise, and the arms' tracks."""
    drive = matched_drive(SECONDS, rng)
    true, clean = truth(model, drive), forces(model, drive)
    noise = float(np.sqrt(FORCE_VARIANCE))
    measured = clean + noise * rng.standard_normal(clean.shape)
    runs = [
        run_filter(model, drive.motion, drive.corners, measured, SIZE, settings, RATE_HZ, rng)
        for settings in (table_settings(model), working_settings(model, FORCE_VARIANCE))
    ]
    batch, _ = least_squares(model, drive, measured, noise)
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            name,
            float(t),
            *(100 * (float(run.track[-1, i]) / float(t) - 1) for run in runs),
            100 * (float(b) / float(t) - 1),
        )
        for i, (name, t, b) in enumerate(zip(NAMES[model], true, batch, strict=True))
    )
    columns = (
        Column("parameter"), Column("truth", "", 3), Column("printed settings", "%", 3),
        Column("settings that work", "%", 3), Column("batch least squares", "%", 4),
    )  # fmt: skip
    what = f"{TITLES[model]}: error after {SECONDS:g} s at 1 kHz, noise of the table's R (10 N²)"
    arms = {n: runs[1].track[:, i] for i, n in enumerate(NAMES[model]) if n.startswith("h_")}
    literal = {
        f"{n}, printed settings": runs[0].track[:, i]
        for i, n in enumerate(NAMES[model])
        if n.startswith("h_")
    }
    shown = arms | literal
    time_s = (runs[0].at + 1) / RATE_HZ
    trace = Trace(
        f"load_transfer: {TITLES[model]} arms", time_s, shown, dict.fromkeys(shown, "m"), "matched plant"
    )
    return ReproducedTable(PLACES[model], what, columns, rows, REMARKS[model]), trace
