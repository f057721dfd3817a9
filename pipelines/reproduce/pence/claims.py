"""The claims of the paper's text, each beside what ours and the companion give."""

from __future__ import annotations

import itertools

import numpy as np

from pipelines.reproduce.base import Agreement, Claim, StudyRow
from pipelines.reproduce.pence.setup import SPEEDS, Bench, companion, published
from pipelines.reproduce.pence.tables import Shown
from pipelines.results import FloatArray

OFF_GROUND = {2.0: 0.0, 4.0: 0.0, 8.0: 0.05, 12.0: 0.78, 16.0: 4.45}
"""Share of the time in % that the tyre is off the ground (section IV)."""


def _agreement(holds: bool) -> Agreement:
    return "agrees" if holds else "differs"


def claims(place: Bench, shown: Shown, rows: tuple[StudyRow, ...]) -> tuple[Claim, ...]:
    """All of them."""
    return (
        _quick(place, shown),
        _exact(place),
        _zero_order_hold(place),
        _ranges(shown, "IV", "ω_n from 3 to 10 rad/s is good; too low drifts, too high is less accurate", (3.0, 10.0), "rad/s"),
        _ranges(shown, "V", "ζ from 0.05 to 0.25 is good", (0.05, 0.25), ""),
        _off_ground(place),
        _noise(shown),
        _limit(rows),
    )  # fmt: skip


def _quick(place: Bench, shown: Shown) -> Claim:
    truth = place.car.sprung_kg
    error = 100 * np.abs(shown.nominal.track[:, 0] - truth) / truth
    inside = error <= 8.0
    late = np.flatnonzero(~inside)
    since = 0 if len(late) == 0 else int(late[-1]) + 1
    stays = since < len(error)
    ours = f"within 8 % from {since + 1} s on" if stays else f"{error[-1]:.1f} % at the end"
    off = 100 * abs(shown.companion_nominal_kg - truth) / truth
    return Claim(
        "V", "run 4 converges to within 8 % of the true mass in less than 100 s", ours,
        f"{off:.2f} % from all 200 s", _agreement(stays and since < 100),
    )  # fmt: skip


def _exact(place: Bench) -> Claim:
    run = place.linear
    ours = published(run.accel_sprung, run.accel_unsprung, run)
    batch = companion(run.accel_sprung, run.accel_unsprung, run)
    truth, damping = run.car.sprung_kg, run.car.extension_nspm
    holds = abs(ours.mass_kg - truth) < 0.001 * truth and abs(ours.damping_nspm - damping) < 0.001 * damping
    return Claim(
        "V", "without noise and with a linear damper the estimate is exact (803 kg, 7 000 N·s/m)",
        f"{ours.mass_kg:.1f} kg, {ours.damping_nspm:.0f} N·s/m",
        f"{batch.mass_kg:.1f} kg, {np.mean(batch.values[1:3]):.0f} N·s/m", _agreement(holds),
        "With the filters discretised by Tustin's rule.",
    )  # fmt: skip


def _zero_order_hold(place: Bench) -> Claim:
    from scipy.signal import cont2discrete, lfilter

    from pipelines.filters.least_squares import recursive_least_squares
    from pipelines.reproduce.pence.setup import DAMPING_RATIO, INITIAL_COVARIANCE, NATURAL_RADPS

    run = place.linear
    below = [1.0, 2 * DAMPING_RATIO * NATURAL_RADPS, NATURAL_RADPS**2]

    def held(above: list[float], column: FloatArray) -> FloatArray:
        system = (np.array(above), np.array(below))
        b, a, _ = cont2discrete(system, run.step_s, method="zoh")
        return np.asarray(lfilter(np.ravel(b), a, column))

    apart = run.accel_sprung - run.accel_unsprung
    phi = np.column_stack((held([1.0, 0.0, 0.0], run.accel_sprung), held([1.0, 0.0], apart)))
    y = -run.car.spring_npm * held([1.0], apart)
    _, theta, _ = recursive_least_squares(phi, y, np.zeros(2), INITIAL_COVARIANCE * np.eye(2))
    return Claim(
        "II-B", "the filtered equation is exact, so that no velocity or displacement is needed",
        f"with a zero-order hold in the filters: {theta[0]:.1f} kg, {theta[1]:.0f} N·s/m", "", "agrees",
        "It is exact for the continuous filters; a zero-order hold loses it, Tustin's rule keeps it.",
    )  # fmt: skip


def _ranges(shown: Shown, table: str, said: str, good: tuple[float, float], unit: str) -> Claim:
    errors = shown.errors[table]
    inside = [e for key, e in errors.items() if good[0] <= key <= good[1]]
    outside = {key: e for key, e in errors.items() if not good[0] <= key <= good[1]}
    best = min(errors, key=lambda key: errors[key])
    words = ", ".join(f"{key:g}{' ' + unit if unit else ''}: {e:.1f} %" for key, e in errors.items())
    holds = good[0] <= best <= good[1] and max(outside.values()) > max(inside)
    return Claim(
        f"Table {table}", said, words, "has no such filter", _agreement(holds),
        "" if holds else f"The best here is {best:g}: which one is, hangs on the terrain and on one draw of noise.",
    )  # fmt: skip


def _off_ground(place: Bench) -> Claim:
    ours = {v: 100 * run.off_ground for v, run in zip(SPEEDS, place.by_speed, strict=True)}
    printed = " / ".join(f"{OFF_GROUND[v]:g}" for v in SPEEDS[2:])
    words = " / ".join(f"{ours[v]:.2f}" for v in SPEEDS[2:])
    # an order of magnitude at most, and growing with speed
    holds = ours[8.0] < ours[12.0] < ours[16.0] and all(
        OFF_GROUND[v] / 3 <= ours[v] <= 3 * OFF_GROUND[v] for v in (12.0, 16.0)
    )
    return Claim(
        "IV", f"the tyre is off the ground {printed} % of the time at 8 / 12 / 16 m/s", f"{words} %",
        "takes no notice of it: the hub's acceleration is measured", _agreement(holds),
        "The terrain was scaled to the hub's acceleration, not to this; the rarest bumps decide it.",
    )  # fmt: skip


def _noise(shown: Shown) -> Claim:
    errors = shown.errors["VII"]
    grows = list(errors.values())
    holds = all(later >= before - 1.0 for before, later in itertools.pairwise(grows))
    words = ", ".join(
        f"{'none' if np.isinf(db) else f'{db:g} dB'}: {error:.1f} %" for db, error in errors.items()
    )
    return Claim(
        "V",
        "the estimate degrades almost in proportion to the noise",
        words,
        shown.companion_noise,
        _agreement(holds),
    )


def _limit(rows: tuple[StudyRow, ...]) -> Claim:
    found = {
        row.method: row for row in rows if row.setup == "two damper slopes" and row.parameter == "sprung mass"
    }
    first, second = found["published"], found["companion"]
    return Claim(
        "VI", "the method may prove viable; total least squares is expected to do better",
        f"RMSE {first.rmse:.1f} kg ({100 * first.rmse / first.truth:.1f} %), {first.ratio or 0:.0f} times the bound",
        f"RMSE {second.rmse:.2f} kg ({100 * second.rmse / second.truth:.2f} %), {second.ratio or 0:.2f} times the bound",
        "agrees", "Both dampers as parameters and noise in both sensors accounted for: this is what the data allow.",
    )  # fmt: skip
