"""Park & Choi's integrated observer of the CG height, as published: a witness beside the verdict."""

from __future__ import annotations

import math

import numpy as np

from parsers.channels import IntArray
from parsers.drive import Drive
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.brake_roll.data import (
    BrakeRollData,
    WheelScale,
    collect_data,
    prepare_drive,
    wheel_scales,
)
from pipelines.estimators.brake_roll.vehicle import BrakeRollVehicle, known_of
from pipelines.estimators.integrated_observer.core import Gates, Observed, ObserverInput, robustness_bound
from pipelines.estimators.integrated_observer.figures import height_track, observer_traces
from pipelines.estimators.integrated_observer.spread import Setup, Spread, spread_of
from pipelines.estimators.roll_map.answers import status_against, unknown
from pipelines.estimators.roll_map.vehicle import before_the_log
from pipelines.filters.roll_adaptation import AdaptationGains, gamma_of
from pipelines.models.braking import LongitudinalCar
from pipelines.prepare.prepared import Prepared
from pipelines.results import Estimate, Identification, ParameterEstimate, Prior
from pipelines.vehicles.vehicle import Vehicle

RATE_HZ = 100.0
PRIOR_DRAWS = 4000
ANY_HEIGHT = Prior(0.65, 0.15, "no measured vehicle is like it: usual for road vehicles")
KEPT = 0.5
"""Share of the start that may be left in the final height: beyond it the drive has told less than was assumed."""

LOWEST, HIGHEST = 0.05, 4.0
"""m, beyond which no road vehicle's CG lies."""

NAMES = ("cg_height_m", "mass_kg")

SETTINGS: tuple[Setting, ...] = (
    Setting("cutoff_hz", 5.0, "Hz", "zero-phase low-pass of all signals; L_int of (40) is 2π times as much", 1.0, 20.0),
    Setting("observer_gain", 12000.0, "N·m·s/rad", "L_a of (22)", 1000.0, 1e6),
    Setting("adaptation_gain", 0.015, "-", "k_a of (31)", 1e-5, 1.0),
    Setting("steady_radps", 0.01, "rad/s", "roll rate below which (38) sees a steady state", 1e-4, 0.2),
    Setting("braking_mps2", 1.5, "m/s²", "deceleration by the brakes from which K of (39) is 1", 0.1, 5.0),
    Setting("slip_limit", 0.1, "-", "slip from which braking is left out", 0.02, 0.5),
    Setting("steering_rad", 0.17, "rad", "steering-wheel angle up to which (39) sees straight driving", 0.01, 2.0),
    Setting("split_mps", 0.4, "m/s", "left-right difference of wheel speeds from which braking is left out", 0.05, 5.0),
    Setting("converged_m", 0.01, "m", "standard deviation over the window below which the height has converged", 1e-3, 0.2),
    Setting("window_s", 20.0, "s", "the moving window of that", 1.0, 300.0),
)  # fmt: skip


def _value(settings: Settings, name: str) -> float:
    default = next(s.default for s in SETTINGS if s.name == name)
    return float(settings.get(name, default))


