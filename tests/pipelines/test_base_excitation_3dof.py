"""The three-degree-of-freedom model: against plain Python, against a car built apart from it, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.models.base_excitation import between_samples
from pipelines.models.base_excitation_3dof import COLUMNS, Geometry, corner_response, hub_columns, warp_of
from pipelines.reproduce.gpc_map.setup import RATE_HZ, bench, table_of

ROW = np.array([1850, 3000, 800, 1.3, 0.02, 30e3, 31e3, 2500, 1500, 2400, 1400, 2e4, 1e4, 50.0])
GEOMETRY = Geometry(2.8, 1.6, 1.55)
STEP = 0.01


def hubs(rows: int) -> np.ndarray:
    """Four smooth hub accelerations."""
    time = np.arange(rows) * STEP
    waves = np.random.default_rng(0).uniform(0.5, 8.0, (4, 5))
    return np.column_stack([np.sin(2 * np.pi * np.outer(time, w)).sum(axis=1) for w in waves])


def plain(row: np.ndarray, hub: np.ndarray, *, warp: bool) -> np.ndarray:
    """The same equations wheel by wheel, in Python."""
    u = hub_columns(hub, GEOMETRY)
    w = warp_of(u, GEOMETRY.wheelbase_m, STEP) * warp
    middle = np.column_stack([between_samples(c) for c in hub.T])
    w_middle = np.column_stack([between_samples(c) for c in w.T])
    x = row[3] - np.array([0, 0, 1, 1]) * GEOMETRY.wheelbase_m
    tracks = np.array([GEOMETRY.track_front_m] * 2 + [GEOMETRY.track_rear_m] * 2)
    y = np.array([0.5, -0.5, 0.5, -0.5]) * tracks - row[4]
    spring, out, back = np.repeat(row[5:7], 2), np.repeat(row[[7, 9]], 2), np.repeat(row[[8, 10]], 2)
    # (86)-(88) with the warp as the fourth figure: four heights are a plane and a warp
    plane = np.linalg.inv(np.column_stack((np.ones(4), -x, y, x * y)))[:3]

    def body(s: np.ndarray, twist: np.ndarray) -> np.ndarray:
        e = s[0] - x * s[1] + y * s[2] - x * y * twist[0]
        v = s[3] - x * s[4] + y * s[5] - x * y * twist[1]
        force = -spring * e - np.where(v > 0, out, back) * v - row[13] * v / np.sqrt(v * v + 1e-4)
        for axle in range(2):
            bar = row[11 + axle] * (e[2 * axle] - e[2 * axle + 1]) / tracks[2 * axle] ** 2
            force[2 * axle] -= bar
            force[2 * axle + 1] += bar
        return np.array([force.sum() / row[0], -(x * force).sum() / row[1], (y * force).sum() / row[2]])

    def rate(s: np.ndarray, twist: np.ndarray, at: np.ndarray) -> np.ndarray:
        return np.concatenate((s[3:], body(s, twist) - plane @ at))

    state, found = np.zeros(6), []
    for k in range(len(hub)):
        a = body(state, w[k])
        found.append(a[0] - x * a[1] + y * a[2])
        if k + 1 == len(hub):
            break
        r1 = rate(state, w[k], hub[k])
        r2 = rate(state + STEP / 2 * r1, w_middle[k], middle[k])
        r3 = rate(state + STEP / 2 * r2, w_middle[k], middle[k])
        r4 = rate(state + STEP * r3, w[k + 1], hub[k + 1])
        state = state + STEP / 6 * (r1 + 2 * (r2 + r3) + r4)
    return np.array(found)


@pytest.mark.parametrize("warp", [True, False])
def test_the_kernel_equals_plain_python(warp: bool) -> None:
    hub = hubs(300)
    fast = corner_response(np.vstack((1.1 * ROW, ROW)), hub, GEOMETRY, STEP, warp=warp)
    assert fast.shape == (2, 300, 4)
    np.testing.assert_allclose(fast[1], plain(ROW, hub, warp=warp), atol=1e-12)
    assert np.abs(fast[0] - fast[1]).max() > 0.01


def test_it_is_a_car_of_seven_degrees_of_freedom_seen_from_its_hubs() -> None:
    """That car was written from the drawing alone; with the hubs' warp the model is exact for it, without not."""
    place = bench(np.random.default_rng(3))
    table = table_of(place.car, place.car.truth[None])
    after = slice(500, 3000)
    size = place.seven[after].std()
    off = {
        warp: (corner_response(table, place.hubs, place.geometry, 1 / RATE_HZ, warp=warp)[0] - place.seven)[
            after
        ]
        for warp in (True, False)
    }
    assert off[True].std() < 0.03 * size
    assert off[False].std() > 2 * off[True].std()


def test_slow_hubs_carry_the_body_along_and_rest_stays_rest() -> None:
    time = np.arange(4000) * STEP
    slow = np.repeat((0.2 * np.sin(0.4 * time) * (1 - np.exp(-time)))[:, None], 4, axis=1)
    linear = ROW.copy()
    linear[7:11], linear[13] = 2000.0, 0.0
    body = corner_response(linear[None], slow, GEOMETRY, STEP)[0]
    np.testing.assert_allclose(body[1500:], slow[1500:], atol=0.004)
    assert not corner_response(linear[None], np.zeros((50, 4)), GEOMETRY, STEP).any()


def test_masses_come_in_proportion_to_stiffness() -> None:
    hub = hubs(500)
    scaled = ROW * np.array([1.1] * 3 + [1.0, 1.0] + [1.1] * 9)
    one, other = corner_response(np.vstack((ROW, scaled)), hub, GEOMETRY, STEP)
    np.testing.assert_allclose(one, other, atol=1e-10)


def test_what_cannot_be_is_refused() -> None:
    hub = hubs(20)
    with pytest.raises(ValueError, match="four samples"):
        corner_response(ROW[None], hub[:3], GEOMETRY, STEP)
    with pytest.raises(ValueError, match="four samples"):
        corner_response(ROW[None], hub[:, :3], GEOMETRY, STEP)
    with pytest.raises(ValueError, match=f"{len(COLUMNS)} figures"):
        corner_response(ROW[None, :5], hub, GEOMETRY, STEP)
    with pytest.raises(ValueError, match="above 0"):
        corner_response(-ROW[None], hub, GEOMETRY, STEP)
