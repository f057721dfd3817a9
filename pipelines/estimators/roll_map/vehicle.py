"""The second stage put together: what was known before the log, and the answers after it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from pipelines.estimators.roll_map.answers import (
    Coefficients,
    likelihood_of,
    log_answers,
    quick_enough,
    unknown,
    without_inertia,
)
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.height import loaded_priors, surprise, vehicle_answers
from pipelines.estimators.roll_map.posterior import expected_rest, sample_posterior, series_loss
from pipelines.estimators.roll_map.priors import (
    IMU_HEIGHT,
    INERTIA_NAMES,
    TYRE_RATIO,
    VehicleDraws,
    damping_prior,
    draw_vehicle,
    stiffness_prior,
)
from pipelines.estimators.roll_map.tyre_share import RIGID, RIGID_TOO, by_stated_stiffness, drawn_tyres
from pipelines.joint.no_mass import GIVE_MASS
from pipelines.results import Assumption, FloatArray, ParameterEstimate, Prior
from pipelines.vehicles.priors import measured_cg_height
from pipelines.vehicles.usual import usual_roll_axis
from pipelines.vehicles.vehicle import Vehicle

FEWEST_EFFECTIVE = 200.0
SENSOR_DRAWS = 20_000
USUAL_C = (0.9, 0.4)
"""m: c of road vehicles, where no vehicle is known."""

LEAST_C, LEAST_DAMPED = 0.101, 0.06
"""c in m at which the fit is at its bound, and the roll's damping ratio (b / 2 sqrt(a c)) below which no vehicle's dampers leave it: worn
ones 0.1, a car's 0.2 to 0.4."""


@dataclass(frozen=True)
class VehiclePart:
    """What was known. draws: None without a mass. priors: of the loaded vehicle. rates: priors of K and D."""

    draws: VehicleDraws | None
    priors: Mapping[str, Prior]
    rates: tuple[Prior | None, Prior | None]
    assumptions: tuple[Assumption, ...]
    roll_axis_known: bool
    tyres_known: bool
    imu_known: bool

    def fewer(self, count: int) -> VehicleDraws:
        """The first `count` draws."""
        assert self.draws is not None
        cut = {
            f.name: value[:count]
            for f in fields(self.draws)
            if isinstance(value := getattr(self.draws, f.name), np.ndarray)
        }
        return replace(self.draws, **cut)

    def unknown(
        self, names: Iterable[str], reason: str, reference: Mapping[str, float]
    ) -> dict[str, ParameterEstimate]:
        """All parameters as the prior leaves them."""
        return {name: unknown(name, reason, self.priors.get(name), reference.get(name)) for name in names}


def before_the_log(vehicle: Vehicle, rng: np.random.Generator, count: int) -> VehiclePart:
    """What the vehicle file and the measured vehicles say."""
    rates = (stiffness_prior(vehicle), damping_prior(vehicle))
    roll_axis = all(vehicle.get(f"roll_center_height_{axle}_m") is not None for axle in ("front", "rear"))
    tyres = vehicle.get("tire_vertical_rate_npm") is not None
    imu = "imu_above_ground_m" in vehicle.sensors
    priors: dict[str, Prior] = {}
    draws: VehicleDraws | None = None
    assumptions: tuple[Assumption, ...] = ()
    if vehicle.get("mass_kg") is not None:
        draws, assumptions, height_source = draw_vehicle(vehicle, rng, count)
        inertia_source = next(a.source for a in assumptions if a.name.startswith(INERTIA_NAMES))
        priors |= loaded_priors(draws, height_source, inertia_source, vehicle.load_stated)
    else:
        stated = vehicle.get("cg_height_m")
        height = (
            measured_cg_height(vehicle.body, None, vehicle.powertrain)
            if stated is None
            else Prior(stated.value, stated.std, stated.source)
        )
        if height is not None:
            priors["cg_height_m"] = height
    for name, prior in zip(("roll_stiffness_nmprad", "roll_damping_nmsprad"), rates, strict=True):
        if prior is not None:
            priors[name] = prior
    return VehiclePart(draws, priors, rates, assumptions, roll_axis, tyres, imu)


