"""Results made by hand for the report's tests: a rich drive, a drive that told nothing, and a hostile one."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from parsers.drive import Decision, Gap, ImportRecord, MappedChannel
from pipelines.drive_results import DriveResults, Inputs, Standing
from pipelines.results import Assumption, Estimate, ParameterEstimate, Prior, Scatter, Trace, Track
from pipelines.rollover_results import (
    CoefficientCheck,
    Exceedance,
    Rollover,
    RolloverLimit,
    TurnMargin,
    WheelLift,
)
from tests.reports.sample_distributions import particle_filter
from tests.reports.sample_forces import mapped
from tests.reports.sample_joint import hostile_joint, joint

HOSTILE = '<script>alert("x")</script> #panic("typst") $E=mc^2$ \\u{41} `raw` *b* _i_ @ref </svg> ]]> \x00\x1b[31m\u202e 车 é'
DURATION = 84.0


def estimate_of(name, value, half, status, reason, *, prior=None, reference=None, sources=("roll_map",)):
    """A parameter with a symmetric interval."""
    if value is None:
        return ParameterEstimate(name, None, None, None, None, status, reason, prior, reference, ())
    return ParameterEstimate(
        name, value, half / 1.96, value - half, value + half, status, reason, prior, reference, sources
    )


def verdict():
    """A mix of what a roll manoeuvre gives."""
    cg_prior = Prior(0.551, 0.034, "measured vehicles: 612 sedans, scaled to 1 563 kg (Heydinger 1999)")
    no_long = "the log has no brake pressure and no wheel speeds"
    rows = [
        estimate_of(
            "cg_height_m", 0.5581, 0.0561, "weak",
            "the roll motion fixes K/(mh), not h alone; the height comes from the prior on roll stiffness, and the log narrowed it by 16 %",
            prior=cg_prior, reference=0.549,
        ),
        estimate_of("mass_kg", 1563.0, 31.0, "weak", "no signal of this log weighs the vehicle; the value is the vehicle file's",
                    prior=Prior(1563.0, 16.0, "vehicle file"), reference=1571.0),
        ParameterEstimate("sprung_mass_kg", None, None, None, None, "not_identifiable", no_long,
                          Prior(1380.0, 60.0, "mass less 12 % unsprung, a usual share")),
        estimate_of("roll_gradient_degpg", 4.8312, 0.0924, "identified", "1 812 samples in steady turns up to 0.71 g agree with a line",
                    prior=Prior(5.5, 1.5, "passenger cars, 3-9 deg/g"), reference=4.79),
        estimate_of("roll_natural_frequency_hz", 1.6132, 0.071, "identified", "the slalom excites 0.3-2.2 Hz",
                    prior=Prior(1.6, 0.35, "passenger cars")),
        estimate_of("roll_damping_ratio", 0.272, 0.048, "identified", "the roll rate after each steering reversal shows the decay",
                    prior=Prior(0.3, 0.12, "passenger cars"), reference=0.341),
        estimate_of("roll_stiffness_nmprad", 61432.0, 15210.0, "weak", "only its ratio to m·h is seen",
                    prior=Prior(58000.0, 12000.0, "springs and track, usual anti-roll bars")),
        estimate_of("roll_inertia_kgm2", 512.0, 118.0, "weak", "enters with h in one combination",
                    prior=Prior(498.0, 72.0, "204 measured inertias, by mass and track")),
        estimate_of("cg_lateral_offset_m", -0.0042, 0.031, "not_identifiable", "no standstill on level ground in this log",
                    prior=Prior(0.0, 0.03, "left and right of most cars are alike")),
        *(estimate_of(f"corner_mass_{w}_kg", None, 0, "not_identifiable", no_long) for w in ("fl", "fr", "rl", "rr")),
        *(estimate_of(f"tire_normal_force_{w}_n", None, 0, "not_identifiable", "needs the corner masses") for w in ("fl", "fr", "rl", "rr")),
    ]  # fmt: skip
    return {row.name: row for row in rows}


def signals(seconds=DURATION, rate=100.0, seed=1):
    """Slalom-like signals with a gap as NaN and one spike of one sample."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 1.0 / rate)
    steer = np.where((time > 12) & (time < 66), np.sin(2 * np.pi * 0.42 * time) * (0.5 + time / 90), 0.0)
    accel = 5.6 * steer + rng.normal(0, 0.25, time.size)
    roll = np.deg2rad(4.83) * accel / 9.81 + rng.normal(0, 0.0012, time.size)
    speed = 9.7 * np.clip(time / 8, 0, 1) * np.clip((seconds - time) / 10, 0, 1) + rng.normal(
        0, 0.03, time.size
    )
    steering = 1.9 * steer + rng.normal(0, 0.01, time.size)
    steering[int(0.47 * time.size)] = 11.0
    columns = {
        "accel_y": (accel, "m/s²"),
        "accel_x": (np.gradient(speed, time) * 0.1 + rng.normal(0, 0.2, time.size), "m/s²"),
        "roll_rate": (np.gradient(roll, time) * 0.2, "rad/s"),
        "yaw_rate": (accel / 9.7 * 0.9 + rng.normal(0, 0.01, time.size), "rad/s"),
        "roll": (roll, "rad"),
        "speed": (speed, "m/s"),
        "steering_wheel_angle": (steering, "rad"),
        "satellites": (np.full(time.size, 9.0), ""),
    }
    gone = (time > 30.2) & (time < 33.9)
    out = []
    for name, (values, unit) in columns.items():
        values = values.copy()
        values[gone] = np.nan
        out.append(Trace(name, time, {name: values}, {name: unit}))
    return tuple(out)


