"""Figures 2 to 8 of the paper, ours: densities, steering, one run, the number of particles, and averages over all runs."""

from __future__ import annotations

import numpy as np

from pipelines.reproduce.berntorp.filters import ALGORITHM, KERNEL, Collected
from pipelines.reproduce.berntorp.setup import NAMES, RANGES, TITLES, UNITS
from pipelines.reproduce.berntorp.study import FILTERS, Found, Setup
from pipelines.results import FloatArray, Scatter, Trace

DOTS = 25
"""Dots that make an upright line."""


def _upright(at: float, top: float) -> tuple[FloatArray, FloatArray]:
    return np.full(DOTS, at), np.linspace(0.0, top, DOTS)


def densities(setup: Setup) -> tuple[Scatter, ...]:
    """Fig 2: the density over the history of the optimisation, with the box, its 95 % part and the truth as upright lines."""
    found = []
    for i, name in enumerate(NAMES):
        grid, density = setup.started.density.marginal(i)
        shape = density / density.max()
        inside = setup.started.inside
        lines = [
            _upright(float(setup.truth.theta[i]), 1.1),
            _upright(RANGES[name][0], 0.5),
            _upright(RANGES[name][1], 0.5),
            _upright(float(inside.low[i]), 0.25),
            _upright(float(inside.high[i]), 0.25),
        ]
        x, y = (np.concatenate([line[axis] for line in lines]) for axis in (0, 1))
        label = f"{TITLES[i]}, {UNITS[i]}"
        note = "Upright, from the highest: truth; box; its 95 % part."
        found.append(
            Scatter(f"fig2-{name}", f"Fig 2: {TITLES[i]}, {setup.name}", label, "density over its peak", x, y, grid,
                    shape, shape, shape, note)
        )  # fmt: skip
    return tuple(found)


def _steering(setup: Setup) -> Trace:
    motion = setup.motion
    columns = {"road wheels": motion.steering, "roll": motion.roll}
    return Trace(f"Fig 3: steering, {setup.name}", motion.time_s, columns, dict.fromkeys(columns, "rad"))


def _one_run(setup: Setup, run: Collected) -> list[Trace]:
    """Fig 4: one run with three standard deviations, as the filter states them."""
    found = []
    for i, name in enumerate(TITLES):
        mean, three = run.first.mean[:, i], 3 * run.first.std[:, i]
        columns = {
            "estimate": mean, "less 3 std": mean - three, "plus 3 std": mean + three,
            "truth": np.full(len(mean), setup.truth.theta[i]),
        }  # fmt: skip
        title = f"Fig 4: {name}, one run, {setup.name}"
        found.append(Trace(title, setup.motion.time_s, columns, dict.fromkeys(columns, UNITS[i])))
    return found


def _count(setup: Setup, run: Collected) -> Trace:
    """Fig 5: the number of particles of that run and the mean of all."""
    columns = {
        "this run": run.first.particles.astype(np.float64),
        "mean of all runs": run.particles.mean(axis=0),
    }
    title = f"Fig 5: number of particles, {setup.name}"
    return Trace(title, setup.motion.time_s[1:], {k: v[1:] for k, v in columns.items()}, dict.fromkeys(columns, "particles"),
                 "Without the first sample, of 8 000.")  # fmt: skip


def _averages(found: Found) -> list[Trace]:
    """Figs 6-8: averages over all runs, and three standard deviations, stated and over the runs."""
    setup, traces = found.setup, []
    chosen = [found.filters[name] for name in (*FILTERS, KERNEL)]
    for i, name in enumerate(TITLES):
        figure = f"Fig {6 + i}: {name}"
        units = UNITS[i]
        mean = {run.name: run.mean[:, :, i].mean(axis=0) for run in chosen}
        mean["truth"] = np.full(len(setup.motion.accel), setup.truth.theta[i])
        mean["best fit without noise"] = np.full(len(setup.motion.accel), setup.best.theta[i])
        stated = {run.name: 3 * run.std[:, :, i].mean(axis=0) for run in chosen}
        spread = {run.name: 3 * run.mean[:, :, i].std(axis=0) for run in chosen}
        time_s = setup.motion.time_s
        for words, columns in (
            ("mean of all runs", mean), ("3 std as stated, mean", stated), ("3 std over the runs", spread)
        ):  # fmt: skip
            title = f"{figure}, {words}, {setup.name}"
            traces.append(Trace(title, time_s, columns, dict.fromkeys(columns, units)))
    return traces


def traces_of(found: Found) -> tuple[Trace, ...]:
    """Figs 3 to 8 of one set-up."""
    run = found.filters[ALGORITHM]
    return (
        _steering(found.setup), *_one_run(found.setup, run), _count(found.setup, run), *_averages(found)
    )  # fmt: skip
