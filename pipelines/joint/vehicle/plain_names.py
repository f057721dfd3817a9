"""The unknowns in words that a reader of a report knows."""

from __future__ import annotations

from collections.abc import Mapping

_PLACES: Mapping[str, str] = {
    "front": "front axle", "rear": "rear axle", "fl": "front left", "fr": "front right", "rl": "rear left", "rr": "rear right",
}  # fmt: skip
_SEEN: Mapping[str, str] = {
    "deflection": "deflections",
    "suspension": "suspension forces",
    "tyre": "tyre forces",
    "axle": "axle loads",
    "attitude": "the pitch angle",
}
_BALANCES = ("pitch", "roll", "vertical")
_WORDS: Mapping[str, str] = {
    "wheelbase": "wheelbase",
    "track": "track",
    "spring_base": "distance between the springs over the track",
    "force_base": "distance between the springs that forces are logged of",
    "radius": "rolling radius",
    "hub_low": "how far wheel centres stand below the rolling radius",
    "wheel_inertia": "wheels' inertia",
    "tyre_rate": "tyres' vertical rate",
    "rub": "share of the dry friction that holds the nodding body",
    "empty_mass": "empty vehicle's mass",
    "unsprung": "unsprung mass",
    "empty_x": "empty vehicle's CG along",
    "cross": "twist of the standing body",
    "empty_y": "empty vehicle's CG across",
    "empty_h": "empty vehicle's CG height",
    "load": "load",
    "load_wide": "how far the load is spread out across",
    "load_long": "how far the load is spread out along",
    "load_x": "load's place along",
    "load_y": "load's place across",
    "load_h": "load's height",
    "spring": "spring rate",
    "bar": "anti-roll bar",
    "square": "how the spring rate rises into bump",
    "cube": "how the spring rate rises both ways",
    "stop": "bump stop",
    "free": "travel to the bump stop",
    "bump": "damper in bump",
    "rebound": "damper in rebound",
    "friction": "dry friction",
    "zero_twists": "whether a deflection's zero twists the bar",
    "yielding": "share of the friction that turns round within millimetres",
    "zero": "zero of the deflection",
    "stuck": "friction at rest",
    "scale": "scale of the deflection",
    "roll_center": "roll centre's height",
    "track_grows": "how the track grows under a load",
    "axis_sinks": "how far roll centres sink under a load",
    "sinks": "how far the roll centre sinks under a load",
    "side_path": "weight that the feet's sideways ways carry in roll",
    "wheel_plane": "feet that stay in the planes of their wheels",
    "pitch_center_brake": "pitch centre's height in braking (anti-dive)",
    "pitch_center_drive": "pitch centre's height in driving (anti-squat)",
    "camber": "camber compensation",
    "drive_front": "front axle's share of the drive",
    "shaft_roll": "roll by the shafts' torque",
    "paths_told": "whether a rig found the ways of the feet",
    "path": "way of the feet in roll",
    "pitch_path": "height about which the body pitches over its wheels",
    "lean_path": "height about which weight does not tip the leaning body",
    "patch_lag": "tyres' give along the road",
    "patch_side": "tyres' give across the road",
    "standing": "way of the feet at rest",
    "hubs_past": "share of the braked wheels' inertia that passes the springs by",
    "jack_brake": "jacking in braking",
    "jack_drive": "jacking in driving",
    "jack_side": "how far the springs' forces lean with the body (jacking by roll)",
    "jack_bend": "jacking in bends",
    "roll_inertia": "roll inertia",
    "pitch_inertia": "pitch inertia",
    "imu_x": "inertial unit's place along",
    "imu_y": "inertial unit's place across",
    "imu_h": "inertial unit's height",
    "askew_roll": "inertial unit's lean",
    "askew_pitch": "inertial unit's tilt",
    "askew_yaw": "inertial unit's turn",
    "offset_x": "offset of the longitudinal acceleration",
    "offset_y": "offset of the lateral acceleration",
    "offset_z": "offset of the vertical acceleration",
    "suspension_scale": "scale of the suspension forces",
    "suspension_zero": "zero of the suspension force",
    "tyre_scale": "scale of the tyre forces",
    "tyre_zero": "zero of the tyre force",
    "axle_scale": "scale of the axle loads",
    "axle_zero": "zero of the axle load",
    "axle_by_springs": "axle loads that springs carry",
    "swing_pitch": "wheels' part in quick pitch",
    "swing_roll": "wheels' part in quick roll",
    "damping_factor": "dampers at the drive's speeds over the stated ones",
    "inertia_factor": "inertia that the roll motion shows over the vehicle's",
    "drag": "drag area",
    "air": "air's density over the usual",
    "drag_height": "height of the drag",
    "lift": "aerodynamic lift",
    "rolling": "rolling resistance",
    "brake_gain": "brake torque a unit of pressure",
    "drive_scale": "scale of the drive torque",
    "brake_scale": "scale of the brake torque",
    "pads": "pads' friction on the drive",
    "brake_zero": "zero of the brake torque",
    "corner_drag": "tyres' drag in bends",
    "rolling_shift": "rolling resistance that turns the wheels back",
    "product": "product of inertia",
    "pitch_bias": "offset of the pitch moment in motion",
    "pitch_wound": "pitch moment wound up at rest",
    "nod_wound": "nod that held brakes leave at rest",
    "nod_stuck": "share of a gentle nod that dry friction takes",
    "late_long": "delay of the longitudinal acceleration",
    "tilt": "pitch that the acceleration's reading has",
    "gain_long": "model error of the longitudinal balance",
    "engine_drag": "what the engine or motor adds to the brakes",
    "guessed_swing": "angular acceleration taken from springs",
    "poles_sink": "how far the pitch centre comes down with the body",
    "poles_rear": "rear axle's share in that",
    "poles_stay": "whether no load brings the pitch centre down",
    "recovered": "share of a stop that a motor takes",
    "towed": "mass of a trailer",
    "hitch": "how high a trailer pulls",
    "pushes": "share of a trailer that pushes in braking",
}


def plain_name(name: str) -> str:
    """An unknown's name in words, with the axle or wheel it is of; unknowns of single relations as they are called."""
    if name in _WORDS:
        return _WORDS[name]
    head, _, place = name.rpartition("_")
    if head in _WORDS and place in _PLACES:
        return f"{_WORDS[head]}, {_PLACES[place]}"
    what, _, rest = name.partition("_")
    balance, _, seen = rest.partition("_")
    if what in ("late", "gain") and balance in _BALANCES and seen in _SEEN:
        said = "delay in" if what == "late" else "model error of"
        return f"{said} the {balance} balance by {_SEEN[seen]}"
    return name.replace("_", " ")