def roll_estimate(traces):
    """The roll estimator's estimate with tracks, traces and a scatter."""
    by_name = {t.name: t for t in traces}
    time = by_name["roll"].time_s
    roll = by_name["roll"].columns["roll"]
    accel = by_name["accel_y"].columns["accel_y"]
    model = np.deg2rad(4.83) * accel / 9.81
    x = np.nan_to_num(accel) / 9.81
    grid = np.linspace(-0.75, 0.75, 60)
    band = 0.09 + 0.16 * grid**2
    rng = np.random.default_rng(5)
    step = np.linspace(0.5, DURATION, 400)
    shrink = 1 / np.sqrt(1 + step / 4)
    heights = 0.558 + 0.02 * shrink * np.sin(step / 7)
    gradients = 4.83 + 1.2 * shrink**2 * np.cos(step / 5)
    both = verdict()
    return Estimate(
        "roll_map", "ran", "batch maximum a posteriori on the roll model of Berntorp et al., equations (1)-(4)",
        parameters={k: both[k] for k in ("cg_height_m", "roll_gradient_degpg", "roll_natural_frequency_hz", "roll_damping_ratio")},
        tracks=(
            Track("cg_height_m", step, heights, heights - 0.02 - 0.09 * shrink, heights + 0.02 + 0.09 * shrink),
            Track("roll_gradient_degpg", step, gradients, gradients - 0.08 - 2 * shrink**2, gradients + 0.08 + 2 * shrink**2),
        ),
        traces=(
            Trace("roll angle", time, {"measured": roll, "model": model}, {"measured": "rad", "model": "rad"}, "The model runs on the measured lateral acceleration."),
            Trace("roll angle residual", time, {"residual": roll - model}, {"residual": "rad"}),
        ),
        scatters=(
            Scatter("roll_vs_lateral", "Roll against lateral acceleration", "lateral acceleration, g", "roll, deg",
                    x, 4.83 * x + rng.normal(0, 0.12, x.size), grid, 4.83 * grid, 4.83 * grid - band, 4.83 * grid + band,
                    "4.83 deg/g: 1 812 samples in steady turns, low-passed at 1 Hz."),
            Scatter("roll_rate_phase", "Roll rate after release", "roll, deg", "roll rate, deg/s",
                    x[:900] * 3, np.roll(x[:900], 40) * 20, np.empty(0), np.empty(0), np.empty(0), np.empty(0)),
        ),
        assumptions=(
            Assumption("time delay of the roll channel", "0.03 s ± 0.05 s", "estimated with the roll parameters; prior of the estimator's settings"),
            Assumption("road bank", "level, ± 1 deg", "settings, roll_map.bank_std_deg"),
        ),
        diagnostics={"log_likelihood": 18234.43, "residual_autocorrelation_lag1": 0.31, "iterations": 41.0, "condition": float("inf")},
        used_fraction=0.643, runtime_s=1.38,
    )  # fmt: skip


