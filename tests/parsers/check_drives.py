"""A made drive for the tests of the checks, and faults to plant in it."""

from dataclasses import replace
from functools import cache

import numpy as np

from parsers.checks import check_signals
from parsers.drive import Signal

RATE = 50.0
NS = 1_000_000_000
DEG = np.pi / 180
G = 9.80665
DEFLECTIONS = tuple(f"suspension_deflection_{wheel}" for wheel in ("fl", "fr", "rl", "rr"))


def drive(kind="slalom", **options):
    """Signals of a drive; a new dictionary each time."""
    return dict(made_drive(kind, **options))


def demand(kind, t, speed):
    """What the driver does: speed and steering wheel angle at the times t (n,)."""
    v = np.full(len(t), speed)
    steer = np.zeros(len(t))
    if kind == "slalom":
        v = speed + 4 * np.sin(2 * np.pi * t / 25) + 1.5 * np.sin(2 * np.pi * t / 7)
        steer = 0.6 * np.sin(2 * np.pi * 0.4 * t) * (t > 4)
    elif kind == "weave":
        v = speed + 4 * np.sin(2 * np.pi * t / 25) + 1.5 * np.sin(2 * np.pi * t / 7)
        steer = 0.4 * np.sin(2 * np.pi * 0.15 * t) + 0.3 * np.sin(2 * np.pi * 0.4 * t)
    elif kind == "circle":
        steer = np.clip((t - 5) * 0.2, 0, 0.9)
    elif kind == "step":
        steer = 1.2 * (t > 10) * (t < 25) - 1.2 * (t > 35) * (t < 50)
    elif kind == "dwell":
        phase = (t - 10) * 0.7
        wave = np.where(phase < 0.75, np.sin(2 * np.pi * phase), -1.0)
        held_for = 0.75 + 0.5 * 0.7
        wave = np.where(phase > held_for, np.sin(2 * np.pi * (phase - 0.35)), wave)
        steer = 270 * DEG * wave * (phase > 0) * (phase < 1.35)
    elif kind == "brake":
        v = np.clip(30 - 9 * np.clip(t - 10, 0, 3), 2, None) + np.clip(t - 20, 0, 8) * 2.5
    return v, steer


@cache
def made_drive(kind, seconds=60.0, noise=1.0, seed=1, speed=20.0):
    """A simple car: lagged yaw from steering, second-order roll, path, wheels; SI and ISO 8855."""
    rng = np.random.default_rng(seed)
    step = 1 / RATE
    t = np.arange(0, seconds, step)
    v, steer = demand(kind, t, speed)
    gain = v / (16 * (2.7 + 0.003 * v**2))
    yaw = np.zeros(len(t))
    for k in range(1, len(t)):
        yaw[k] = yaw[k - 1] + step / 0.15 * (gain[k] * steer[k] - yaw[k - 1])
    lateral = v * yaw
    lateral = 8.5 * np.tanh(lateral / 8.5)
    yaw = lateral / v
    forward = np.gradient(v, step)
    roll, rate = np.zeros(len(t)), np.zeros(len(t))
    for k in range(1, len(t)):
        rate[k] = rate[k - 1] + step * (81 * (0.007 * lateral[k] - roll[k - 1]) - 6 * rate[k - 1])
        roll[k] = roll[k - 1] + step * rate[k]
    pitch = -0.004 * forward
    heading = np.cumsum(yaw) * step
    north, east = np.cumsum(v * np.sin(heading)) * step, np.cumsum(v * np.cos(heading)) * step
    made = {
        "accel_x": (forward, 0.15),
        "accel_y": (lateral + G * np.sin(roll), 0.15),
        "accel_z": (np.full(len(t), G), 0.3),
        "roll_rate": (rate, 0.006),
        "pitch_rate": (np.gradient(pitch, step), 0.006),
        "yaw_rate": (yaw, 0.003),
        "roll": (roll, 0.0005),
        "pitch": (pitch, 0.0005),
        "speed": (v, 0.03),
        "steering_wheel_angle": (steer, 0.002),
        "wheel_speed_rl": (v - 0.75 * yaw, 0.03),
        "wheel_speed_rr": (v + 0.75 * yaw, 0.03),
    }
    start = 1_700_000_000 * NS
    signals = {}
    for place, (name, (values, sigma)) in enumerate(made.items()):
        stamps = start + (t * NS).astype(np.int64) + place * 1_300_000 + rng.integers(0, 400_000, len(t))
        signals[name] = Signal(
            name, stamps, values + noise * sigma * rng.standard_normal(len(t)), name, group="bus"
        )
    thin = slice(None, None, 10)  # satellites at 5 Hz
    stamps = start + (t[thin] * NS).astype(np.int64)
    latitude = 52 + np.rad2deg(north[thin] / 6_371_000)
    longitude = 13 + np.rad2deg(east[thin] / (6_371_000 * np.cos(52 * DEG)))
    signals["latitude"] = Signal("latitude", stamps, latitude, "latitude", group="gps")
    signals["longitude"] = Signal("longitude", stamps, longitude, "longitude", group="gps")
    return signals


def sprung(kind="slalom"):
    """The made drive with deflections that follow its roll and pitch, and without satellites, wheels and angles."""
    signals = drive(kind)
    roll, pitch = signals["roll"], signals["pitch"]
    rng = np.random.default_rng(5)
    made = {}
    for name in DEFLECTIONS:
        side, end = (1 if name.endswith("r") else -1), (1 if "_f" in name else -1)
        tilt = 0.75 * side * roll.values + 1.3 * end * np.interp(roll.time_ns, pitch.time_ns, pitch.values)
        noise = 0.0005 * rng.standard_normal(len(tilt))
        made[name] = replace(roll, name=name, source=name, values=tilt + 0.01 + noise, group="springs")
    kept = only(signals, "accel_x", "accel_y", "accel_z", "yaw_rate", "roll_rate", "pitch_rate", "speed")
    return kept | only(signals, "steering_wheel_angle") | made


def only(signals, *names):
    return {name: signals[name] for name in names}


def scaled(signals, **factors):
    return signals | {
        name: replace(signals[name], values=signals[name].values * f) for name, f in factors.items()
    }


def found(decisions, kind):
    return {each.signal for each in decisions if each.kind == kind}


def check(signals, stated=True, fix=True):
    return check_signals(signals, fix=fix, units_stated=dict.fromkeys(signals, stated))


def same(one, other):
    return set(one) == set(other) and all(
        np.array_equal(one[n].values, other[n].values) and np.array_equal(one[n].time_ns, other[n].time_ns)
        for n in one
    )
