"""A vehicle file that has the CG where no such vehicle has it: said, and doubted as much as it is believed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from parsers.drive import ImportRecord
from pipelines.file_limits import FILE_UNLIKE
from pipelines.joint.doubts.stated_figures import (
    PLACE,
    TRACKS,
    UNHEARD_OF,
    chance_wrong,
    file_doubts,
    not_as_stated,
)
from pipelines.joint.file_check import STATED, UNSPRUNG, stated_unknowns
from pipelines.joint.inference import infer
from pipelines.joint.posterior import find_mode
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.file_ways import file_ways, joined_again
from pipelines.limits import what_limits
from pipelines.simulation.plant.random_vehicle import KINDS, random_vehicle
from pipelines.vehicles.unheard_of import front_share, odd_axles, tracks_apart, usual_place
from pipelines.vehicles.vehicle import Quantity, Vehicle
from tests.pipelines.joint_parts import linear, vehicle

RECORD = ImportRecord("CSV table", (), "0", "complete", 1, {}, (), "clock", None, 10.0, ())


def _file(place: float, length: float = 2.6, mass: float = 1400.0, body: str | None = None) -> Vehicle:
    figures = {"mass_kg": mass, "wheelbase_m": length, "cg_to_front_axle_m": place}
    quantities = {n: Quantity(v, 0.01 * v, "vehicle file") for n, v in figures.items()}
    return Vehicle(quantities=quantities, body=body)


@pytest.mark.parametrize(
    ("file", "unlike"),
    [
        (_file(0.72), True), (_file(1.05), False), (_file(1.56), False), (_file(1.85), True), (_file(0.83), False),
        (_file(0.7, body="Hatchback"), True), (_file(1.05, 3.6, 2100.0, "Van"), True), (_file(1.5, 3.6, 2100.0, "Van"), False),
        # a tractor's engine lies over its front axle, a robot's battery where there is room
        (_file(1.1, 3.8, 7200.0, "Tractor"), False), (_file(0.1, 0.6, 40.0), False),
    ],
)  # fmt: skip
def test_which_places_no_such_vehicle_has(file: Vehicle, unlike: bool) -> None:
    assert (front_share(file) is not None) is unlike
    assert (chance_wrong(PLACE, file) == UNHEARD_OF) is unlike
    assert bool(not_as_stated(PLACE, file)) is unlike


@pytest.mark.parametrize("body", KINDS)
def test_every_simulated_vehicle_is_within_the_bounds(body: str) -> None:
    rng = np.random.default_rng(11)
    for _ in range(12):
        one = random_vehicle(rng, body)
        file = _file(one.cg_to_front_axle_m, one.wheelbase_m, one.mass_kg, body)
        axles = {f"unsprung_mass_{a}_kg": getattr(one, f"unsprung_mass_{a}_kg") for a in ("front", "rear")}
        tracks = {f"track_{a}_m": getattr(one, f"track_{a}_m") for a in ("front", "rear")}
        assert front_share(file) is None
        assert odd_axles(_with(file, axles)) == {}
        assert tracks_apart(_with(file, tracks)) is None


@pytest.mark.parametrize(
    ("front_share_of", "length", "mass", "body"),
    [(0.37, 2.35, 1500.0, "Coupe"), (0.45, 1.87, 880.0, "Hatchback"), (0.67, 2.85, 1270.0, "Sedan"), (0.35, 2.41, 1233.0, "Coupe"),
     (0.58, 3.66, 2150.0, "Van")],
)  # fmt: skip
def test_real_vehicles_at_the_ends_are_not_accused(
    front_share_of: float, length: float, mass: float, body: str
) -> None:
    """An engine behind the rear axle, a car of two seats, a Citroën with all of its engine before the front one, a long van."""
    assert front_share(_file((1 - front_share_of) * length, length, mass, body)) is None


@pytest.mark.parametrize(
    ("front", "rear", "mass", "live"),
    [(230.0, 211.0, 1900.0, True), (62.0, 99.0, 540.0, False), (145.0, 190.0, 2050.0, False), (70.0, 143.0, 1400.0, True)],
)  # fmt: skip
def test_real_axles_are_not_accused(front: float, rear: float, mass: float, live: bool) -> None:
    """An off-roader on two live axles, a light racing car, a pickup, a muscle car's rear axle."""
    file = _file(1.1, 2.6, mass)
    base = (
        {"spring_base_front_m": 1.0, "spring_base_rear_m": 1.0, "track_front_m": 1.55, "track_rear_m": 1.55}
        if live
        else {}
    )
    assert (
        odd_axles(_with(file, {"unsprung_mass_front_kg": front, "unsprung_mass_rear_kg": rear, **base})) == {}
    )


