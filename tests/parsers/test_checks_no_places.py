"""Accelerations in columns called Lat and Long are no places; places of any receiver are."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.checks import check_all
from parsers.checks.no_places import no_altitude, no_places
from parsers.drive import Signal

T = np.arange(3000) / 50
STATED = {"latitude": False, "longitude": False}
ACCELS = (0.3 * np.sin(0.6 * T), 0.2 * np.cos(0.9 * T))
NOISE = 2e-5 * np.random.default_rng(1).standard_normal((2, 3000))
METRE = 1 / 111_195


def places(north: np.ndarray, east: np.ndarray) -> dict[str, Signal]:
    time_ns = (T * 1e9).astype(np.int64)
    return {
        "latitude": Signal("latitude", time_ns, north, "Lat"),
        "longitude": Signal("longitude", time_ns, east, "Long"),
    }


@pytest.mark.parametrize(("times", "unit"), [(1.0, "g"), (9.81, "m/s2")])
def test_accelerations_are_left_out_and_their_lines_are_said(times: float, unit: str) -> None:
    signals = places(*(times * each for each in ACCELS))
    speed = Signal("speed", signals["latitude"].time_ns, np.full(3000, 20.0), "Speed")
    found = check_all({**signals, "speed": speed}, fix=True, units_stated={**STATED, "speed": True})
    assert list(found.signals) == ["speed"]
    (said, other) = (each for each in found.decisions if each.kind == "range")
    assert {said.signal, other.signal} == {"latitude", "longitude"}
    assert f'[signals.accel_y] channel = "Lat", unit = "{unit}"' in said.action


@pytest.mark.parametrize(
    ("north", "east"),
    [
        (52 + 40 * METRE * T, 13 + 0 * T),
        (0.1 + 40 * METRE * T, 0.2 + 40 * METRE * T),
        (52 + NOISE[0], 13 + NOISE[1]),
        (np.round(52 + 60 * METRE * T, 4), np.round(13 + 30 * METRE * T, 4)),
        (np.where(T % 7 < 0.02, 0.0, 52 + 30 * METRE * T), np.where(T % 7 < 0.02, 0.0, 13 + 0 * T)),
    ],
    ids=["motorway", "gulf of guinea", "noise of metres in every row", "steps of 11 m", "lost fixes"],
)
def test_places_stay(north: np.ndarray, east: np.ndarray) -> None:
    assert no_places(places(north, east), STATED) == {}


def test_places_whose_unit_is_stated_are_not_doubted() -> None:
    assert no_places(places(*ACCELS), {}) == {}


def height(values: np.ndarray) -> dict[str, Signal]:
    return {"altitude": Signal("altitude", (T * 1e9).astype(np.int64), values, "Height")}


def test_a_body_s_height_in_mm_is_no_altitude() -> None:
    body = height(120 + 20 * np.sin(2 * np.pi * 1.3 * T))
    assert "no height above the sea" in no_altitude(body, {"altitude": False})["altitude"].found
    assert no_altitude(body, {}) == {}


def test_an_altitude_stays() -> None:
    noise = np.random.default_rng(2).standard_normal(3000)
    for values in (300 + 4 * T, np.round(300 + 3 * T), 300 + noise, 300 + 0 * T):
        assert no_altitude(height(values), {"altitude": False}) == {}
