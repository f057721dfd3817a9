"""From fitted masses to answers: prior, status, words. Shared by both base-excitation estimators."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from parsers.signals import WHEELS
from pipelines.estimators.base_excitation.data import AXLES, axle_of, unsprung_masses
from pipelines.results import Assumption, ParameterEstimate, Prior
from pipelines.vehicles.kinds import DRIVER, usual_load
from pipelines.vehicles.vehicle import Vehicle

CORNER_MASSES = tuple(f"corner_mass_{w}_kg" for w in WHEELS)
IDENTIFIED_SHARE = 0.1
WEAK_SHARE = 0.3
"""Largest standard deviations, as a share of the value, where there is no prior to compare with."""

SPLIT_SHARE = 0.02
"""What a wheel's static share of its axle may differ by beyond the CG's place: bars and springs seldom sit level."""


@dataclass(frozen=True)
class Figure:
    """A value, its standard deviation and its 95 % interval, which need not be symmetric."""

    value: float
    std: float
    low: float
    high: float


def figure(value: float, std: float, upwards: float = 0.0) -> Figure:
    """A symmetric interval; `upwards` lets the upper end reach that much further (a known direction of error)."""
    reach = 1.96 * std
    spread = math.hypot(std, upwards / math.sqrt(3))
    return Figure(value, spread, value - reach, value + upwards + reach)


def mass_prior(vehicle: Vehicle) -> Prior | None:
    """The loaded vehicle's mass before the log: the empty one's and the stated load, or a usual one."""
    empty = vehicle.get("mass_kg")
    if empty is None:
        return None
    load = vehicle.load.get("mass_kg")
    if load is not None:
        std = math.hypot(empty.std, load.std)
        return Prior(empty.value + load.value, std, f"{empty.source}: empty mass and load")
    further = usual_load(vehicle, empty.value).further
    return Prior(
        empty.value + DRIVER[0] + further, math.hypot(empty.std, further), f"{empty.source}, a usual load"
    )


def answer(
    name: str,
    found: Figure,
    vehicle: Vehicle,
    source: str,
    reason: str,
    prior: Prior | None = None,
    scale: float | None = None,
    witness: bool = False,
) -> ParameterEstimate:
    """An estimate with its status: against the prior's spread where there is one, else against `scale` (default: the
    value itself, so that the relative spread counts). witness: a figure that says less than the prior is shown all the
    same, as weak: it stands beside the verdict and is not taken into it."""
    reference = vehicle.reference.get(name)
    share = found.std / max(abs(scale if scale is not None else found.value), 1e-12)
    vague = prior is not None and found.std > 0.9 * prior.std
    if share > WEAK_SHARE or (vague and not witness):
        said = f"{reason}; {found.value:.4g} ± {found.std:.2g} is no narrower than what was known before"
        return unknown(name, vehicle, said, prior)
    narrowed = prior is None or found.std < 0.6 * prior.std
    status = "identified" if narrowed and share <= IDENTIFIED_SHARE else "weak"
    return ParameterEstimate(
        name, found.value, found.std, found.low, found.high, "identified" if status == "identified" else "weak",
        reason, prior, reference, (source,),
    )  # fmt: skip


def unknown(name: str, vehicle: Vehicle, reason: str, prior: Prior | None = None) -> ParameterEstimate:
    """What the drive cannot tell: the prior's figures, or none."""
    reference = vehicle.reference.get(name)
    if prior is None:
        return ParameterEstimate(
            name, None, None, None, None, "not_identifiable", reason, None, reference, ()
        )
    half = 1.96 * prior.std
    return ParameterEstimate(
        name, prior.value, prior.std, prior.value - half, prior.value + half, "not_identifiable",
        f"{reason}; the figures are the prior's", prior, reference, ("prior",),
    )  # fmt: skip


def nothing(names: tuple[str, ...], vehicle: Vehicle, reason: str) -> dict[str, ParameterEstimate]:
    """All parameters as not identifiable."""
    prior = mass_prior(vehicle)
    return {name: unknown(name, vehicle, reason, prior if name == "mass_kg" else None) for name in names}


@dataclass(frozen=True)
class BodyFigures:
    """Whole-body results: sprung mass by axle in kg with the standard deviation of each and of the sum.

    upwards: how much further up the sum may lie. behind, left: the sprung CG's place as a share of wheelbase and of
    track with standard deviations, None where not known. said: the reason's words.
    """

    front_kg: float
    rear_kg: float
    front_std: float
    rear_std: float
    sum_std: float
    upwards: float
    behind: tuple[float, float] | None
    left: tuple[float, float] | None
    said: str