def test_a_figure_that_is_stated_as_exact_is_not_doubted() -> None:
    """It is no unknown: a doubt of it, in its own spreads, would put the CG anywhere."""
    exact_place = vehicle(cg_to_front_axle_m=(0.5, 0.0))
    joint = find_mode([linear({"empty_mass": 1.0}, 1900.0, 15.0)], before_the_log(exact_place))
    assert not any(
        d.text.startswith(PLACE) and len(d.names) == 1 and d.mean[0] > 1e3
        for d in file_doubts(joint, exact_place)
    )
    found = infer([linear({"empty_mass": 1.0}, 1900.0, 15.0)], exact_place, np.random.default_rng(0))
    assert found is not None
    place = found.parameters["cg_to_front_axle_m"]
    assert place.value is not None
    assert place.value < 1.0


def _short(place: float) -> Vehicle:
    """The parts' vehicle with its CG said to be there, to a centimetre."""
    return vehicle(cg_to_front_axle_m=(place, 0.01))


def test_what_no_vehicle_has_is_open_though_nothing_saw_it() -> None:
    """A log that knows the mass alone, beside a place that may be and one that no vehicle has."""
    spreads = {}
    length = vehicle().get("wheelbase_m")
    assert length is not None
    for share in (0.42, 0.27):
        file = _short(share * length.value)
        evidence = [linear({"empty_mass": 1.0}, 1900.0, 15.0)]
        found = infer(evidence, file, np.random.default_rng(0))
        assert found is not None
        answer = found.parameters["cg_to_front_axle_m"]
        assert answer.low is not None
        assert answer.high is not None
        spreads[share] = answer.high - answer.low
    usual = usual_place(vehicle())
    assert usual is not None
    assert spreads[0.27] > 2 * usual[1]
    assert spreads[0.42] < spreads[0.27]


def test_the_way_is_asked_where_vehicles_have_it() -> None:
    length = vehicle().get("wheelbase_m")
    assert length is not None
    file = _short(0.27 * length.value)
    known = before_the_log(file)
    evidence = [linear({"empty_x": 1.0}, 0.42 * length.value, 0.02)]
    told = {
        title: (odds, free)
        for title, odds, _, free, _ in file_ways(find_mode(evidence, known), evidence, known, file)
    }
    assert told.keys() <= STATED.keys()
    odds, free = told[PLACE]
    row = free.index("empty_x")
    assert (free.mean[row], free.std[row]) == usual_place(file)
    # 0.4 m off at 2 cm, in a file that states it to one
    assert odds > 50


def test_a_posterior_with_a_mean_elsewhere_is_found_from_where_it_was() -> None:
    known = before_the_log(vehicle())
    row = known.index("empty_x")
    mean = known.mean.copy()
    mean[row] += 0.3
    evidence = [linear({"empty_x": 1.0}, float(known.mean[row]) + 0.1, 0.01)]
    first = find_mode(evidence, known)
    again = joined_again(first, evidence, known, replace(known, mean=mean))
    exact = find_mode(evidence, replace(known, mean=mean))
    assert again.u == pytest.approx(exact.u, abs=1e-6)