def _sensor_draws(
    before: VehiclePart,
    vehicle: Vehicle,
    coefficients: Coefficients,
    data: RollData,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Draws (n,) of the accelerometer's height above the roll axis, of the factor and of the summand that turn the
    apparent c into the body's own. The factor is also the suspension's share of the roll."""
    against_axles = data.against_axles
    a, b = float(coefficients.mean[0]), float(coefficients.mean[1])
    if before.draws is not None:
        few = before.fewer(SENSOR_DRAWS)
        _, gain, loss = expected_rest(few, a, b, against_axles=against_axles)
        if not against_axles:
            return few.imu, np.ones_like(gain), loss
        told = before.rates[0] if before.tyres_known else None
        likely = None if told is None else by_stated_stiffness(a * few.sprung * few.arm, told)
        gain, loss = drawn_tyres(
            gain, loss, coefficients, data.banked_share, rigid=0.0 if vehicle.real else RIGID_TOO[before.tyres_known],
            rng=rng, likely=likely,
        )  # fmt: skip
        return few.imu, 1 / gain, loss
    stated = vehicle.sensors.get("imu_above_ground_m")
    mean, std = IMU_HEIGHT if stated is None else (stated.value, stated.std)
    axis, unsure = usual_roll_axis(vehicle)
    height = mean - axis + np.hypot(std, unsure) * rng.standard_normal(SENSOR_DRAWS)
    ratio = np.clip(TYRE_RATIO[0] + TYRE_RATIO[1] * rng.standard_normal(SENSOR_DRAWS), 0.6, 0.99)
    if against_axles:
        gain, loss = drawn_tyres(
            1 / ratio,
            np.zeros(SENSOR_DRAWS),
            coefficients,
            data.banked_share,
            rigid=0.0 if vehicle.real else RIGID,
            rng=rng,
        )
        return height, 1 / gain, loss
    return height, np.ones(SENSOR_DRAWS), series_loss((1 - ratio) / (1 + 0.2 * ratio), a, b)


def _told(coefficients: Coefficients) -> bool:
    """Whether the fit ended where vehicles are, and not at a motion without inertia or dampers.

    On rough roads the road's own roll came out as a delay of 70 ms and no damping, or as inertia half as large again.
    """
    a, b, c = coefficients.mean[:3]
    return bool(c > LEAST_C and b > 2 * LEAST_DAMPED * np.sqrt(a * c))


def _possible_inertia(before: VehiclePart, coefficients: Coefficients, against_axles: bool) -> bool:
    """Whether the measured c lies within three standard deviations of what the vehicle's draws can give."""
    mean, std = USUAL_C
    if before.draws is not None:
        few = before.fewer(SENSOR_DRAWS)
        c = expected_rest(few, *(float(x) for x in coefficients.mean[:2]), against_axles=against_axles)[0][
            few.possible
        ]
        mean, std = float(c.mean()), float(c.std())
    if not _told(coefficients):
        return False
    away = abs(coefficients.mean[2] - mean)
    return bool(away < 3 * (std**2 + coefficients.covariance[2, 2]) ** 0.5)


def usable(
    before: VehiclePart, coefficients: Coefficients, against_axles: bool
) -> tuple[Coefficients, list[str]]:
    """The coefficients, without b and c where they cannot be this vehicle's, and a sentence on that."""
    if _possible_inertia(before, coefficients, against_axles):
        return coefficients, []
    c, std = coefficients.mean[2], coefficients.covariance[2, 2] ** 0.5
    sentence = (
        "The roll motion shows inertia and damping too little: only its steady part is used."
        if std > 0.3 or not _told(coefficients)
        else f"The inertia term of the roll motion (c = {c:.2f} ± {std:.2f} m) is not one that this vehicle can have "
        f"(a filter in the sensors, or lateral acceleration that is not that of the roll axis): only the steady part of "
        f"the motion is used."
    )
    return without_inertia(coefficients), [sentence]


def explain_vehicle(
    before: VehiclePart,
    coefficients: Coefficients,
    data: RollData,
    vehicle: Vehicle,
    rng: np.random.Generator,
) -> tuple[dict[str, ParameterEstimate], dict[str, float], tuple[str, ...]]:
    """Parameters, figures and sentences of the second stage."""
    what = (
        "of the body against its axles, the tyres' part added,"
        if data.against_axles
        else "of the body against the horizon (tyres included)"
    )
    coefficients, sentences = usable(before, coefficients, data.against_axles)
    sensor = _sensor_draws(before, vehicle, coefficients, data, rng)
    found = log_answers(
        coefficients, sensor, before.imu_known, what, vehicle.reference, rng,
        tyres_stated=vehicle.get("tire_vertical_rate_npm") is not None,
    )  # fmt: skip
    if before.draws is None:
        names = ("cg_height_m", "sprung_cg_height_m", "roll_arm_m", "roll_stiffness_nmprad", "roll_damping_nmsprad",
                 "roll_inertia_kgm2", "mass_kg", "sprung_mass_kg")  # fmt: skip
        return found | before.unknown(names, GIVE_MASS, vehicle.reference), {}, tuple(sentences)
    likelihood = likelihood_of(coefficients, against_axles=data.against_axles)
    quick = quick_enough(coefficients)
    posterior = sample_posterior(before.draws, likelihood, *before.rates, rng)
    if posterior.effective < FEWEST_EFFECTIVE:
        # inertia, damping and statics do not go together with what is known: the statics are surer
        likelihood = likelihood_of(without_inertia(coefficients), against_axles=data.against_axles)
        again = sample_posterior(before.draws, likelihood, before.rates[0], None, rng)
        if again.effective > posterior.effective:
            posterior, quick = again, quick_enough(without_inertia(coefficients))
            sentences.append(
                "Inertia and damping of the motion were left out: they fit badly with what is known."
            )
    figures = {"effective_draws": posterior.effective}
    if posterior.effective < 5:
        sentence = "What is known of the vehicle and the measured roll motion exclude each other: check the vehicle file's masses, heights and stiffness, and the roll signal's unit."
        contradicted = (*before.priors, "cg_height_m", "roll_stiffness_nmprad")
        return (
            found | before.unknown(contradicted, "the log contradicts the vehicle file", vehicle.reference),
            figures,
            (*sentences, sentence),
        )
    found |= vehicle_answers(
        posterior,
        before.priors,
        before.roll_axis_known,
        before.tyres_known,
        quick,
        vehicle.reference,
    )
    if posterior.effective < FEWEST_EFFECTIVE:
        sentences.append(
            f"Only {posterior.effective:.0f} of the draws carry weight: the intervals are coarse."
        )
    disagreement = surprise(posterior, before.priors)
    if disagreement is not None:
        sentences.append(f"{disagreement[0].upper()}{disagreement[1:]}.")
    return found, figures, tuple(sentences)
