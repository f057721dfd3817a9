"""3.5: the convergence test, Figures 3.28-3.30 and Table 3.7."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipelines.filters.gpc_convergence import VelocityTest, velocity_test
from pipelines.filters.gpc_filter import StateSpaceRun
from pipelines.reproduce.base import Cell, Claim, Column, ReproducedTable
from pipelines.reproduce.gpc_filter.part import Part, agreement
from pipelines.reproduce.gpc_filter.setup import MASS_KG, FilterCase, demo_drive, run_case, seconds, settled
from pipelines.results import Trace

START = (-5.0, 10.0)
CASES: tuple[FilterCase, ...] = (
    FilterCase("Table 3.7 as printed", 1e-4, 0.001, m2=0.0, noise=(15.0, 3.0), order=4, factor=3.0),
    FilterCase("c1 0.005", 1e-4, 0.005, m2=0.0, noise=(15.0, 3.0), order=4, factor=3.0),
    FilterCase("c1 0.02, c 1e-3", 1e-3, 0.02, m2=0.0, noise=(15.0, 3.0), order=4, factor=3.0),
    FilterCase(
        "states followed too closely: c 0.01", 0.01, 0.001, m2=0.0, noise=(15.0, 3.0), order=4, factor=3.0
    ),
)
"""The plant's state and the filter's: -5 m, 10 m/s and 0, 0."""


def _test(run: StateSpaceRun, fair: bool) -> VelocityTest:
    return velocity_test(run.time_s, run.mean[:, 0], run.mean[:, 1], fair=fair)


def _table(runs: dict[str, StateSpaceRun]) -> ReproducedTable:
    rows: list[tuple[Cell, ...]] = []
    for label, run in runs.items():
        mass, fair, plain = run.value("mass"), _test(run, True), _test(run, False)
        rows.append((
            label, float(mass[-1]), seconds(settled(mass, MASS_KG)), seconds(fair.settled_s),
            100 * float(np.min(plain.difference[500:])), 100 * float(np.min(fair.difference[500:])),
        ))  # fmt: skip
    return ReproducedTable(
        "Table 3.7", f"convergence test, plant from {START[0]:g} m and {START[1]:g} m/s, filter from 0 and 0",
        (
            Column("Settings"), Column("Last mass", "kg"), Column("Mass within 5 % after"), Column("Velocities agree after"),
            Column("Least difference as printed", "%"), Column("Least difference, smoothed alike", "%", 3),
        ),
        tuple(rows),
        "Velocities agree: the moving RMS over 5 s of their difference stays below 5 % of the velocity's deviation. As printed, only the "
        "position is smoothed (41 points, second order), which by itself leaves a difference; smoothing both alike leaves none.",
    )  # fmt: skip


def _claims(runs: list[StateSpaceRun]) -> tuple[Claim, ...]:
    first, second = runs[0], _test(runs[0], True)
    when = settled(first.value("mass"), MASS_KG)
    close = when is not None and second.settled_s is not None and abs(second.settled_s - when) < 15.0
    stuck = _test(runs[3], True)
    return (
        Claim(
            "Figures 3.28-3.29, Table 3.7", "the filter finds states and mass from a wrong start",
            f"mass {first.value('mass')[-1]:.1f} kg, within 5 % after {seconds(when)}", "",
            agreement(when is not None),
            f"With c1 0.005 after {seconds(settled(runs[1].value('mass'), MASS_KG))}.",
        ),
        Claim(
            "3.5, Figure 3.30", "the velocities overlap when the mass has converged",
            f"mass within 5 % after {seconds(when)}, velocities agree after {seconds(second.settled_s)}",
            "smoothed alike", agreement(close),
            f"A c so large that the states follow the sensor whatever the mass leaves it at {runs[3].value('mass')[-1]:.0f} kg; "
            f"velocities agree: {seconds(stuck.settled_s)}. The test is not fooled.",
        ),
        Claim(
            "(68)-(69)", "position close and velocities equal only with the right mass",
            f"the test passes in {sum(_test(run, True).settled_s is not None for run in runs)} of {len(runs)} noise-free runs, the "
            f"mass is right in {sum(settled(run.value('mass'), MASS_KG) is not None for run in runs)}", "",
            agreement(all(
                (_test(run, True).settled_s is None) == (settled(run.value("mass"), MASS_KG) is None) for run in runs
            )),
            "It shows that model and data agree, no more: under an excitation that does not tell the parameters apart (3.4.4) a wrong "
            "set passes too.",
        ),
    )  # fmt: skip


def convergence(rng: np.random.Generator) -> Part:
    """Figures 3.28-3.30. All cases see the same noise."""
    drive = demo_drive(start=START, changes=False)
    seed = int(rng.integers(2**32))
    noisy = replace(CASES[1], label="c1 0.005, sensor noise 0.1 m", sensor_std=0.1)
    named = {case.label: run_case(case, drive, np.random.default_rng(seed)) for case in (*CASES, noisy)}
    runs = [named[case.label] for case in CASES]
    second = _test(runs[0], True)
    columns = {
        "filter's velocity": second.velocity,
        "derivative of its position": second.derivative,
        "truth": drive.velocity,
    }
    traces = (
        Trace(
            "Figure 3.29: mass",
            drive.time_s,
            {case.label: run.value("mass") for case, run in zip(CASES[:3], runs[:3], strict=True)},
            {case.label: "kg" for case in CASES[:3]},
            "",
        ),
        Trace(
            "Figure 3.30: convergence test",
            drive.time_s,
            columns,
            dict.fromkeys(columns, "m/s"),
            "Table 3.7 as printed.",
        ),
    )
    return Part((_table(named),), _claims(runs), traces)