def body_answers(
    body: BodyFigures, vehicle: Vehicle, source: str, witness: bool = False
) -> tuple[dict[str, ParameterEstimate], Assumption]:
    """Sprung mass, mass, CG place and corner masses of the loaded vehicle, as far as the vehicle file allows."""
    sprung = body.front_kg + body.rear_kg
    (front, rear), hubs_std, assumed = unsprung_masses(vehicle, sprung)
    hubs = front + rear
    mass = sprung + hubs
    prior = mass_prior(vehicle)
    own = (
        None
        if prior is None
        else Prior(prior.value - hubs, math.hypot(prior.std, hubs_std), prior.source + ", less unsprung")
    )
    found: dict[str, ParameterEstimate] = {}

    def put(
        name: str, value: Figure, said: str, known: Prior | None = None, scale: float | None = None
    ) -> None:
        found[name] = answer(name, value, vehicle, source, said, known, scale, witness)

    put("sprung_mass_kg", figure(sprung, body.sum_std, body.upwards), body.said, own)
    whole = math.hypot(body.sum_std, hubs_std)
    put("mass_kg", figure(mass, whole, body.upwards), f"{body.said}; with {hubs:.0f} kg unsprung", prior)
    wheelbase = vehicle.get("wheelbase_m")
    if body.behind is not None and wheelbase is not None:
        length = wheelbase.value
        share = (sprung * body.behind[0] + rear) / mass
        std = math.hypot(
            length * math.hypot(sprung / mass * body.behind[1], 0.5 * hubs_std / mass), share * wheelbase.std
        )
        put("cg_to_front_axle_m", figure(share * length, std), body.said, scale=length / 2)
    tracks = [q.value for key in ("track_front_m", "track_rear_m") if (q := vehicle.get(key)) is not None]
    if body.left is not None and tracks:
        width = sum(tracks) / len(tracks)
        value, std = sprung / mass * width * body.left[0], sprung / mass * width * body.left[1]
        put("cg_lateral_offset_m", figure(value, std), body.said, scale=width / 10)
    found |= _corner_answers(body, vehicle, source, (front, rear), hubs_std)
    return found, assumed


def _corner_answers(
    body: BodyFigures, vehicle: Vehicle, source: str, hubs: tuple[float, float], hubs_std: float
) -> Mapping[str, ParameterEstimate]:
    """Static load over g at each wheel: the axle's share by the CG's place, left and right in the same proportion."""
    found: dict[str, ParameterEstimate] = {}
    lateral, lateral_std = body.left if body.left is not None else (0.0, 0.03)
    parts = zip(
        AXLES.values(), (body.front_kg, body.rear_kg), (body.front_std, body.rear_std), hubs, strict=True
    )
    for wheels, axle, axle_std, hub in parts:
        for side, w in zip((1.0, -1.0), wheels, strict=True):
            value = axle * (0.5 + side * lateral) + hub / 2
            # how a lateral offset divides between the axles hangs on their roll stiffness, which is not seen here
            split = math.hypot(lateral_std, 0.4 * lateral, SPLIT_SHARE) * axle
            std = math.hypot(axle_std / 2, split, hubs_std / 4)
            name = f"corner_mass_{w}_kg"
            said = f"{body.said}; left and right by the CG's place"
            upwards = body.upwards * axle / (2 * (body.front_kg + body.rear_kg))
            found[name] = answer(name, figure(value, std, upwards), vehicle, source, said)
    return found


def corner_answer(
    wheel: str, sprung: Figure, vehicle: Vehicle, source: str, said: str
) -> tuple[ParameterEstimate, Assumption]:
    """A single corner's mass: what it carries of the body, with its share of the unsprung mass."""
    empty = vehicle.get("mass_kg")
    # one wheel of four: the whole is only needed where the file has no unsprung masses
    masses, std, assumed = unsprung_masses(vehicle, 4 * sprung.value if empty is None else empty.value)
    hub = masses[0 if axle_of(wheel) == "front" else 1] / 2
    total = Figure(
        sprung.value + hub, math.hypot(sprung.std, std / 4), sprung.low + hub - std / 2, sprung.high + hub + std / 2
    )  # fmt: skip
    name = f"corner_mass_{wheel}_kg"
    return answer(name, total, vehicle, source, said), assumed
