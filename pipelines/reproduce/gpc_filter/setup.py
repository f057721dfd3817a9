"""The mass-spring demonstration of 3.4.1: its drive, the tables' filter settings, and what is read from a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.filters.gpc_filter import GpcSettings, StateSpaceRun, Uncertain, estimate_state_space, row
from pipelines.filters.gpc_update import PUBLISHED
from pipelines.models.mass_spring import MASS_SPRING
from pipelines.results import FloatArray
from pipelines.simulation.mass_spring import (
    MassSpringDrive,
    MassSpringPlant,
    fine_times,
    simulate_mass_spring,
)

STEP_S = 0.01
DURATION_S = 80.0
CHANGE_S = 40.0
MASS_KG, LATER_KG = 100.0, 150.0
STIFFNESS_NPM = 400.0
"""Not printed; between 380 and 450 N/m the figures' story comes out (start at 600 kg below resonance, truth above)."""

DAMPING_NSPM = 40.0
"""Not printed."""

FORCE_N = 200.0
WITHIN = 0.05


@dataclass(frozen=True)
class FilterCase:
    """One table's settings. c: (49); c1: (58), in kg; m1, m2: mean and spread; noise: (52), mean and deviation; R.

    sensor_std: of the noise on the simulated position, m. start: the plant's position and velocity.
    """

    label: str
    c: float
    c1: float
    m1: float = 600.0
    m2: float = 10.0
    noise: tuple[float, float] = (0.0, 0.0)
    R: float = 0.01
    order: int = 3
    factor: float = 6.0
    sensor_std: float = 0.0
    logarithm: bool = False


def sine_force(duration_s: float = DURATION_S) -> FloatArray:
    """200 sin(t) N at the plant's times."""
    return np.asarray(FORCE_N * np.sin(fine_times(duration_s, STEP_S)))


def demo_drive(
    stiffness: float = STIFFNESS_NPM, start: tuple[float, float] = (0.0, 0.0), changes: bool = True
) -> MassSpringDrive:
    """The demonstration: 100 kg, 150 kg from 40 s on, 200 sin(t) N, no damper."""
    plant = MassSpringPlant(
        MASS_KG, stiffness, later_mass_kg=LATER_KG if changes else None, change_s=CHANGE_S
    )
    return simulate_mass_spring(plant, sine_force(), STEP_S, start)


def run_case(
    case: FilterCase,
    drive: MassSpringDrive,
    rng: np.random.Generator,
    *,
    stiffness: float = STIFFNESS_NPM,
    keep_every: int = 0,
    form: int = PUBLISHED,
) -> StateSpaceRun:
    """The filter on a drive, position measured; stiffness known, no damper."""
    position = drive.position + case.sensor_std * rng.standard_normal(len(drive.position))
    states = (Uncertain(0.0, start_noise=case.noise),) * 2
    mass = Uncertain(case.m1, case.m2, logarithm=case.logarithm, addition=case.c1)
    return estimate_state_space(
        MASS_SPRING, row(drive.force), row(position), STEP_S, states,
        (mass, Uncertain(stiffness), Uncertain(0.0), Uncertain(0.0)),
        GpcSettings((case.R,), case.order, case.factor, form, case.c, keep_every), rng=rng,
    )  # fmt: skip


def settled(
    values: FloatArray, truth: float, begin_s: float = 0.0, end_s: float = DURATION_S, within: float = WITHIN
) -> float | None:
    """Seconds after `begin_s` from which on the values stay within 5 % of the truth until `end_s`; None: they do not."""
    part = values[round(begin_s / STEP_S) : round(end_s / STEP_S)]
    outside = np.flatnonzero(~(np.abs(part / truth - 1.0) < within))
    first = 0 if not len(outside) else int(outside[-1]) + 1
    return None if first >= len(part) else first * STEP_S


def both_settled(run: StateSpaceRun) -> tuple[float | None, float | None]:
    """`settled` for 100 kg before the change and for 150 kg after it."""
    mass = run.value("mass")
    return settled(mass, MASS_KG, 0.0, CHANGE_S), settled(mass, LATER_KG, CHANGE_S, DURATION_S)


def at(values: FloatArray, time_s: float) -> float:
    """A run's value at a time."""
    return float(values[min(round(time_s / STEP_S), len(values) - 1)])


def seconds(value: float | None) -> str:
    """In words."""
    return "not" if value is None else f"{value:.1f} s"
