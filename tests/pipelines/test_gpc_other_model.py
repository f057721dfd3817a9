"""What docs/gpc_filter.md shows: its example, and a model that is not ours, a pendulum, put together as it says."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from parsers.channels import IntArray
from parsers.jit import kernel
from pipelines.chaos.bases import hermite
from pipelines.filters.gpc_batch import estimate_batch
from pipelines.filters.gpc_filter import GpcSettings, StateSpaceModel, Uncertain, estimate_state_space, row
from pipelines.filters.gpc_state_space import FilterArrays, Record, Work, note, points, take
from pipelines.results import FloatArray
from pipelines.simulation.mass_spring import (
    MassSpringPlant,
    band_limited_noise,
    fine_times,
    simulate_mass_spring,
)

STEP = 0.01
PAGE = Path(__file__).resolve().parents[2] / "docs" / "gpc_filter.md"


@kernel
def pendulum(
    x: FloatArray,
    drive: FloatArray,
    measured: FloatArray,
    kinds: IntArray,
    arrays: FilterArrays,
    work: Work,
    record: Record,
) -> int:
    """angle'' = -9.81 / length sin(angle) - damping angle' + drive."""
    values = np.empty((x.shape[0], arrays.basis.shape[1]))
    predicted = np.empty((kinds.shape[0], arrays.basis.shape[1]))
    step = arrays.step_s
    for k in range(measured.shape[0]):
        points(x, arrays, values, k == 0)
        for q in range(values.shape[1]):
            if k > 0:
                accel = (
                    drive[k - 1, 0] - 9.81 / values[2, q] * np.sin(values[0, q]) - values[3, q] * values[1, q]
                )
                values[1, q] += step * accel
                values[0, q] += step * values[1, q]
            for j in range(kinds.shape[0]):
                predicted[j, q] = values[kinds[j], q]
        if not take(x, values, predicted, measured[k], arrays, work):
            return k
        note(x, work, k, record)
    return len(measured)


PENDULUM = StateSpaceModel(
    "pendulum", ("angle", "rate"), ("length", "damping"), ("drive",), ("angle", "rate"), pendulum
)


def test_length_and_damping_of_a_driven_pendulum_with_large_swings() -> None:
    rng = np.random.default_rng(0)
    drive = 4.0 * np.repeat(rng.standard_normal(40), 50)
    angle, rate, angles = 0.8, 0.0, []
    for push in drive:
        angles.append(angle)
        rate += STEP * (push - 9.81 / 1.3 * np.sin(angle) - 0.2 * rate)
        angle += STEP * rate
    z = np.array(angles) + 0.01 * rng.standard_normal(len(angles))
    assert np.ptp(angles) > 2.0
    states = (Uncertain(0.8, 0.05, hermite()), Uncertain(0.0, 0.1, hermite()))
    parameters = (Uncertain(1.0, 0.3, hermite(), True), Uncertain(0.4, 0.5, hermite(), True))
    settings = GpcSettings((1e-4,))
    run = estimate_state_space(
        PENDULUM, row(drive), row(z), STEP, states, parameters, settings, outputs=("angle",)
    )
    whole = estimate_batch(
        PENDULUM, row(drive), row(z), STEP, states, parameters, settings, outputs=("angle",)
    )
    assert run.value("length")[-1] == pytest.approx(1.3, rel=0.01)
    assert run.value("damping")[-1] == pytest.approx(0.2, rel=0.1)
    for name, truth in (("length", 1.3), ("damping", 0.2)):
        low, high = whole.interval(name, 3.0)
        assert low < truth < high
        assert whole.judge(name)[0] == "identified"


def test_the_pages_example_runs_and_finds_the_mass() -> None:
    example = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[0]
    rng = np.random.default_rng(4)
    drive = simulate_mass_spring(
        MassSpringPlant(100.0, 400.0, 40.0),
        band_limited_noise(rng, fine_times(20.0, STEP), 0.05, 3.0, 200.0),
        STEP,
    )
    names: dict[str, Any] = {
        "force": drive.force,
        "position": drive.position + 0.02 * rng.standard_normal(len(drive.position)),
    }
    exec(example, names)
    assert names["run"].value("mass")[-1] == pytest.approx(100.0, rel=0.01)
    low, high = names["whole"].interval("mass", 3.0)
    assert low < 100.0 < high