def record():
    """An import record with decisions of both kinds, gaps and rejected rows."""
    mapped = (
        MappedChannel("accel_y", "LatAcc", "g", "channel units line", "VBOX profile", 8031, 100.0, 9.80665),
        MappedChannel("yaw_rate", "YawRate", "deg/s", "channel units line", "VBOX profile", 8031, 100.0, math.pi / 180, 0.0, True),
        MappedChannel("roll_rate", "RollRate", "deg/s", "guessed from the values", "VBOX profile", 8031, 100.0, math.pi / 180, -0.0021),
        MappedChannel("speed", "velocity kmh", "km/h", "format", "VBOX profile", 8031, 100.0, 1 / 3.6, 0.0, False, ("Speed_CAN", "/vehicle/wheel_odometry/twist.twist.linear.x")),
        MappedChannel("steering_wheel_angle", "/very/long/topic/name/of/a/message.field.with.a.path.that.goes.on.and_on_and_on[0]", "deg", "map file", "map.toml", 8031, 99.98, math.pi / 180),
    )  # fmt: skip
    return ImportRecord(
        "vbo", (Path("logs/slalom_35kph.vbo"),), "3f8a" * 16, "truncated", 8137,
        {"row with too few columns": 1, "time runs backwards": 3},
        (Gap(30.2, 33.9), Gap(51.0, 51.6, "steering_wheel_angle")),
        "UTC time of day (satellites)", "2024-05-17T09:41:20Z", DURATION, mapped,
        decisions=(
            Decision("yaw_rate", "sign", "yaw_rate has the sign opposite to lateral acceleration", "inverted", "correlation −0.98 with accel_y/speed over 41 s", True),
            Decision("steering_wheel_angle", "spikes", "steering_wheel_angle jumps by more than 40 rad/s for single samples", "12 samples left out", "12 of 8 031 samples", True),
            Decision("roll_rate", "offset", "roll_rate is not zero at standstill", "left as it is; the estimator carries an offset", "0.021 rad/s over 6.2 s", False),
        ),
        notes=("the last line of the file breaks off after 7 of 23 columns; 8 136 rows before it are whole",),
        out_of_order=3, duplicates=2, clock_jumps=1,
    )  # fmt: skip


