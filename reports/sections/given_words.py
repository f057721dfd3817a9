"""What was taken as given, in words: a quantity's name, its figures with unit and sensible digits, and which entries are one."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from pipelines.vehicles.keys import VEHICLE_KEYS
from reports.text import clean, decimals_for, number, significant, with_unit

_UNITS: tuple[tuple[str, str, float], ...] = (
    ("_nmppa", "N·m/bar", 1e5), ("_mprad", "m/rad", 1.0), ("_nmsprad", "N·m·s/rad", 1.0), ("_nmprad", "N·m/rad", 1.0), ("_nspm", "N·s/m", 1.0), ("_npm", "N/m", 1.0),
    ("_kgm2", "kg·m²", 1.0), ("_degpg", "deg/g", 1.0), ("_deg", "deg", 1.0), ("_rad", "rad", 1.0), ("_kg", "kg", 1.0), ("_m2", "m²", 1.0),
    ("_hz", "Hz", 1.0), ("_mps2", "m/s²", 1.0), ("_mps", "m/s", 1.0), ("_pa", "Pa", 1.0), ("_nm", "N·m", 1.0), ("_m", "m", 1.0), ("_s", "s", 1.0), ("_n", "N", 1.0),
)  # fmt: skip
"""How a key ends, the unit to print, and the factor to it; a longer ending stands before one that it ends with."""

_WORDS: dict[str, str] = {
    "mass_kg": "Mass, empty", "mass_kg (empty)": "Mass, empty", "mass (loaded)": "Mass, loaded",
    "cg_height_m": "CG height above ground, empty", "cg_height_m (empty)": "CG height above ground, empty",
    "cg_to_front_axle_m": "CG to front axle, empty", "CG to front axle (loaded)": "CG to front axle, loaded",
    "lateral place of the empty vehicle's CG, m": "CG lateral offset, empty (+ left)",
    "load mass": "Load", "load, kg": "Load", "load height": "Load's height above ground", "load above ground, m": "Load's height above ground",
    "load behind the front axle, m": "Load's place behind the front axle", "load left of the middle, m": "Load's place left of the middle",
    "wheel_radius_m": "Wheel radius, height of the hubs", "hub height": "Wheel radius, height of the hubs",
    "accelerometer above ground": "Inertial unit above ground",
    "tire_vertical_rate_npm (a tyre, four in all)": "Tyre vertical rate, each", "tire_vertical_rate_npm": "Tyre vertical rate, each",
    "roll_inertia_kgm2": "Roll inertia, empty", "roll_inertia_kgm2 (empty)": "Roll inertia, empty", "pitch_inertia_kgm2": "Pitch inertia, empty",
    "pitch_center_height_m (links' part in braking: anti-dive)": "Pitch centre height in braking (anti-dive)",
    "pitch_center_height_m": "Pitch centre height in braking (anti-dive)",
    "pitch_center_height_drive_m (anti-squat)": "Pitch centre height in driving (anti-squat)",
    "pitch_center_height_drive_m": "Pitch centre height in driving (anti-squat)",
    "height about which the body pitches over its wheels, m": "Height about which the body pitches over its wheels",
    "brake_gain_nmppa": "Brake torque per pressure", "brake_front_share": "Front axle's share of the braking",
    "drive_front_share": "Front axle's share of the driving", "rolling_resistance": "Rolling resistance coefficient",
    "imu_left_m": "Inertial unit left of the middle", "particle filter: roll signal": "Roll signal", "data": "The log's data",
}  # fmt: skip
"""Names whose words no rule makes; several names of one quantity have the same."""

_SPELT = {
    "cg": "CG",
    "imu": "inertial unit",
    "tire": "tyre",
    "center": "centre",
    "std": "spread",
    "anti": "anti-",
}
_KEY = re.compile(r"[a-z][a-z0-9]*(?:_[a-z0-9]+)+")
_UNIT_BEHIND = re.compile(r", (m|kg|N|s|rad|deg|Hz)$")
_NUMBER = r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
_FIGURES = re.compile(rf"({_NUMBER}) ± ({_NUMBER})(?: (\D\S*))?")


@dataclass(frozen=True)
class Given:
    """A quantity in words, its figures as printed, and whether these are a value with a spread."""

    words: str
    value: str
    measured: bool


def _unit_of(name: str) -> tuple[str, str, float]:
    """The name without its unit, the unit, and the factor to it."""
    behind = _UNIT_BEHIND.search(name)
    if behind:
        return name[: behind.start()], behind[1], 1.0
    key = _KEY.match(name)
    if key:
        for ending, unit, factor in _UNITS:
            if key[0].endswith(ending):
                return key[0].removesuffix(ending) + name[key.end() :], unit, factor
    return name, "", 1.0


def _of_key(key: str) -> str:
    """Words of a key: "spring_rate_front" is "spring rate, front"."""
    words = [_SPELT.get(word, word) for word in key.split("_")]
    axle = [word for word in words if word in ("front", "rear")]
    if len(axle) == 1 and not key.startswith(axle[0]) and "behind" not in words and "axle" not in words:
        words.remove(axle[0])
        return f"{' '.join(words)}, {axle[0]}".replace("- ", "-")
    return " ".join(words).replace("- ", "-")


def capital(text: str) -> str:
    """A text that begins with a capital, unless its first word is a name ("accel_x", "docs/x.md")."""
    first = text.split(" ", 1)[0]
    return text if re.search(r"[_/.\d]", first) else text[:1].upper() + text[1:]


def words_of(name: str) -> str:
    """A quantity's name as a reader says it."""
    if name in _WORDS:
        return _WORDS[name]
    bare, _, _ = _unit_of(name)
    return capital(_KEY.sub(lambda key: _of_key(key[0]), clean(bare, 120)))


def _figures(name: str, value: str) -> str | None:
    """A value with its spread: two digits of the spread, thousands apart, the unit behind; None where it is none."""
    found = _FIGURES.fullmatch(value.strip())
    if found is None:
        return None
    _, unit, factor = _unit_of(name)
    if found[3] and not (unit and factor != 1.0):
        # the unit in the text holds, unless the key's is printed as another one
        unit, factor = found[3], 1.0
    middle, spread = (float(text.replace("−", "-")) * factor for text in found.group(1, 2))
    if not (math.isfinite(middle) and math.isfinite(spread)):
        return None
    decimals = decimals_for(spread, 3)
    shown = (
        f"{number(middle, decimals)} ± {number(spread, decimals)}" if spread > 0 else significant(middle, 4)
    )
    return with_unit(shown, unit)


RIGID_NPM = 1e8
"""A tyre's rate that says that it does not give: no tyre has one."""
_LONG = re.compile(r"(?<![\w.])\d+(?:\.\d+)?e[-+]?\d+|(?<![\w.])\d{6,}(?![\w.])")


def given(name: str, value: str) -> Given:
    """One entry in words."""
    figures = _figures(name, value)
    rate = _FIGURES.fullmatch(value.strip()) if name.startswith("tire_vertical_rate_npm") else None
    if rate is not None and float(rate[1]) >= RIGID_NPM:
        return Given(words_of(name), "it does not give", True)
    if figures is not None:
        return Given(words_of(name), figures, True)
    plain = _LONG.sub(lambda found: significant(float(found[0]), 4), clean(value, 300))
    return Given(words_of(name), plain, False)


def file_key(name: str) -> str:
    """The vehicle file's key within a name; empty where there is none."""
    found = _KEY.match(name)
    return found[0] if found and found[0] in VEHICLE_KEYS else ""
