"""What the HEKF-EKF's run says, with intervals that its own covariance is too sure of to give."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.axle_load_gls.answers import IDENTIFIED, WEAK, against_stated, unknown
from pipelines.estimators.axle_load_gls.data import AxleData
from pipelines.estimators.axle_load_gls.known import (
    ROLLING,
    WHEEL_SPIN_SHARE,
    MassKnowledge,
    pitch_axis,
    usual_pitch,
)
from pipelines.filters.hekf import HekfSettings, HekfTrack
from pipelines.prepare.lowpass import lowpass
from pipelines.results import Assumption, FloatArray, Identification, ParameterEstimate, Trace, Track
from pipelines.vehicles.axle_loads import by_springs
from pipelines.vehicles.vehicle import Vehicle

LAGS_S = 2.0
TRACK_POINTS = 120
OTHER_MODEL = 0.01
SLOW_HZ = 0.5
USUAL_RADIUS_SHARE = 0.118


@dataclass(frozen=True)
class Filtered:
    """One run: the weighted estimate, the plain EKF's, what the filter was given. speed_std m/s, load_std N."""

    track: HekfTrack
    ekf: HekfTrack
    settings: HekfSettings
    rolling: float
    speed_std: float
    load_std: float
    rolling_unknown: bool


def correlation_time(innovation: FloatArray, rate_hz: float) -> float:
    """Sum of the innovations' autocorrelation over both sides up to 2 s, at least 1: how many rows count as one."""
    e = innovation[np.isfinite(innovation)]
    power = float(e @ e)
    lags = min(round(LAGS_S * rate_hz), len(e) // 4)
    if power <= 0 or lags < 1:
        return 1.0
    weights = 1 - np.arange(1, lags + 1) / (lags + 1)
    shares = np.array([float(e[k:] @ e[:-k]) / power for k in range(1, lags + 1)])
    return max(1.0, 1 + 2 * float(weights @ shares))


def _wander(values: FloatArray) -> float:
    """Half of how far the estimate still moved over the drive's last third."""
    last = values[2 * len(values) // 3 :]
    return 0.5 * float(np.ptp(last)) if len(last) else math.inf


def slow_line(data: AxleData) -> tuple[float, float]:
    """Load over force as a straight line, below 0.5 Hz: slope in kg, and 1 - r², what does not go along.

    The filter takes the load as the input: what the load holds beside the load transfer (crests, pitch, bends) makes its
    height too large by about that share, and the line's too small by what is wrong with the force.
    """
    cutoff = min(SLOW_HZ, 0.4 * data.rate_hz)
    force, cross, loads, forces = data.force(), 0.0, 0.0, 0.0
    for first, past in data.runs():
        a, b = (lowpass(v[first:past], data.rate_hz, cutoff) for v in (data.load, force))
        a, b = a - np.mean(a), b - np.mean(b)
        cross, loads, forces = cross + float(a @ b), loads + float(a @ a), forces + float(b @ b)
    both = loads * forces
    if both <= 0 or cross <= 0:
        return 0.0, 1.0
    return cross / forces, 1.0 - cross * cross / both


def widened(filtered: Filtered, data: AxleData) -> tuple[float, float]:
    """Standard deviations of height and position from the run alone: covariance, autocorrelation, wandering."""
    track = filtered.track
    misfit = track.innovation[np.isfinite(track.innovation)]
    white = max(1.0, float(np.std(misfit)) / filtered.speed_std) if len(misfit) else 1.0
    grow = white * math.sqrt(correlation_time(track.innovation, data.rate_hz))
    height = math.hypot(grow * float(track.height_std[-1]), _wander(track.height))
    axle = math.hypot(grow * float(track.axle_std[-1]), _wander(track.axle))
    apart = 0.5 * abs(float(track.height_first[-1] - track.height_second[-1]))
    return math.hypot(height, apart), axle


def _answer(
    name: str,
    value: float,
    std: float,
    mass: MassKnowledge,
    status: Identification,
    reason: str,
    vehicle: Vehicle,
) -> ParameterEstimate:
    """The filter's figure; the interval holds std (all but the mass) and the mass's draws, which may be lopsided."""
    if status == "not_identifiable" or not math.isfinite(value):
        return unknown(name, reason, vehicle)
    mean = float(np.mean(mass.draws))
    low, high = (value * mean / float(np.quantile(mass.draws, q)) for q in (0.975, 0.025))
    both = math.hypot(std, value * float(np.std(mass.draws)) / mean)
    return ParameterEstimate(
        name, value, both, value - math.hypot(1.96 * std, value - low), value + math.hypot(1.96 * std, high - value),
        status, reason, None, vehicle.reference.get(name), ("hekf_ekf",),
    )  # fmt: skip


def _word(std: float, identified: float, weak: float) -> Identification:
    return "identified" if std <= identified else ("weak" if std <= weak else "not_identifiable")


@dataclass(frozen=True)
class Doubts:
    """Standard deviations in m of height and position, without the mass's and with it, and what they are made of."""

    height: float
    axle: float
    height_all: float
    axle_all: float
    own: float
    common: float
    model: float
    apart: float
    line: float
    linked: float


def _links(linked: float) -> str:
    """What springs' loads make of it, in words; nothing of tyres' loads."""
    return (
        f" and by {linked:.2f} m (loads that may be the springs', to which the links' part never comes)"
        if linked > 0.005
        else ""
    )


def doubts_of(
    filtered: Filtered, data: AxleData, vehicle: Vehicle, mass: MassKnowledge, load_scale: float
) -> Doubts:
    """The run's own, the sensors', the mass's, and what the method leaves out."""
    wheelbase = vehicle.quantities["wheelbase_m"].value
    height, axle = float(filtered.track.height[-1]), float(filtered.track.axle[-1])
    own = widened(filtered, data)
    kilograms = float(np.mean(mass.draws))
    heavy = float(np.std(mass.draws)) / kilograms
    inside = min(max(axle, 0.1 * wheelbase), 0.9 * wheelbase)
    pitch = usual_pitch(vehicle, wheelbase, inside, max(height, 0.1))
    # all of these read as height, so that they add up
    model = pitch.gain + WHEEL_SPIN_SHARE[0] + OTHER_MODEL
    rolling = ROLLING[0] * USUAL_RADIUS_SHARE * wheelbase if filtered.rolling_unknown else filtered.rolling
    slope, apart = slow_line(data)
    line = slope * wheelbase / kilograms
    # loads that the springs carry lack the links' part of the transfer
    axis, axis_std, _ = pitch_axis(vehicle, wheelbase)
    links = data.share_of("suspension") + data.share_of("axle") * math.sqrt(by_springs(vehicle))
    linked = links * math.hypot(axis, axis_std)
    tall = math.hypot(own[0], height * load_scale, height * model, height * apart, height - line, linked)
    slanted = height * data.grade_source.std
    rest = (axle * load_scale, slanted, rolling, 0.005 * wheelbase, 0.1 * apart * wheelbase)
    place = math.hypot(own[1], *rest)
    return Doubts(
        tall, place, math.hypot(tall, height * heavy), math.hypot(place, axle * heavy), own[0],
        math.hypot(heavy, load_scale), model, apart, line, linked,
    )  # fmt: skip


def published_answers(
    filtered: Filtered, data: AxleData, vehicle: Vehicle, mass: MassKnowledge, load_scale: float, told: str | None
) -> tuple[dict[str, ParameterEstimate], tuple[Track, ...], tuple[Trace, ...]]:  # fmt: skip
    """Parameters, tracks and traces. told: why the height is not to be had, None where it is."""
    wheelbase = vehicle.quantities["wheelbase_m"].value
    track = filtered.track
    height, axle = float(track.height[-1]), float(track.axle[-1])
    doubts = doubts_of(filtered, data, vehicle, mass, load_scale)
    why = (
        f"the filter's own deviation {track.height_std[-1]:.3f} m was widened to {doubts.own:.3f} m (correlated residuals, "
        f"the estimate's wandering) and by {100 * doubts.common:.1f} % (mass, load sensor) and {100 * doubts.model:.1f} % "
        f"(pitch, wheel spin and drag, which the method leaves out){_links(doubts.linked)}; {100 * doubts.apart:.1f} % of the load's changes do not "
        f"go with the force, and a straight line through them gives {doubts.line:.2f} m"
    )
    if not mass.load_known:
        why += "; the load's mass is not stated"
    status = _word(doubts.height_all / max(abs(height), 1e-9), IDENTIFIED, WEAK)
    status, why = against_stated(status, doubts.height_all, why, vehicle)
    if not 0.1 < height < 0.8 * wheelbase:
        status, why = "not_identifiable", f"the filter ended at {height:.2f} m, which no vehicle is; {why}"
    if told is not None:
        status, why = "not_identifiable", told
    place = _word(doubts.axle_all / wheelbase, IDENTIFIED / 3, WEAK / 3)
    position = f"{100 * doubts.common:.1f} % for mass and load sensor, {1000 * height * data.grade_source.std:.0f} mm for the grade"
    if place == "not_identifiable" or not 0.05 < axle / wheelbase < 0.95:
        place = "not_identifiable"
        position = f"the filter ended at {axle:.2f} ± {doubts.axle_all:.2f} m: mass and axle load do not tell the position"
    found = {
        "cg_height_m": _answer("cg_height_m", height, doubts.height, mass, status, why, vehicle),
        "cg_to_front_axle_m": _answer(
            "cg_to_front_axle_m", axle, doubts.axle, mass, place, position, vehicle
        ),
    }
    step = max(1, data.size // TRACK_POINTS)
    tracks = (
        _track("cg_height_m", data.time_s, track.height, track.height_std, doubts.height_all, step),
        _track("cg_to_front_axle_m", data.time_s, track.axle, track.axle_std, doubts.axle_all, step),
    )
    return found, tracks, _traces(filtered, data)


def _track(
    name: str, time_s: FloatArray, value: FloatArray, std: FloatArray, rest: float, step: int
) -> Track:
    half = 1.96 * np.hypot(np.nan_to_num(std[::step]), rest)
    return Track(name, time_s[::step], value[::step], value[::step] - half, value[::step] + half)


def _traces(filtered: Filtered, data: AxleData) -> tuple[Trace, ...]:
    assert data.speed is not None
    track = filtered.track
    speed = {"measured": data.speed, "filtered": track.speed, "innovation": track.innovation}
    height = {
        "weighted": track.height, "HEKF": track.height_first, "EKF (18)": track.height_second,
        "plain three-state EKF": filtered.ekf.height,
    }  # fmt: skip
    return (
        Trace("hekf_ekf: speed", data.time_s, speed, dict.fromkeys(speed, "m/s"), "fit and innovation"),
        Trace(
            "hekf_ekf: height",
            data.time_s,
            height,
            dict.fromkeys(height, "m"),
            "the heights that are weighted",
        ),
    )


def published_assumptions(
    filtered: Filtered, data: AxleData, vehicle: Vehicle, mass: MassKnowledge
) -> tuple[Assumption, ...]:
    """All that was taken as given."""
    s = filtered.settings
    wheelbase = vehicle.quantities["wheelbase_m"]
    return (
        Assumption("loaded mass", f"{np.mean(mass.draws):.0f} ± {np.std(mass.draws):.0f} kg", mass.how),
        Assumption("wheelbase_m", f"{wheelbase.value:.4g} ± {wheelbase.std:.2g} m", wheelbase.source),
        Assumption("axle load", data.load_words, "log"),
        Assumption("speed", data.speed_words, "log"),
        Assumption("road grade", f"constant error within {data.grade_source.std:g} rad", data.grade_source.how),
        Assumption(
            "rolling resistance times radius", f"{filtered.rolling:.4f} m",
            "the vehicle file is silent: left out" if filtered.rolling_unknown else "vehicle file",
        ),
        Assumption("speed noise", f"{filtered.speed_std:.3g} m/s", "second differences of the signal"),
        Assumption("axle load noise", f"{filtered.load_std:.3g} N", "second differences of the signal"),
        Assumption("start", f"height {s.start[1]:.2f} m, position {s.start[2]:.2f} m", "vehicle file or usual shares of the wheelbase"),
    )  # fmt: skip


def published_figures(filtered: Filtered, data: AxleData) -> dict[str, float]:
    """Named figures."""
    track, ekf = filtered.track, filtered.ekf
    return {
        "hekf_height_m": float(track.height_first[-1]),
        "two_state_height_m": float(track.height_second[-1]),
        "plain_ekf_height_m": float(ekf.height[-1]),
        "plain_ekf_axle_m": float(ekf.axle[-1]),
        "filter_height_std_m": float(track.height_std[-1]),
        "filter_axle_std_m": float(track.axle_std[-1]),
        "speed_noise_mps": filtered.speed_std,
        "load_noise_n": filtered.load_std,
        "innovation_rows_in_one": correlation_time(track.innovation, data.rate_hz),
        "samples": float(data.size),
    }
