"""Springs that rest on their stops under a load: when a drive is joined with their rates open, and when not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from pipelines.evidence import Evidence, Values
from pipelines.joint.inference import infer
from pipelines.joint.posterior import find_mode
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.on_stops import NAME, RATE, WIDER, on_stops, stop_ways
from pipelines.results import FloatArray
from tests.pipelines.joint_parts import vehicle

CAR = vehicle()
KNOWN = before_the_log(CAR)
WHEELS = ("fl", "fr", "rl", "rr")
RATES = {w: float(KNOWN.mean[KNOWN.index(f"spring_{'front' if w[0] == 'f' else 'rear'}")]) for w in WHEELS}


def _rates(values: Values) -> FloatArray:
    """Force of each wheel's spring a metre of quick travel, kN/m."""
    rows = [
        1e-3
        * np.asarray(values[f"scale_{w}"])
        * np.asarray(values[f"spring_{'front' if w[0] == 'f' else 'rear'}"])
        for w in WHEELS
    ]
    return np.array(np.broadcast_arrays(*rows))


def _seen(factors: Sequence[float]) -> Evidence:
    """What the drive shows of the four rates, to 3 %: so many times the springs' own."""
    observed = np.array([1e-3 * f * RATES[w] for f, w in zip(factors, WHEELS, strict=True)])
    names = tuple(
        f"{part}_{x}" for part, xs in (("scale", WHEELS), ("spring", ("front", "rear"))) for x in xs
    )
    return Evidence(
        "roll", "spring deflections", "rates in quick motion", "by hand", observed, np.diag((0.03 * observed) ** 2), _rates, names,
    )  # fmt: skip


def test_one_axle_is_open_and_nothing_else() -> None:
    free = on_stops(KNOWN, "rear", CAR)
    changed = {n for n, a, b in zip(KNOWN.names, KNOWN.std, free.std, strict=True) if a != b}
    assert changed == {"scale_rl", "scale_rr", "zero_rl", "zero_rr", *(f"{part}_rear" for part in WIDER)}
    assert np.array_equal(free.mean, KNOWN.mean)
    assert free.std[KNOWN.index("scale_rl")] == RATE


@pytest.mark.parametrize(
    ("factors", "likely"),
    [((1.0, 1.0, 1.0, 1.0), None), ((1.0, 1.0, 2.2, 1.5), "rear"), ((1.9, 1.6, 1.0, 1.0), "front")],
)
def test_the_odds_are_for_the_axle_whose_rates_are_not_its_springs(
    factors: tuple[float, ...], likely: str | None
) -> None:
    evidence = (_seen(factors),)
    odds = {axle: ln for axle, ln, *_ in stop_ways(find_mode(evidence, KNOWN), evidence, KNOWN, CAR)}
    assert set(odds) == {"front", "rear"}
    for axle, ln in odds.items():
        assert (ln > 3) is (axle == likely), odds


def test_the_odds_are_a_ratio_of_integrals() -> None:
    """One wheel's rate by itself, by brute force over its scale: the rear axle's other unknowns are in no relation."""
    seen = replace(_seen((1.0, 1.0, 1.3, 1.0)))
    only = replace(seen, observed=seen.observed[2:3], covariance=seen.covariance[2:3, 2:3], predict=lambda v: _rates(v)[2:3],
                   unknowns=("scale_rl", "scale_rr", "spring_rear"))  # fmt: skip
    soft = find_mode((only,), KNOWN)
    odds = {axle: ln for axle, ln, *_ in stop_ways(soft, (only,), KNOWN, CAR)}
    rate = RATES["rl"]
    noise = 0.03 * 1.3
    spread = float(KNOWN.std[KNOWN.index("spring_rear")]) / rate

    def integral(std: float) -> float:
        """Density of a rate of 1.3 where the scale has that spread."""
        wide = np.hypot(noise, np.hypot(std, spread))
        return float(-0.5 * (0.3 / wide) ** 2 - np.log(wide))

    chance = np.log(0.01 / 0.99)
    assert odds["rear"] == pytest.approx(integral(RATE) - integral(0.01) + chance, abs=0.15)


def test_a_drive_without_deflections_is_not_asked() -> None:
    blind = replace(_seen((1.0, 1.0, 2.0, 2.0)), unknowns=("spring_rear",))
    assert list(stop_ways(find_mode((blind,), KNOWN), (blind,), KNOWN, CAR)) == []


def test_the_verdict_says_so() -> None:
    found = infer((_seen((1.0, 1.0, 2.2, 1.5)),), CAR, np.random.default_rng(0))
    assert found is not None
    assert any(text.startswith(NAME.format("rear")) for text in found.record.spoke_for), found.record
