"""The claims of the paper's text, each beside what ours and the companion give, and by which rule it is said to agree.

A printed figure agrees where it is within TWICE standard deviations of ours over draws of what the paper leaves to chance; "exact" means
within EXACT; words of trends are judged by the figures that their remark names.
"""

from __future__ import annotations

import numpy as np

from pipelines.reproduce.base import Agreement, Claim, StudyRow
from pipelines.reproduce.pence.setup import SPEEDS, Bench, companion, off_ground_of_terrains, published
from pipelines.reproduce.pence.tables import Shown
from pipelines.results import FloatArray

OFF_GROUND = {2.0: 0.0, 4.0: 0.0, 8.0: 0.05, 12.0: 0.78, 16.0: 4.45}
"""Share of the time in % that the tyre is off the ground (section IV)."""

DRAWS, TWICE = 8, 2.0
EXACT = 0.001
PROPORTION = 0.9
VIABLE = 0.08
"""DRAWS: of terrains. EXACT: share of the value. PROPORTION: least correlation of two figures that go in proportion."""


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
    inside = error <= 100 * VIABLE
    late = np.flatnonzero(~inside)
    since = 0 if len(late) == 0 else int(late[-1]) + 1
    stays = since < len(error)
    ours = f"within 8 % from {since + 1} s on" if stays else f"{error[-1]:.1f} % at the end"
    off = 100 * abs(shown.companion_nominal_kg - truth) / truth
    return Claim(
        "V", "run 4 converges to within 8 % of the true mass in less than 100 s", ours,
        f"{off:.2f} % from all 200 s", _agreement(stays and since < 100), "Agrees where it stays there to the end.",
    )  # fmt: skip


def _exact(place: Bench) -> Claim:
    run = place.linear
    ours = published(run.accel_sprung, run.accel_unsprung, run)
    batch = companion(run.accel_sprung, run.accel_unsprung, run)
    truth, damping = run.car.sprung_kg, run.car.extension_nspm
    holds = abs(ours.mass_kg - truth) < EXACT * truth and abs(ours.damping_nspm - damping) < EXACT * damping
    return Claim(
        "V", "without noise and with a linear damper the estimate is exact (803 kg, 7 000 N·s/m)",
        f"{ours.mass_kg:.1f} kg, {ours.damping_nspm:.0f} N·s/m",
        f"{batch.mass_kg:.1f} kg, {np.mean(batch.values[1:3]):.0f} N·s/m", _agreement(holds),
        f"With the filters discretised by Tustin's rule. Exact: within {100 * EXACT:g} %.",
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
    mass, damping = run.car.sprung_kg, run.car.extension_nspm
    holds = abs(theta[0] - mass) < EXACT * mass and abs(theta[1] - damping) < EXACT * damping
    return Claim(
        "II-B", "the filtered equation is exact, so that no velocity or displacement is needed",
        f"with a zero-order hold in the filters: {theta[0]:.1f} kg, {theta[1]:.0f} N·s/m", "", _agreement(holds),
        f"Exact: within {100 * EXACT:g} %. It is so for the continuous filters, and in discrete steps by Tustin's rule (the claim above); the paper does not "
        "print its rule, and a zero-order hold loses it.",
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
        "Agrees where the best lies in the range and something outside is worse than all in it. "
        + ("" if holds else f"The best here is {best:g}: which one is, hangs on the terrain and on one draw of noise."),
    )  # fmt: skip


def _off_ground(place: Bench) -> Claim:
    speeds = SPEEDS[2:]
    ours = {v: 100 * run.off_ground for v, run in zip(SPEEDS, place.by_speed, strict=True)}
    others = off_ground_of_terrains(speeds, DRAWS)
    middle, spread = others.mean(axis=0), others.std(axis=0, ddof=1)
    printed = np.array([OFF_GROUND[v] for v in speeds])
    apart = np.abs(printed - middle) > TWICE * spread
    words = " / ".join(f"{ours[v]:.2f}" for v in speeds)
    scatter = " / ".join(f"{m:.2f} ± {s:.2f}" for m, s in zip(middle, spread, strict=True))
    beyond = ", ".join(f"{v:g} m/s" for v, far in zip(speeds, apart, strict=True) if far)
    return Claim(
        "IV", f"the tyre is off the ground {' / '.join(f'{v:g}' for v in printed)} % of the time at 8 / 12 / 16 m/s",
        f"{words} %; {scatter} % over {DRAWS} terrains",
        "takes no notice of it: the hub's acceleration is measured", _agreement(not apart.any()),
        f"A figure agrees within {TWICE:g} standard deviations of the terrains. "
        + (f"Beyond them: {beyond}. The paper's terrain is not printed: ours has its hub's acceleration, and perhaps not its "
           "rarest bumps." if beyond else ""),
    )  # fmt: skip


def _noise(shown: Shown) -> Claim:
    errors = shown.errors["VII"]
    level = np.array([0.0 if np.isinf(db) else 10 ** (-db / 20) for db in errors])
    together = float(np.corrcoef(level, list(errors.values()))[0, 1])
    words = ", ".join(
        f"{'none' if np.isinf(db) else f'{db:g} dB'}: {error:.1f} %" for db, error in errors.items()
    )
    return Claim(
        "V", "the estimate degrades almost in proportion to the noise", words, shown.companion_noise,
        _agreement(together >= PROPORTION),
        f"In proportion: the error's correlation with the noise's size is {together:.2f} ({PROPORTION:g} at the least).",
    )  # fmt: skip


def _limit(rows: tuple[StudyRow, ...]) -> Claim:
    found = {
        row.method: row for row in rows if row.setup == "two damper slopes" and row.parameter == "sprung mass"
    }
    first, second = found["published"], found["companion"]
    return Claim(
        "VI", "the method may prove viable; total least squares is expected to do better",
        f"RMSE {first.rmse:.1f} kg ({100 * first.rmse / first.truth:.1f} %), {first.ratio or 0:.0f} times the bound",
        f"RMSE {second.rmse:.2f} kg ({100 * second.rmse / second.truth:.2f} %), {second.ratio or 0:.2f} times the bound",
        _agreement(first.rmse < VIABLE * first.truth and second.rmse < first.rmse),
        f"Viable: within {100 * VIABLE:g} % RMS, as in section V; better: a smaller RMSE. Both dampers as parameters and noise in both sensors accounted "
        "for: this is what the data allow.",
    )  # fmt: skip
