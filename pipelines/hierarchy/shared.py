"""What of a vehicle's unknowns stays from drive to drive, and what does not.

An unknown of drive d is mean + std (sqrt(1 - f) s + sqrt(f) e_d), s and e_d of N(0, 1): s is the vehicle's, e_d the drive's own,
and f the share of the variance that is the drive's. So a drive alone knows exactly what it knew before. f = 0: shared; f = 1: of
that drive alone; between: a mean that is shared, and what a drive scatters about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

MOST = 0.8
"""Largest share that a scatter may have: a mean of the vehicle's own there always is."""


@dataclass(frozen=True)
class Belongs:
    """To whom an unknown belongs. share: of its variance before the log that is each drive's own (f), 0 to 1.

    scatter: where given, the standard deviation between drives over the unknown's mean; the share then follows from it,
    and `share` is not looked at. why: in words.
    """

    share: float
    why: str
    scatter: float | None = None

    def own(self, mean: float, std: float) -> float:
        """f for an unknown of this mean and standard deviation."""
        if self.scatter is None:
            return self.share
        return float(min(MOST, (self.scatter * mean / max(std, 1e-300)) ** 2))


BUILT = Belongs(0.0, "built into the vehicle")
MODEL = Belongs(
    0.5, "how this vehicle differs from the model's, which shows in its own way with every road and driver"
)
MOUNTED = Belongs(0.1, "how the sensor is built in; a tenth moves with temperature")
ENGINE = Belongs(
    0.5,
    "torques that a control unit works out: right to some per cent, otherwise when warm, in another gear, on other fuel",
)
PLACED = Belongs(0.3, "a recorder stays where it is, or is put in anew for a drive: nobody says which")
DELAY = Belongs(0.5, "delays and gains: of this vehicle's sensors, and of how it was driven")
LOADED = Belongs(
    0.5, "each drive's own, but loads differ less within a vehicle than between vehicles: seats, tools"
)
HEIGHT = Belongs(0.6, "the same for how high a load lies; what goes onto a roof is less of a habit")
REST = Belongs(
    0.2, "dry friction that holds at rest: mostly the way in which loads come on, in part new at every stop"
)
DRIVEN = Belongs(0.7, "in which gear a drive was braked, and how far an electric motor helped")
WORKING = Belongs(1.0, "how far a drive's load and motion go into the bump stops, from where it stands")
WOUND = Belongs(1.0, "what brakes that hold wind up in the links is another thing at every stop")
TRAILER = Belongs(1.0, "a trailer is another drive's no more")
ROAD = Belongs(1.0, "of the road that was driven, and of that day's air")
DRIFT = Belongs(0.4, "zero errors: a part is the sensor's, a part drifts with temperature")
TYRE = Belongs(0.0, "tyre pressure and temperature change", scatter=0.03)
OIL = Belongs(0.0, "dampers and dry friction change with temperature", scatter=0.08)
AIR = Belongs(0.0, "roof load, open windows and wind change drag", scatter=0.05)
ROLLING = Belongs(
    0.0, "rolling resistance changes with tyre temperature, pressure and the road", scatter=0.12
)
WHEEL = Belongs(0.0, "the rolling radius changes with tyre pressure and load", scatter=0.003)
PADS = Belongs(0.0, "pads fade and wear", scatter=0.02)
FADING = Belongs(0.2, "pads wear over months and fade while hot")
UNKNOWN = Belongs(0.5, "nobody says whether it is the vehicle's or the drive's: half and half")
"""The default, for unknowns that only a single relation has and that are not named here."""

RULES: Mapping[str, Belongs] = {
    "wheelbase": BUILT, "track": BUILT, "spring_base": BUILT, "force_base": BUILT, "shaft_roll": BUILT, "wheel_inertia": BUILT, "empty": BUILT, "unsprung": BUILT, "cross": BUILT,
    "spring": BUILT, "bar": BUILT, "square": BUILT, "cube": BUILT, "roll_center": BUILT, "pitch_center": BUILT, "poles": BUILT,
    "camber": BUILT, "drive_front": BUILT, "hubs_past": BUILT, "jack": BUILT, "roll_inertia": BUILT, "pitch_inertia": BUILT, "drag_height": BUILT, "lift": BUILT,
    "stop": WORKING, "free": BUILT, "engine_drag": DRIVEN, "recovered": DRIVEN, "product": BUILT, "bush": BUILT, "yielding": BUILT, "axle_by_springs": BUILT, "side_path": BUILT, "wheel_plane": BUILT, "path": BUILT, "paths_told": BUILT, "axis_sinks": BUILT, "sinks": BUILT, "patch_side": BUILT,
    "standing": MODEL, "nod_wound": MODEL, "nod_stuck": MODEL, "rub": MODEL, "roll_rubs": MODEL, "pitch_path": MODEL, "lean_path": MODEL, "guessed_swing": MODEL, "patch_lag": MODEL, "swing": MODEL, "inertia_factor": MODEL,
    "damping_factor": MODEL, "corner_drag": MODEL, "rolling_shift": MODEL, "torque_arm": MODEL,
    "axle_pitch_gain": MODEL, "strut_pitch_gain": MODEL, "tilt": MODEL,
    "imu": PLACED, "askew": PLACED, "scale": MOUNTED, "suspension_scale": MOUNTED, "tyre_scale": MOUNTED,
    "axle_scale": MOUNTED, "drive_scale": ENGINE, "brake_scale": ENGINE,
    "late": DELAY, "gain": DELAY,
    "load": LOADED, "load_h": HEIGHT, "stuck": REST, "pitch_wound": WOUND, "banked_bends": ROAD, "air": ROAD, "towed": TRAILER, "hitch": TRAILER, "pushes": TRAILER,
    "offset": DRIFT, "zero": DRIFT, "suspension_zero": DRIFT, "tyre_zero": DRIFT, "axle_zero": DRIFT,
    "brake_zero": DRIFT, "pitch_bias": DRIFT,
    "tyre_rate": TYRE, "radius": WHEEL, "hub_low": BUILT, "bump": OIL, "rebound": OIL, "friction": OIL, "drag": AIR, "rolling": ROLLING,
    "brake_gain": PADS, "pads": FADING,
}  # fmt: skip
"""The unknown's name, or what it begins with up to an underscore (the longest that fits) -> to whom it belongs."""


SENSORS = (MOUNTED, ENGINE, PLACED, DELAY, DRIFT)
"""What another recorder, or one that was put in or calibrated anew, has otherwise."""


def belongs(name: str) -> Belongs:
    """To whom an unknown belongs, by its name; the default for one that is not known."""
    words = name.split("_")
    for count in range(len(words), 0, -1):
        found = RULES.get("_".join(words[:count]))
        if found is not None:
            return found
    return UNKNOWN


def own_shares(
    names: tuple[str, ...],
    mean: np.ndarray[tuple[int], np.dtype[np.float64]],
    std: np.ndarray[tuple[int], np.dtype[np.float64]],
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """(k,) f of every unknown, from its mean and standard deviation before the log (k,)."""
    return np.array([belongs(n).own(float(m), float(s)) for n, m, s in zip(names, mean, std, strict=True)])
