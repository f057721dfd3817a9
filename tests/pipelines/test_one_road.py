"""The wheelbase by the road that rear wheels meet after front ones: told whatever the axles' springs do, and no chance takes its place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.load_balance.one_road import CARRIER, SeenLength, road_evidence, seen_length
from pipelines.evidence import Evidence
from pipelines.joint.inference import infer
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.results import FloatArray
from tests.pipelines.joint_parts import linear, vehicle

LENGTH = 2.8
FINE_M = 0.02


def _shaken(length: float, rate_hz: float, *, alike: bool = True, steady: bool = False) -> Prepared:
    """Three minutes at 3 to 17 m/s, deflections of two axles with springs of their own. alike: whether both roll over one road."""
    rng = np.random.default_rng(5)
    t = np.arange(int(180 * rate_hz)) / rate_hz
    speed = np.full(len(t), 12.0) if steady else 10 + 5 * np.sin(0.11 * t) + 2 * np.sin(0.37 * t)
    way = np.cumsum(speed) / rate_hz
    places = np.arange(-20.0, way[-1] + 20.0, FINE_M)
    roads = [np.cumsum(rng.standard_normal(len(places))) * 2e-4 for _ in range(2)]
    roads = [r - np.convolve(r, np.ones(500) / 500, mode="same") for r in roads]

    def passed(road: FloatArray, behind: float, late_s: float, noise: float) -> FloatArray:
        """What an axle so far back shows, on springs that answer so much later."""
        seen = np.interp(np.interp(t - late_s, t, way) - behind, places, road)
        return lowpass(seen + noise * rng.standard_normal(len(t)), rate_hz, 0.3 * rate_hz)

    front = passed(roads[0], 0.0, 0.005, 2e-4)
    rear = passed(roads[0 if alike else 1], length, 0.03, 2e-4)
    columns = {"suspension_deflection_fl": front, "suspension_deflection_rl": rear}
    return Prepared(
        rate_hz, 0.3 * rate_hz, t, {**columns, "speed": speed}, (Segment(0, len(t)),), {}, frozenset(columns),
        np.zeros(len(t), dtype=bool),
    )  # fmt: skip


def _seen(prepared: Prepared, expected: float = LENGTH) -> SeenLength | None:
    return seen_length(prepared, prepared.columns["speed"], expected)


@pytest.mark.parametrize("rate_hz", [20.0, 50.0, 100.0])
@pytest.mark.parametrize("length", [2.4, 2.8, 3.2])
def test_the_length_is_that_of_the_vehicle_whatever_its_axles_do(rate_hz: float, length: float) -> None:
    """The rear axle answers 25 ms later, which is 0.25 m at 10 m/s."""
    found = _seen(_shaken(length, rate_hz))
    assert found is not None
    assert found.length == pytest.approx(length, rel=0.01)
    assert found.std < 0.01 * length


def test_what_no_common_road_shows_is_not_told() -> None:
    assert _seen(_shaken(LENGTH, 50.0, alike=False)) is None
    # at one speed the axles' own lateness and the way between them are one
    assert _seen(_shaken(LENGTH, 50.0, steady=True)) is None


def test_a_gap_or_a_rest_takes_nothing_with_it_but_its_time() -> None:
    whole = _shaken(LENGTH, 50.0)
    speed = whole.columns["speed"].copy()
    speed[3000:3500] = 0.0
    lost = {**whole.columns, "suspension_deflection_fl": whole.columns["suspension_deflection_fl"].copy()}
    lost["suspension_deflection_fl"][:1000] = np.nan
    found = replace(whole, columns=lost, segments=(Segment(0, 1000), Segment(1000, 9000)))
    seen = seen_length(found, whole.columns["speed"], LENGTH)
    assert seen is not None
    assert seen.length == pytest.approx(LENGTH, rel=0.01)
    assert seen_length(replace(whole, segments=(Segment(0, 2000),)), speed, LENGTH) is None


def test_channels_that_begin_and_end_some_rows_apart_cost_these_rows_alone() -> None:
    """Those of several buses do; one missing sample took the whole drive."""
    whole = _shaken(LENGTH, 50.0)
    late = {**whole.columns, "speed": whole.columns["speed"].copy()}
    late["speed"][:3] = late["speed"][-2:] = np.nan
    late["suspension_deflection_rl"] = late["suspension_deflection_rl"].copy()
    late["suspension_deflection_rl"][4000:4005] = np.nan
    found = _seen(replace(whole, columns=late))
    assert found is not None
    assert found.length == pytest.approx(LENGTH, rel=0.01)


def _inertia(share: float, std: float = 50.0) -> Evidence:
    """A log that tells the pitch inertia loosely: its share of what was known."""
    known = before_the_log(vehicle())
    usual = float(known.mean[known.index("pitch_inertia")])
    return replace(linear({"pitch_inertia": 1.0}, share * usual, std * usual / 100, "nod"), kind="pitch")


def test_a_wrong_wheelbase_is_named_and_takes_the_inertia_known_by_it_along() -> None:
    known = before_the_log(vehicle())
    shaken = _shaken(0.91 * LENGTH, 50.0)
    (road,) = road_evidence(shaken, shaken.columns["speed"], known)
    assert (road.kind, road.carrier) == ("length", CARRIER)
    rng = np.random.default_rng(0)
    right, wrong = (
        infer([*more, _inertia(1.0)], vehicle(), rng)
        for more in ([replace(road, observed=np.array([LENGTH]))], [road])
    )
    assert right is not None
    assert wrong is not None
    assert not right.record.spoke_for
    assert any(text.startswith("stated wheelbase wrong") for text in wrong.record.spoke_for)
    # what the drive leaves of it: the verdict may show what was known before, as the inertia itself is hardly seen
    at, off = (i.kept.told["pitch_inertia_kgm2"][0] for i in (right, wrong))
    assert off / at == pytest.approx(0.91**2, abs=0.06)


def test_a_length_alone_shows_neither_place_nor_inertia() -> None:
    known = before_the_log(vehicle())
    shaken = _shaken(LENGTH, 50.0)
    found = infer(road_evidence(shaken, shaken.columns["speed"], known), vehicle(), np.random.default_rng(0))
    assert found is not None
    assert {found.parameters[n].status for n in ("cg_to_front_axle_m", "pitch_inertia_kgm2")} == {
        "not_identifiable"
    }
