"""A load in the vehicle or on its roof: exact mixtures on linear relations, and what the file tells."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pipelines.joint.answers import Told
from pipelines.joint.doubts.listed import doubts_of, said
from pipelines.joint.doubts.weighed import Weighed
from pipelines.joint.mixture import doubted
from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.vehicle.load_places import INSIDE, ROOF, ROOF_LOAD, placed, places, usual_height
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle
from tests.pipelines.joint_parts import linear, vehicle

# nothing that could be doubted but where the load lies
SILENT = replace(vehicle(), quantities={"mass_kg": vehicle().quantities["mass_kg"]}, deflection_zero="loaded")
KNOWN = before_the_log(SILENT)
EMPTY = KNOWN.mean[KNOWN.index("empty_h")]
HEIGHT = KNOWN.index("load_h")


def _normal(x: FloatArray, mean: float, std: float) -> FloatArray:
    return np.asarray(np.exp(-0.5 * ((x - mean) / std) ** 2) / std)


def _on_roof(doubts: tuple[Weighed, ...]) -> float:
    """Share of the copies in which the load's mass is that of a roof's."""
    load = KNOWN.index("load")
    return sum(d.weight for d in doubts if load in d.rows and "load" not in d.doubt.names)


def _height(joint: Joint, doubts: tuple[Weighed, ...]) -> tuple[float, float]:
    gradient = np.zeros(len(joint.u))
    gradient[HEIGHT] = KNOWN.std[HEIGHT]
    middle = KNOWN.mean[HEIGHT] + KNOWN.std[HEIGHT] * joint.u[HEIGHT]
    std = float(np.sqrt(gradient @ joint.covariance @ gradient))
    found = doubted(Told(middle, std, middle - 1.96 * std, middle + 1.96 * std, None), gradient, doubts)
    return found.value, found.std


@pytest.mark.parametrize("ratio", [0.9, 1.3, 1.6, 2.2])
def test_the_height_is_that_of_both_places_by_their_chances(ratio: float) -> None:
    """Against a grid: a relation that sees the height to a quarter of the empty CG's, the mass as good as known."""
    seen, spread, kilos = ratio * EMPTY, 0.25 * EMPTY, 150.0
    relations = [linear({"load_h": 1.0}, seen, spread), linear({"load": 1.0}, kilos, 1.0)]
    joint = find_mode(relations, KNOWN)
    doubts = doubts_of(joint, SILENT)
    found = _height(joint, doubts)

    x = np.linspace(-2 * EMPTY, 6 * EMPTY, 200_001)
    usual = _normal(np.array([kilos]), KNOWN.mean[KNOWN.index("load")], KNOWN.std[KNOWN.index("load")])[0]
    roof = _normal(np.array([kilos]), *ROOF_LOAD)[0]
    law = INSIDE.chance * usual * _normal(x, INSIDE.mean * EMPTY, INSIDE.std * EMPTY)
    law = law + ROOF.chance * roof * _normal(x, ROOF.mean * EMPTY, ROOF.std * EMPTY)
    law = law * _normal(x, seen, spread)
    mean = float(x @ law / law.sum())
    assert found[0] == pytest.approx(mean, abs=0.01 * EMPTY)
    assert found[1] == pytest.approx(math.sqrt(float((x - mean) ** 2 @ law / law.sum())), rel=0.03)
    assert sum(d.weight for d in doubts) == pytest.approx(1.0)
    assert said(doubts) == ()


def test_a_heavy_load_is_not_on_the_roof_and_a_high_one_is() -> None:
    def share(kilos: float, ratio: float) -> float:
        relations = [linear({"load": 1.0}, kilos, 8.0), linear({"load_h": 1.0}, ratio * EMPTY, 0.2 * EMPTY)]
        return _on_roof(doubts_of(find_mode(relations, KNOWN), SILENT))

    assert share(500.0, 1.2) < 1e-4
    assert share(160.0, 1.1) < 0.1
    assert share(160.0, 2.2) > 0.85


def test_before_the_log_the_unknown_has_the_mean_and_spread_of_both() -> None:
    rng = np.random.default_rng(3)
    on_roof = rng.random(400_000) < ROOF.chance
    draws = np.where(
        on_roof, rng.normal(ROOF.mean, ROOF.std, 400_000), rng.normal(INSIDE.mean, INSIDE.std, 400_000)
    )
    mean, std = usual_height(SILENT)
    assert (mean, std) == pytest.approx((draws.mean(), draws.std()), rel=0.01)
    assert KNOWN.mean[HEIGHT] == pytest.approx(mean * EMPTY)
    assert KNOWN.std[HEIGHT] == pytest.approx(std * EMPTY)


def test_draws_of_what_was_known_have_each_load_at_one_place() -> None:
    """High loads are light: no draw of a roof's height weighs what a boot may hold."""
    rng = np.random.default_rng(5)
    normal = KNOWN.mean + KNOWN.std * rng.standard_normal((50_000, len(KNOWN.names)))
    drawn = placed(normal, KNOWN.names, KNOWN.places, rng)
    high, load = drawn[:, HEIGHT] / EMPTY, drawn[:, KNOWN.index("load")]
    assert (high.mean(), high.std()) == pytest.approx(usual_height(SILENT), rel=0.01)
    assert np.quantile(load[high > 2.4], 0.99) < ROOF_LOAD[0] + 2.6 * ROOF_LOAD[1]
    assert placed(normal, KNOWN.names, (), rng) is normal


def test_what_the_file_tells_of_the_load_is_no_matter_of_chance() -> None:
    def named(**told: float) -> list[set[str]]:
        load = {key: Quantity(value, 0.1, "vehicle file") for key, value in told.items()}
        file = replace(SILENT, load=load)
        mean = dict(zip(KNOWN.names, KNOWN.mean.tolist(), strict=True))
        return [{*place.figures} for place in places(file, mean)]

    assert named(height_m=0.9) == []
    assert named() == [{"load_h"}, {"load_h", "load", "load_x"}]
    assert named(mass_kg=200.0) == [{"load_h"}, {"load_h", "load_x"}]
    assert named(mass_kg=400.0) == []
    assert named(mass_kg=200.0, behind_front_axle_m=2.0) == [{"load_h"}, {"load_h"}]


def test_a_lorrys_load_has_one_law() -> None:
    heavy = Quantity(9000.0, 100.0, "vehicle file")
    lorry: Vehicle = replace(SILENT, body="Truck", quantities={**SILENT.quantities, "mass_kg": heavy})
    assert places(lorry, dict(zip(KNOWN.names, KNOWN.mean.tolist(), strict=True))) == ()
    assert usual_height(lorry) == (1.45, 0.65)