def test_it_is_said() -> None:
    def told(place: float) -> list[str]:
        return [text for text in what_limits(RECORD, (), {}, _file(place)) if text.startswith(FILE_UNLIKE)]

    assert told(1.05) == []
    (text,) = told(0.72)
    assert "72.3% of the empty mass on the front axle (cg_to_front_axle_m 0.720, wheelbase_m)" in text


def test_the_doubt_has_it_where_it_is_usual() -> None:
    file = _file(0.72)
    joint = find_mode([linear({"empty_mass": 1.0}, 1400.0, 15.0)], before_the_log(file))
    (doubt,) = [d for d in file_doubts(joint, file) if d.text.startswith(PLACE)]
    row = joint.known.index("empty_x")
    usual = usual_place(file)
    assert usual is not None
    assert joint.known.mean[row] + joint.known.std[row] * doubt.mean[0] == pytest.approx(usual[0])


def _with(file: Vehicle, more: dict[str, float]) -> Vehicle:
    quantities = {n: Quantity(v, 0.05 * v, "vehicle file") for n, v in more.items()}
    return replace(file, quantities={**file.quantities, **quantities})


@pytest.mark.parametrize(
    ("file", "front_kg", "unlike"),
    [
        (_file(1.1), 75.0, False), (_file(1.1), 190.0, True), (_file(1.1), 5.0, True), (_file(1.1), 170.0, False),
        (_file(1.1, 3.8, 7200.0, "Truck"), 550.0, False), (_file(1.1, 3.8, 7200.0, "Truck"), 1200.0, True), (_file(0.1, 0.6, 40.0), 12.0, False),
    ],
)  # fmt: skip
def test_axles_that_no_such_vehicle_has(file: Vehicle, front_kg: float, unlike: bool) -> None:
    file = _with(file, {"unsprung_mass_front_kg": front_kg})
    assert (odd_axles(file).keys() == {"front"}) is unlike
    assert (chance_wrong(UNSPRUNG, file) == UNHEARD_OF) is unlike
    assert (UNSPRUNG in stated_unknowns(file)) is unlike
    said = [text for text in what_limits(RECORD, (), {}, file) if "unsprung_mass_front_kg" in text]
    assert bool(said) is unlike


def test_a_sprung_mass_is_no_surer_than_the_axles_that_are_taken_off() -> None:
    """A weighed vehicle whose file has its front axle twice as heavy as any: the sprung mass holds the usual one as well."""
    told = {}
    for kilos in (100.0, 280.0):
        file = vehicle(unsprung_mass_front_kg=(kilos, 5.0), unsprung_mass_rear_kg=(100.0, 5.0))
        evidence = [linear({"empty_mass": 1.0, "load": 1.0}, 2050.0, 8.0)]
        found = infer(evidence, file, np.random.default_rng(0))
        assert found is not None
        told[kilos] = found.parameters["sprung_mass_kg"]
    right, wrong = told[100.0], told[280.0]
    assert wrong.low is not None
    assert wrong.high is not None
    assert right.value is not None
    assert wrong.low < right.value < wrong.high
    assert wrong.status != "identified"


@pytest.mark.parametrize(
    ("front", "rear", "unlike"),
    [(1.55, 1.56, False), (1.60, 1.50, False), (1.80, 1.56, True), (1.50, 1.75, True)],
)
def test_tracks_that_no_such_vehicle_has_together(front: float, rear: float, unlike: bool) -> None:
    file = _with(_file(1.1), {"track_front_m": front, "track_rear_m": rear})
    assert bool(not_as_stated(TRACKS, file)) is unlike
    said = [text for text in what_limits(RECORD, (), {}, file) if "track_front_m" in text]
    assert bool(said) is unlike
    if unlike:
        assert f"{abs(front - rear) * 1000:.0f} mm further apart" in said[0]
    # twin tyres
    lorry = _with(_file(1.1, 4.2, 7200.0, "Truck"), {"track_front_m": front, "track_rear_m": rear})
    assert not_as_stated(TRACKS, lorry) == {}
