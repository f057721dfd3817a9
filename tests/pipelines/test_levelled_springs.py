"""Springs that level themselves: their rate grows with the load, the body stays where it is, and a stated stiffness is the empty vehicle's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.joint.vehicle.stated import stated_relations
from pipelines.joint.vehicle.suspension import BELLOWS, levels, loaded_rate
from pipelines.joint.vehicle.unknowns import Known, before_the_log
from pipelines.vehicles.vehicle import Quantity, Vehicle

STEEL = Vehicle(
    body="SUV",
    self_levelling="none",
    quantities={
        "mass_kg": Quantity(2000.0, 20.0, "sheet"),
        "wheelbase_m": Quantity(2.9, 0.01, "sheet"),
        "spring_rate_front_npm": Quantity(30e3, 600.0, "sheet"),
        "spring_rate_rear_npm": Quantity(34e3, 700.0, "sheet"),
    },
)


def _law(known: Known, name: str) -> tuple[float, float]:
    return float(known.mean[known.index(name)]), float(known.std[known.index(name)])


def _with_load(vehicle: Vehicle, kilos: float, std: float) -> Vehicle:
    return replace(vehicle, load={"mass_kg": Quantity(kilos, std, "weighed")})


@pytest.mark.parametrize(("which", "axles"), [("both", ("front", "rear")), ("rear", ("rear",)), ("none", ())])
def test_only_levelled_axles_have_another_rate(which: str, axles: tuple[str, ...]) -> None:
    steel, air = before_the_log(STEEL), before_the_log(replace(STEEL, self_levelling=which))
    for axle in ("front", "rear"):
        assert levels(replace(STEEL, self_levelling=which), axle) == (axle in axles)
        rate, std = _law(steel, f"spring_{axle}")
        found, spread = _law(air, f"spring_{axle}")
        if axle in axles:
            assert found > 1.03 * rate
            assert spread > 3 * std
            assert _law(air, f"sinks_{axle}") == pytest.approx((0.0, 0.0), abs=1e-9)
        else:
            assert (found, spread) == (rate, std)


def test_an_air_spring_at_constant_volume_is_held() -> None:
    """k goes with the absolute pressure, the weight with the pressure over the outside's: by hand, from 6 bar to 9."""
    empty, full, outside = 6.0, 9.0, 1.0
    growth = (full + outside) / (empty + outside)
    # 0.5 more weight on the rear axle: by six tenths of the load
    load = 0.5 * 2000 / 1.5
    rate, std = loaded_rate("rear", (30e3, 0.0), (load, 0.0), 2000.0)
    assert abs(rate - growth * 30e3) < std
    assert rate == pytest.approx(30e3 * (1 + BELLOWS[0] * 0.5))


def test_no_load_is_the_stated_rate_and_a_weighed_one_is_surer() -> None:
    air = replace(STEEL, self_levelling="both")
    rate, std = _law(before_the_log(_with_load(air, 0.0, 5.0)), "spring_rear")
    assert rate == pytest.approx(34e3)
    assert std == pytest.approx(700.0, rel=0.02)
    weighed, unknown = (_law(before_the_log(v), "spring_rear") for v in (_with_load(air, 200.0, 5.0), air))
    assert weighed[0] == pytest.approx(unknown[0], rel=0.01)
    assert weighed[1] < 0.5 * unknown[1]


def test_a_stated_roll_stiffness_does_not_bind_springs_that_grow() -> None:
    told = dict(STEEL.quantities) | {"roll_stiffness_nmprad": Quantity(110e3, 2e3, "sheet")}
    steel = replace(STEEL, quantities=told)
    assert [e.title for e in stated_relations(steel)] == ["stated roll stiffness"]
    assert stated_relations(replace(steel, self_levelling="rear")) == ()
    # bars are what is left of it beside the springs of the empty vehicle
    bars = [_law(before_the_log(v), "bar_front")[0] for v in (steel, replace(steel, self_levelling="both"))]
    assert bars[0] == bars[1]


def test_the_unknowns_keep_their_order() -> None:
    steel, air = before_the_log(STEEL), before_the_log(replace(STEEL, self_levelling="both"))
    assert steel.names == air.names
    assert np.isfinite(air.mean).all()
