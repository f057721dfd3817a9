"""The claims of Chapter 5's text, each beside what ours gives."""

from __future__ import annotations

import numpy as np

from pipelines.models.base_excitation_3dof import corner_response
from pipelines.reproduce.base import Agreement, Claim, StudyRow
from pipelines.reproduce.gpc_map.methods import Measured, Method, bound, measured
from pipelines.reproduce.gpc_map.setup import RATE_HZ, SETTINGS, Bench, table_of
from pipelines.reproduce.gpc_map.tables import Row

SPRING_ERROR = 1.05
STEP_MPS2 = 4.0
CG_HEIGHT_M = 0.6


def _agreement(holds: bool) -> Agreement:
    return "agrees" if holds else "differs"


def claims(
    place: Bench, found: list[Row], rows: list[StudyRow], rng: np.random.Generator
) -> tuple[Claim, ...]:
    """All of them."""
    return (
        _order(found), _length(place, found), _bound(rows), _intervals(found), _springs(place, rng), _corner(place, rng),
    )  # fmt: skip


def _order(found: list[Row]) -> Claim:
    by_order = {4: found[2], 6: found[0], 10: found[7]}
    words = ", ".join(f"order {k}: {np.max(np.abs(r.quiet)):.2g} %" for k, r in by_order.items())
    apart = ", ".join(f"order {k}: {np.max(np.abs(r.fixed - r.error)):.2g} %" for k, r in by_order.items())
    return Claim(
        "5.1.1", "the higher the order, the more accurate are the estimates", f"largest error without noise: {words}",
        f"over the fixed support instead: {apart}", "differs",
        "Over the fixed support a higher order moves the MAP by less than the noise does; where the domain follows the posterior "
        "it makes no difference. The printed errors are many times what the orders cost.",
    )  # fmt: skip


def _length(place: Bench, found: list[Row]) -> Claim:
    short, long = (100 * bound(place, s) / place.car.truth for s in (24.0, 60.0))
    holds = bool(np.all(long < short))
    std = [100 * r.found.posterior.std / place.car.truth for r in (found[2], found[6])]
    return Claim(
        "5.1.1", "the longer the sequence, the better the estimate",
        f"standard deviation of the mass {std[0][0]:.2f} % with 24 s, {std[1][0]:.2f} % with 60 s",
        f"bound {short[0]:.2f} % and {long[0]:.2f} %", _agreement(holds),
    )  # fmt: skip


def _bound(rows: list[StudyRow]) -> Claim:
    ratios = [row.ratio for row in rows if row.target is not None and row.ratio is not None]
    printed = np.sqrt(np.mean(np.square([s.error for s in SETTINGS]), axis=0))
    return Claim(
        "Table 5.2", f"errors of {printed[0]:.1f} / {printed[1]:.1f} / {printed[2]:.1f} % (RMS over the eight runs)",
        f"{min(ratios):.2f} to {max(ratios):.2f} times the bound in all settings", "", "differs",
        "The noise is not printed; with ours all settings are as good as any method can be. Errors of the printed size with "
        "noise-free surrogates point at the published implementation, not at the method.",
    )  # fmt: skip


def _intervals(found: list[Row]) -> Claim:
    one, many = found[0].found.posterior.std, found[1].found.posterior.std
    apart = float(np.max(np.abs(many / one - 1)))
    return Claim(
        "3.3", "the posterior of one interval is the prior of the next",
        f"24 intervals of 1 s give the spread of 24 s at once within {100 * apart:.1f} %; {found[1].found.refits} domains laid on the way",
        "", _agreement(apart < 0.1), "Where the domain follows. Over a fixed support nothing is lost either, but a posterior a hundredth of "
        "it wide has no surrogate left to be drawn from at a low order.",
    )  # fmt: skip


def _springs(place: Bench, rng: np.random.Generator) -> Claim:
    data = measured(place, rng, noise=0.0)
    found = Method(place, SETTINGS[2], springs=SPRING_ERROR).fit(data, rng)
    off = 100 * (found.posterior.map_value / place.car.truth - 1)
    holds = bool(np.all(np.abs(off - 100 * (SPRING_ERROR - 1)) < 0.2))
    return Claim(
        "5.1.2", "the model requires known suspension characteristics",
        f"springs and dampers taken 5 % too stiff: {off[0]:+.2f} / {off[1]:+.2f} / {off[2]:+.2f} %", "", _agreement(holds),
        "From accelerations alone only mass over stiffness can be seen: the error goes through in full, and the fit is perfect.",
    )  # fmt: skip


def _corner(place: Bench, rng: np.random.Generator) -> Claim:
    """A step of lateral acceleration rolls the body, and no hub accelerates: the model has no input for it."""
    setting = SETTINGS[2]
    rows = round(setting.seconds * RATE_HZ)
    data = measured(place, rng)
    # half way through a steady corner is entered: the body takes a roll angle, shown by its transient only
    car = place.car
    moment = np.zeros(rows)
    moment[rows // 2 :] = car.mass_kg * STEP_MPS2 * CG_HEIGHT_M
    stiffness = (car.spring_front_npm + car.spring_rear_npm) * car.track_m**2 / 2
    damping = (car.damper_front_nspm + car.damper_rear_nspm) * car.track_m**2 / 2
    angle, rate, extra = 0.0, 0.0, np.zeros(rows)
    for k in range(rows):
        extra[k] = (moment[k] - stiffness * angle - damping * rate) / car.roll_kgm2
        rate += extra[k] / RATE_HZ
        angle += rate / RATE_HZ
    half = car.track_m / 2 * np.array([1.0, -1.0, 1.0, -1.0])
    body = data.body.copy()
    body[:rows] += extra[:, None] * half
    method = Method(place, setting)
    before = method.fit(data, rng).posterior.map_value
    after = method.fit(Measured(body), rng).posterior.map_value
    moved = 100 * np.abs(after / before - 1)
    residual = (
        body[:rows]
        - corner_response(
            table_of(car, after[None]), place.hubs[:rows], place.geometry, 1 / RATE_HZ, warp=False
        )[0]
    )
    loud = float(np.std(residual[rows // 2 : rows // 2 + 200]) / np.std(residual[: rows // 2]))
    return Claim(
        "5.1.2", "the model cannot hold a steady corner: it drifts and the parameters diverge",
        f"one corner of {STEP_MPS2:g} m/s² moves the roll inertia by {moved[2]:.2f} %, mass by {moved[0]:.2f} %; its residual is {loud:.1f} times "
        "the noise while the body rolls over", "", "differs",
        "With accelerations as outputs the steady state is zero on both sides, so that only the transient is wrong and nothing drifts; "
        "the CG height indeed does not appear. On logs, blocks that the model does not explain have to be told apart from noise.",
    )  # fmt: skip