def rollover_of(ssf, threshold):
    """A drive near its threshold in left turns: every part of the record is there, with a gap in the traces."""
    time = np.linspace(0, DURATION, 900)
    lateral = 0.7 * np.sin(2 * np.pi * time / 14)
    lateral[400] = np.nan
    limit = 1.24 - 0.15 * np.abs(lateral)
    margin = {
        "lateral_acceleration": lateral,
        "limit_left": limit,
        "limit_left_low": limit - 0.1,
        "limit_left_high": limit + 0.1,
        "limit_right": -limit,
        "limit_right_low": -limit - 0.1,
        "limit_right_high": -limit + 0.1,
    }
    share = {
        "coefficient": -0.85 * lateral,
        "low": -0.9 * lateral,
        "high": -0.8 * lateral,
        "from_forces": -0.86 * lateral,
        "residual": -0.01 * lateral,
    }
    near = estimate_of("least_margin_g", 0.41, 0.12, "weak", "CG height weak")
    peak = estimate_of("peak_coefficient", 0.61, 0.06, "weak", "CG height weak")
    sides = [
        RolloverLimit(name, title, equation, ssf, threshold)
        for name, title, equation in (
            ("rigid", "Rigid vehicle", "(157)"),
            ("quasi_static", "Threshold", "(163) extended"),
        )
    ]
    return Rollover(
        ssf, threshold, 0.713, 0.61, 48.31, ("The track is the vehicle file's mean of front and rear.",), peak, "tyre forces, (158)", tuple(sides),
        (TurnMargin("left", threshold, near, peak, 48.31, 0.713, 0.13), TurnMargin("right", threshold, near, peak, 21.0, -0.69, 0.001)),
        (
            WheelLift("rl", "wheel", 48.2, 0.22, 61.0, 0.83, 0.71, "measured by wheel-force transducers"),
            WheelLift("left", "side", 60.0, 0.1, None, 0.2, None, "load transfer"),
            WheelLift("fr", "bounce", 12.0, 0.06, 120.0, 0.4, 0.02, "measured by wheel-force transducers"),
        ),
        "measured by wheel-force transducers", Exceedance(0.13, "about 13 %", ("the CG height is weakly known",)),
        CoefficientCheck(estimate_of("coefficient_slope", 1.02, 0.02, "identified", ""), 0.012, True, "the tyre forces move 2.0 % more load across"),
        (Trace("rollover margin", time, margin, dict.fromkeys(margin, "g"), "limits"), Trace("rollover coefficient", time, share, {}, "share")),
        (Assumption("rollover: CG lateral offset", "0 ± 0.02 m", "not in the verdict"),),
    )  # fmt: skip


def rich() -> DriveResults:
    """A drive as an engineer would hand it on."""
    traces = signals()
    rng = np.random.default_rng(3)
    population = np.concatenate(
        (rng.normal(0.545, 0.03, 640), rng.normal(0.66, 0.05, 430), rng.normal(0.72, 0.05, 200))
    )
    everything = verdict()
    ssf = estimate_of("static_stability_factor", 1.384, 0.141, "weak", "from the CG height and the track")
    threshold = estimate_of(
        "rollover_threshold_g", 1.24, 0.13, "weak", "static stability factor less the body's roll"
    )
    return DriveResults(
        inputs=Inputs(
            ("logs/slalom_35kph.vbo",), "3f8a" * 16, "vehicles/volvo_v40.toml", "77ab" * 16, None, "settings.toml", (), 7,
            "cogest analyze logs/slalom_35kph.vbo --vehicle vehicles/volvo_v40.toml --seed 7", "0.1.0", "2024-05-18T07:12:09Z",
        ),
        record=record(), vehicle_name="Volvo V40 T2, 2 persons", verdict=everything,
        estimates=(
            roll_estimate(traces),
            Estimate("grade_mass", "skipped", "needs drive_torque and road_grade; the log has neither, and altitude is missing for the grade"),
            Estimate("quarter_car", "skipped", "needs accel_z_sprung and accel_z_unsprung on one wheel at least"),
            Estimate("load_transfer", "failed", "the normal equations are singular: lateral acceleration and roll are collinear"),
            mapped(),
            particle_filter(),
        ),
        rollover=rollover_of(ssf, threshold),
        standing=Standing(population, population[:640], "Sedan", 61.0, ("Volvo S40 2001 (0.553 m)", "Honda Accord 1998 (0.556 m)")),
        assumptions=(
            Assumption("track", "1.549 m ± 0.008 m", "vehicle file"),
            Assumption("roll centre height", "0.09 m ± 0.04 m", "measured vehicles are silent: a usual range"),
        ),
        limits=(
            "The roll motion alone cannot tell the CG height from the roll stiffness: give roll_stiffness_nmprad or spring rates in the vehicle file.",
            "No braking above 0.2 g: the pitch parameters cannot be told.",
            "64 % of the drive met the gates (speed above 3 m/s, no gap).",
        ),
        signals=traces, notes=("Roll is from gyro and gravity, not measured.",), joint=joint(),
    )  # fmt: skip


