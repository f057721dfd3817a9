"""The figures of Figs 2 and 6-8 as tables, and what the model's error does without any noise."""

from __future__ import annotations

import numpy as np

from pipelines.reproduce.base import Cell, Column, ReproducedTable
from pipelines.reproduce.berntorp.batch import fit_batch
from pipelines.reproduce.berntorp.filters import FEW, KERNEL
from pipelines.reproduce.berntorp.plant import HIGH_SUV, drive, effective, simpler
from pipelines.reproduce.berntorp.setup import NAMES, RANGES, TITLES, UNITS, Motion, RollBody
from pipelines.reproduce.berntorp.study import FILTERS, Found, Setup
from pipelines.simulation.plant.vehicle import PRESETS, PlantVehicle

SHOWN = (*FILTERS, FEW, KERNEL)
SEVERITIES = (1.0, 1.5, 2.0, 2.5)
PAPER_3_STD: dict[str, str] = {
    "Algorithm 2": "small, shrinks",
    "NONBO": "significantly larger",
    "NONADAP": "small, biased",
}


def _percent(values: np.ndarray, truth: np.ndarray) -> list[float]:
    return [float(v) for v in 100 * (values / truth - 1)]


def warm_table(setups: tuple[Setup, ...]) -> ReproducedTable:
    """Fig 2 in figures: best point, 95 % part of the box, and whether it holds the truth."""
    rows: list[tuple[Cell, ...]] = []
    for setup in setups:
        inside, best = setup.started.inside, setup.started.history.best
        for i, name in enumerate(NAMES):
            low, high = RANGES[name]
            truth = float(setup.truth.theta[i])
            kept = 100 * float(inside.high[i] - inside.low[i]) / (high - low)
            held = "yes" if inside.low[i] <= truth <= inside.high[i] else "no"
            rows.append((
                f"{TITLES[i]}, {setup.name}", truth, float(best[i]), float(inside.low[i]), float(inside.high[i]), kept, held
            ))  # fmt: skip
    columns = (
        Column("Parameter"), Column("Truth", "", 2), Column("Best point", "", 2), Column("95 % from", "", 2),
        Column("to", "", 2), Column("Of the box", "%", 0), Column("Holds the truth"),
    )  # fmt: skip
    return ReproducedTable(
        "Fig 2", "Warm start: density over 100 iterations", columns, tuple(rows),
        "The published density counts every point tried alike, exploration too: it keeps most of the box. Its modes are where "
        "the optimiser tried often.",
    )  # fmt: skip


def averages_table(found: Found) -> ReproducedTable:
    """Figs 6-8 at the end: mean, three standard deviations as stated and over the runs, particles."""
    rows: list[tuple[Cell, ...]] = []
    for name in SHOWN:
        run = found.filters[name]
        off = _percent(run.final.mean(axis=0), found.setup.truth.theta)
        stated = 300 * run.std[:, -1].mean(axis=0) / found.setup.truth.theta
        over = 300 * run.final.std(axis=0) / found.setup.truth.theta
        early = 300 * run.std[:, 20].mean(axis=0) / found.setup.truth.theta
        for i, title in enumerate(TITLES):
            rows.append((
                f"{name}: {title}", PAPER_3_STD.get(name, ""), off[i], float(early[i]), float(stated[i]), float(over[i]),
                float(run.particles.mean()),
            ))  # fmt: skip
    columns = (
        Column("Filter"), Column("Published"), Column("Mean less truth", "%", 1), Column("3 std stated at 0.2 s", "%", 1),
        Column("3 std stated, end", "%", 1), Column("3 std over runs, end", "%", 1), Column("Particles", "", 0),
    )  # fmt: skip
    return ReproducedTable(
        "Figs 6-8", f"Averages over all runs at the end, {found.setup.name}", columns, tuple(rows),
        "The paper draws the averages without figures and does not say which of the two spreads its shaded areas are: both are here. "
        "All in % of the truth.",
    )  # fmt: skip


def _fitted(vehicle: PlantVehicle, motion: Motion) -> tuple[RollBody, list[Cell]]:
    body = effective(vehicle)
    fit = fit_batch(np.column_stack((motion.roll, motion.rate)), motion.accel, body.mass, body.inertia)
    at_line = fit.theta[2] < 1.02 * (body.inertia / body.mass) ** 0.5
    return body, [*_percent(fit.theta, body.theta), "at the line" if at_line else "", fit.misfit]


def model_error_table() -> ReproducedTable:
    """The best fit of (1)-(2) to the plant's motion without noise, by severity and by what is taken out of the plant."""
    rows: list[tuple[Cell, ...]] = []
    for scalar in SEVERITIES:
        motion = drive(HIGH_SUV, scalar)
        peak = float(np.max(np.abs(motion.accel)))
        rows.append((f"full plant, {scalar:g} A ({peak:.1f} m/s²)", *_fitted(HIGH_SUV, motion)[1]))
    for name, vehicle in simpler().items():
        rows.append((f"2 A, {name}", *_fitted(vehicle, drive(vehicle))[1]))
    rows.append(("2 A, the plant's own SUV", *_fitted(PRESETS["suv"], drive(PRESETS["suv"]))[1]))
    columns = (
        Column("Plant"), *(Column(f"{title.split()[-1]}, best fit less truth", "%", 1) for title in TITLES),
        Column("h = sqrt(I_x/m)"), Column("Residual over noise", "", 2),
    )  # fmt: skip
    return ReproducedTable(
        "Section IV", "Error of the model itself: best fit without noise", columns, tuple(rows),
        "By the likelihood with the study's noise. Residual: RMS of the misfit over the noise's standard deviation; below one it is "
        "hardly seen beside the noise, and the errors are tens of per cent all the same. Where the motion asks for less inertia than any "
        "height gives, the fit ends at the line h = sqrt(I_x/m), where height and stiffness have no sensitivity left. At 2 A, the "
        "study's severity, the errors happen to cancel in h.",
    )  # fmt: skip


def truths(body: RollBody) -> str:
    """K, D, h of a vehicle in words."""
    return ", ".join(
        f"{name} {value:,.{digits}f} {unit}".replace(",", " ")
        for name, value, digits, unit in zip(NAMES, body.theta, (0, 0, 3), UNITS, strict=True)
    )
