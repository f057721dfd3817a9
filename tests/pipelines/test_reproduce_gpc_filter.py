"""The gPC-EKF's page: its plant, its claims, and its study against the bound."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from pipelines.reproduce.gpc_filter.asymmetric import asymmetric
from pipelines.reproduce.gpc_filter.convergence import convergence
from pipelines.reproduce.gpc_filter.excitation import excitation
from pipelines.reproduce.gpc_filter.improvements import improvements
from pipelines.reproduce.gpc_filter.part import Part
from pipelines.reproduce.gpc_filter.setup import STEP_S, settled, sine_force
from pipelines.reproduce.gpc_filter.study import bound, setups, study
from pipelines.reproduce.registry import paper
from pipelines.simulation.mass_spring import (
    MassSpringPlant,
    band_limited_noise,
    fine_times,
    simulate_mass_spring,
)


def test_the_plant_swings_as_the_solution_says() -> None:
    force = np.zeros(len(fine_times(10.0, STEP_S)))
    drive = simulate_mass_spring(MassSpringPlant(100.0, 400.0, 40.0), force, STEP_S, (1.0, 0.0))
    decay, swing = 0.2, np.sqrt(4.0 - 0.04)
    exact = np.exp(-decay * drive.time_s) * (
        np.cos(swing * drive.time_s) + decay / swing * np.sin(swing * drive.time_s)
    )
    np.testing.assert_allclose(drive.position, exact, atol=1e-9)


def test_a_change_of_mass_keeps_position_and_velocity_but_not_the_frequency() -> None:
    force = np.zeros(len(fine_times(20.0, STEP_S)))
    plant = MassSpringPlant(100.0, 400.0, later_mass_kg=400.0, change_s=10.0)
    drive = simulate_mass_spring(plant, force, STEP_S, (1.0, 0.0))
    np.testing.assert_allclose(drive.position[:1000], np.cos(2 * drive.time_s[:1000]), atol=1e-8)
    x, v = drive.position[1000], drive.velocity[1000]
    later = drive.time_s[1000:] - 10.0
    np.testing.assert_allclose(drive.position[1000:], x * np.cos(later) + v * np.sin(later), atol=1e-8)


def test_friction_takes_energy_and_a_wrong_length_is_refused() -> None:
    force = np.zeros(len(fine_times(10.0, STEP_S)))
    drive = simulate_mass_spring(MassSpringPlant(100.0, 400.0, friction_n=10.0), force, STEP_S, (1.0, 0.0))
    # Coulomb friction takes 4 F / k from the amplitude in each period
    period = round(np.pi / STEP_S)
    assert drive.position[period] == pytest.approx(1.0 - 4 * 10.0 / 400.0, abs=0.005)
    with pytest.raises(ValueError, match="fine_times"):
        simulate_mass_spring(MassSpringPlant(), force[:-1], STEP_S)


def test_band_limited_noise_has_its_power_in_the_band() -> None:
    times = fine_times(40.0, STEP_S)
    force = band_limited_noise(np.random.default_rng(0), times, 0.5, 2.0, 200.0)
    power, frequency = np.abs(np.fft.rfft(force)) ** 2, np.fft.rfftfreq(len(times), times[1])
    outside = power[(frequency < 0.45) | (frequency > 2.05)].sum()
    assert outside < 1e-12 * power.sum()
    assert np.std(force) == pytest.approx(200.0, rel=1e-6)


def test_settled_is_when_the_last_excursion_ends() -> None:
    values = np.full(1000, 100.0)
    values[:300], values[500] = 600.0, 110.0
    assert settled(values, 100.0, 0.0, 10.0) == pytest.approx(5.01)
    assert settled(values, 100.0, 6.0, 10.0) == 0.0
    values[-1] = np.nan
    assert settled(values, 100.0, 0.0, 10.0) is None


@pytest.mark.parametrize(
    ("part", "differing"),
    [
        (improvements, {"Figures 3.10-3.11, Table 3.4"}),
        (asymmetric, {"Figure 3.21"}),
        (excitation, set()),
        (convergence, set()),
    ],
)
def test_the_figures_messages_hold_but_for_those_that_are_known_not_to(
    part: Callable[[np.random.Generator], Part], differing: set[str]
) -> None:
    found = part(np.random.default_rng(1))
    assert {claim.place for claim in found.claims if claim.agreement != "agrees"} <= differing
    assert all(len(row) == len(table.columns) for table in found.tables for row in table.rows)
    assert all(
        column.shape == trace.time_s.shape for trace in found.traces for column in trace.columns.values()
    )
    assert found.traces


def test_printed_settings_of_table_33_leave_the_mass_where_it_starts() -> None:
    table = improvements(np.random.default_rng(2)).tables[0]
    masses = {row[0]: row[6] for row in table.rows}
    assert masses["Table 3.3 as printed"] == pytest.approx(600.0, rel=0.01)
    assert masses["Table 3.3, c 1e-4, c1 0.005"] == pytest.approx(150.0, rel=0.01)


def test_the_study_reaches_the_bound_for_the_mass() -> None:
    rng = np.random.default_rng(3)
    chosen = setups(rng, sine_force())[0]
    rows = {row.method: row for row in study(chosen, 12, rng)}
    limit = bound(chosen)["mass"]
    for method in ("square-root form", "whole record at once"):
        assert rows[method].bound == pytest.approx(limit)
        assert 0.4 < (rows[method].ratio or 0.0) < 1.8
        assert (rows[method].coverage or 0.0) > 0.7
    assert (rows["gPC-EKF as published"].ratio or 0.0) > 2.0


def test_the_page_is_registered() -> None:
    assert paper("gpc_filter").name == "gpc_filter"