class IntegratedObserver:
    """The estimator "integrated_observer"."""

    name = "integrated_observer"
    title = "Integrated observer: braking (LRLS) and roll (adaptation law), as published"
    source = "Park, Choi: An Integrated Observer for Real-Time Estimation of Vehicle Center of Gravity Height, eqs. (1)-(40)"
    signal_needs = (
        Need(
            ("accel_y", "accel_x"), "lateral acceleration for roll, or longitudinal acceleration for braking"
        ),
        Need(
            ("roll_rate", "brake_pressure", "brake_torque", "brake_torque_fl"),
            "the roll motion, or the brakes",
        ),
        Need(
            ("speed", "gps_speed_2d", "gps_speed_3d"),
            "slip and turning are measured against the vehicle's speed",
        ),
    )
    vehicle_needs = (
        Need(("mass_kg",), "the mass that rolls and brakes"),
        Need(("roll_stiffness_nmprad", "spring_rate_front_npm", "brake_gain_nmppa", "wheelbase_m"),
             "roll stiffness for the lateral part; wheelbase and brake gain for the braking part"),
    )  # fmt: skip
    parameters = NAMES
    settings = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Motion, wheel speeds, brakes and speed at 100 Hz."""
        return prepare_drive(drive, RATE_HZ, _value(settings, "cutoff_hz"))

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Run it over the drive. What it cannot tell ends "not_identifiable" with the reason."""
        before = before_the_log(vehicle, rng, PRIOR_DRAWS)
        known = known_of(vehicle)

        def nothing(reason: str, assumptions: BrakeRollVehicle | None = known) -> Estimate:
            answers = {n: unknown(n, reason, before.priors.get(n), vehicle.reference.get(n)) for n in NAMES}
            given = () if assumptions is None else assumptions.assumptions
            return Estimate(self.name, "ran", reason, answers, assumptions=given, witness=True)

        if known is None:
            return nothing("the vehicle's mass is not known: give mass_kg in a vehicle file")
        if not prepared.segments:
            return nothing("; ".join(prepared.notes) or "no stretch holds the signals without a gap")
        data = collect_data(prepared, known)
        scale = wheel_scales(data, known)
        start = before.priors.get("cg_height_m", ANY_HEIGHT)
        setup, missing = build_setup(prepared, data, scale, known, settings, start.value)
        if setup is None:
            return nothing("; ".join(missing))
        observed = setup.run()
        if not _lively(observed, setup):
            words = "hardly any cornering (1 m/s²) and no stop that the gates let through"
            return nothing("; ".join((words, *missing)))
        last = observed.height[np.isfinite(observed.height)]
        if not len(last) or not LOWEST < last[-1] < HIGHEST:
            ended = f"{last[-1]:.3g} m" if len(last) else "nothing"
            return nothing(
                f"the observer ran off (it ended at {ended}): its signals do not go together; check their units"
            )
        spread = spread_of(setup, known, data, scale, start.std)
        return self._answer(prepared, vehicle, known, data, setup, observed, spread, start, missing, settings)

    def _answer(
        self,
        prepared: Prepared,
        vehicle: Vehicle,
        known: BrakeRollVehicle,
        data: BrakeRollData,
        setup: Setup,
        observed: Observed,
        spread: Spread,
        start: Prior,
        missing: tuple[str, ...],
        settings: Settings,
    ) -> Estimate:
        """Parameters, figures and words."""
        good = np.isfinite(observed.height)
        value = float(observed.height[good][-1])
        window = round(_value(settings, "window_s") * prepared.rate_hz)
        moving = float(np.std(observed.height[good][-window:]))
        settled = moving < _value(settings, "converged_m")
        status: Identification = status_against(spread.std, value, start)
        if spread.memory > KEPT:
            status = "not_identifiable"
        elif not settled and status == "identified":
            status = "weak"
        sentences = _sentences(observed, spread, settled, missing, value)
        height = ParameterEstimate(
            "cg_height_m", value, spread.std, max(value - 1.96 * spread.std, 0.0), value + 1.96 * spread.std, status,
            sentences, start, vehicle.reference.get("cg_height_m"), (self.name,),
        )  # fmt: skip
        if spread.memory > KEPT:
            height = unknown("cg_height_m", sentences, start, vehicle.reference.get("cg_height_m"))
        words = (
            "the published braking part cannot tell the mass: divided by it, (10)-(20) hold it in the drag term alone; "
            "the longitudinal balance with known brake gains can (see brake_roll_batch)"
        )
        mass_prior = Prior(known.mass.value, known.mass.std, known.mass.source)
        mass = unknown("mass_kg", words, mass_prior, vehicle.reference.get("mass_kg"))
        figures = _figures(observed, setup, spread, moving, known)
        active = np.zeros(len(good), dtype=bool) if observed.brake is None else observed.brake.active
        lively = good & (np.abs(setup.data.f_y) > 1.0) & (observed.roll is not None)
        return Estimate(
            self.name, "ran", sentences, {"cg_height_m": height, "mass_kg": mass},
            tracks=(height_track(prepared.time_s, observed.height, spread.std),),
            traces=observer_traces(prepared.time_s, setup, observed, value),
            assumptions=known.assumptions,
            diagnostics=figures | _speed_figures(data),
            used_fraction=float(np.mean(active | lively)),
            witness=True,
        )  # fmt: skip


def _lively(observed: Observed, setup: Setup) -> bool:
    """Whether there is anything to estimate from: a second of braking, or ten of cornering."""
    rate = setup.data.rate_hz
    braked = observed.brake is not None and int(observed.brake.active.sum()) > rate
    cornered = observed.roll is not None and int((np.abs(setup.data.f_y) > 1.0).sum()) > 10 * rate
    return braked or cornered


def _sentences(
    observed: Observed, spread: Spread, settled: bool, missing: tuple[str, ...], value: float
) -> str:
    """Which parts ran, what limits the answer, and what was missing."""
    parts = [
        *(["braking"] if observed.brake is not None and observed.brake.active.any() else []),
        *(["roll"] if observed.roll is not None else []),
    ]
    largest = max(spread.parts, key=lambda name: spread.parts[name])
    text = [f"from {' and '.join(parts)}" if parts else "from nothing"]
    if spread.memory > KEPT:
        text.append(
            f"{100 * spread.memory:.0f} % of the start value is still in the result: too little cornering or braking"
        )
    elif not settled:
        text.append("the estimate is still moving at the end of the drive")
    text.append(
        f"the interval is from running it again with each quantity moved by its spread (largest: {largest}, "
        f"{100 * spread.parts[largest] / max(value, 0.1):.0f} %), not from the filter's own covariance"
    )
    return "; ".join((*text, *missing))