def bare() -> DriveResults:
    """A log that tells nothing about a vehicle that nobody described."""
    why = "the log has no lateral acceleration and no roll rate"
    names = ("cg_height_m", "mass_kg", "roll_gradient_degpg")
    return DriveResults(
        inputs=Inputs(("robot.mcap",), "00" * 32, None, None, None, None, (), 0, "cogest analyze robot.mcap", "0.1.0", ""),
        record=ImportRecord("mcap", (Path("robot.mcap"),), "00" * 32, "complete", 0, {}, (), "log time", None, 0.0, ()),
        vehicle_name=None,
        verdict={n: ParameterEstimate(n, None, None, None, None, "not_identifiable", why) for n in names},
        estimates=(Estimate("roll_map", "skipped", why),),
        rollover=Rollover(), standing=None, assumptions=(), limits=(why,), signals=(),
    )  # fmt: skip


def hostile_rollover(good):
    """The same with every text that may come from a log, a file or a name."""
    bad = replace(good.turns[0].threshold_g, reason=HOSTILE)
    return replace(
        good, notes=(HOSTILE,), coefficient_source=HOSTILE, lift_source=HOSTILE, exceedance=Exceedance(0.5, HOSTILE, (HOSTILE,)),
        limits=tuple(replace(limit, title=HOSTILE, equation=HOSTILE, left=bad) for limit in good.limits),
        lifts=(*good.lifts, replace(good.lifts[0], wheel=HOSTILE, source=HOSTILE)), check=replace(good.check, text=HOSTILE),
        assumptions=(Assumption(HOSTILE, HOSTILE, HOSTILE),),
    )  # fmt: skip


def hostile() -> DriveResults:
    """The rich drive with markup, control characters and other scripts in every text that a log or a file can set."""
    good = rich()
    rec = good.record
    bad_map = replace(
        rec.mapped[0], channel=HOSTILE, unit=HOSTILE, unit_from=HOSTILE, rule=HOSTILE, alternatives=(HOSTILE,)
    )
    trace = good.signals[0]
    evil_trace = Trace(
        HOSTILE, trace.time_s, {HOSTILE: trace.columns["accel_y"]}, {HOSTILE: HOSTILE}, HOSTILE
    )
    evil = replace(
        good.estimates[0], estimator=HOSTILE, reason=HOSTILE, traces=(evil_trace, replace(evil_trace, name=HOSTILE + " residual")),
        scatters=tuple(replace(s, title=HOSTILE, x_label=HOSTILE, y_label=HOSTILE, note=HOSTILE) for s in good.estimates[0].scatters),
        assumptions=(Assumption(HOSTILE, HOSTILE, HOSTILE),), diagnostics={HOSTILE: math.nan},
    )  # fmt: skip
    return replace(
        good, joint=hostile_joint(HOSTILE), rollover=hostile_rollover(good.rollover), vehicle_name=HOSTILE, limits=(HOSTILE,), notes=(HOSTILE,), estimates=(evil, *good.estimates[1:]),
        signals=(evil_trace, *good.signals[1:]), assumptions=(Assumption(HOSTILE, HOSTILE, HOSTILE),),
        inputs=replace(good.inputs, logs=(HOSTILE,), command=HOSTILE, vehicle=HOSTILE),
        standing=replace(good.standing, body=HOSTILE, nearest=(HOSTILE,)),
        verdict={k: replace(v, reason=HOSTILE) for k, v in good.verdict.items()},
        record=replace(
            rec, clock=HOSTILE, notes=(HOSTILE,), rejected={HOSTILE: 3}, mapped=(bad_map,),
            decisions=(Decision(HOSTILE, "sign", HOSTILE, HOSTILE, HOSTILE, False),), gaps=(Gap(1, 2, HOSTILE),),
        ),
    )  # fmt: skip