def _figures(
    observed: Observed, setup: Setup, spread: Spread, moving: float, known: BrakeRollVehicle
) -> dict[str, float]:
    """Diagnostics: shares of time, the stability bound (33), what each cause adds to the spread."""
    found = {
        "start_left_share": spread.memory,
        "moving_std_m": moving,
        **{
            f"spread_{name.replace(' ', '_').replace(',', '')}_m": part for name, part in spread.parts.items()
        },
    }
    if observed.brake is not None:
        stiffness = observed.brake.stiffness
        found["braking_rows"] = float(observed.brake.active.sum())
        if observed.brake.active.any():
            found["slip_stiffness_front"] = float(np.nanmedian(stiffness[:, 0]))
            found["slip_stiffness_rear"] = float(np.nanmedian(stiffness[:, 1]))
            found["height_braking_m"] = float(observed.brake.height[-1])
            found["added_mass_lrls_kg"] = float(observed.brake.added[-1])
    if observed.roll is not None and setup.gains is not None:
        bound = robustness_bound(observed.roll, setup.data.f_y, setup.gains)
        told = np.isfinite(bound)
        if told.any():
            found["stability_bound_met_share"] = float(np.mean(bound[told] >= known.mass.std))
    return found


def _speed_figures(data: BrakeRollData) -> dict[str, float]:
    true = data.true
    if true is None:
        return {}
    return {"speed_delay_s": true.delay_s, "accel_x_gain": true.gain}


def _segments(prepared: Prepared) -> tuple[IntArray, IntArray]:
    return (
        np.array([s.start for s in prepared.segments], dtype=np.int64),
        np.array([s.stop for s in prepared.segments], dtype=np.int64),
    )


def build_setup(
    prepared: Prepared,
    data: BrakeRollData,
    scale: WheelScale,
    known: BrakeRollVehicle,
    settings: Settings,
    start_m: float,
) -> tuple[Setup | None, tuple[str, ...]]:
    """The observer's run on a log, with the parts that are there; None with the reasons where neither is."""
    missing = list(data.missing)
    true = data.true
    if true is None:
        return None, tuple(missing)
    braking = (
        not data.missing and data.f_x is not None and known.front is not None and known.wheelbase is not None
    )
    if not data.missing and not braking:
        missing.append("the braking part needs accel_x, cg_to_front_axle_m and wheelbase_m")
    gains = None
    if data.f_y is None or data.roll_rate is None or data.yaw_rate is None:
        missing.append("the lateral part needs accel_y, roll_rate and yaw_rate")
    elif known.stiffness is None or known.damping is None or known.inertia is None:
        missing.append("the lateral part needs the roll stiffness (or spring rates and tracks)")
    else:
        gains = _gains(known, settings)
    if gains is None and not braking:
        return None, tuple(missing)
    rows = len(prepared.time_s)
    nothing = np.zeros(rows)
    f_x = nothing if data.f_x is None else data.f_x / true.gain
    wheelbase = known.wheelbase.value if known.wheelbase is not None else 2.7
    ahead = known.front.value if known.front is not None else 0.45 * wheelbase
    car = LongitudinalCar(
        known.nominal.value, ahead, wheelbase - ahead, known.radius.value, known.wheel_inertia.value,
        known.drag_area.value,
    )  # fmt: skip
    front = data.front if data.front is not None else true.speed
    rear = data.rear if data.rear is not None else true.speed
    columns = ObserverInput(
        prepared.rate_hz, true.speed, f_x, nothing if data.f_y is None else data.f_y, data.roll_rate if gains else None,
        nothing if data.yaw_rate is None else data.yaw_rate, front / scale.front, rear / scale.rear, data.apart,
        data.front_torque if braking else None, data.rear_torque if braking else None, data.steering,
        data.allowed & data.rows, _segments(prepared),
    )  # fmt: skip
    gates = Gates(
        braking_mps2=_value(settings, "braking_mps2"),
        slip=_value(settings, "slip_limit"),
        steering_rad=_value(settings, "steering_rad"),
        apart_mps=_value(settings, "split_mps"),
    )
    return Setup(columns, car, gains, gates, start_m), tuple(missing)


def _gains(known: BrakeRollVehicle, settings: Settings) -> AdaptationGains:
    """The vehicle's rates with the published gains; γ by (29), the observer's gain raised where (29) asks for it."""
    assert known.stiffness is not None
    assert known.damping is not None
    assert known.inertia is not None
    inertia, stiffness, damping = known.inertia.value, known.stiffness.value, known.damping.value
    least = 2.05 * math.sqrt(inertia * stiffness) - damping
    observer = max(_value(settings, "observer_gain"), least)
    return AdaptationGains(
        inertia_kgm2=inertia,
        stiffness_nmprad=stiffness,
        damping_nmsprad=damping,
        centre_m=known.centre.value,
        observer=observer,
        adaptation=_value(settings, "adaptation_gain"),
        gamma=gamma_of(inertia, stiffness, damping, observer),
        steady_radps=_value(settings, "steady_radps"),
        synthesis_radps=2 * math.pi * _value(settings, "cutoff_hz"),
    )
