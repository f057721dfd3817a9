"""An estimator's named figures in words, with units."""

from __future__ import annotations

import re

from reports.text import clean, percent, significant, with_unit

_UNITS: tuple[tuple[str, str], ...] = (
    ("_radps", "rad/s"), ("_degps", "deg/s"), ("_mps2", "m/s²"), ("_mps", "m/s"), ("_nspm", "N·s/m"), ("_npm", "N/m"), ("_kgm2", "kg·m²"),
    ("_kgm", "kg·m"), ("_nm", "N·m"), ("_deg", "deg"), ("_hz", "Hz"), ("_kg", "kg"), ("_mm", "mm"), ("_ms", "ms"), ("_m", "m"), ("_s", "s"), ("_n", "N"),
)  # fmt: skip

_WHOLE: dict[str, tuple[str, str]] = {
    "a": ("roll equation's stiffness a", "m/s² a rad"), "b": ("roll equation's damping b", "m/s a rad"),
    "c": ("roll equation's inertia c", "m"),
    "moving_std_m": ("spread of the height over the last seconds", "m"),
    "speed_delay_s": ("delay of the speed", "s"), "accel_x_gain": ("gain of accel_x", ""),
    "slip_height_m": ("CG height by the wheels' slip", "m"), "slip_height_std_m": ("CG height by the wheels' slip, its spread", "m"),
    "start_left_share": ("share of the start value that is left at the end", ""), "stops": ("stops used", ""),
    "height_braking_m": ("CG height by braking alone", "m"), "added_mass_lrls_kg": ("added mass by recursive least squares", "kg"),
    "spread_mass_m": ("height's spread from mass", "m"), "load": ("load", "kg"), "load_x": ("load's place behind the front axle", "m"), "load_y": ("load's place left of the middle", "m"),
    "load_h": ("load's height above ground", "m"), "spring_front": ("front spring rate", "N/m"), "spring_rear": ("rear spring rate", "N/m"),
    "pitch_center_brake": ("pitch centre height in braking", "m"), "pitch_center_drive": ("pitch centre height in driving", "m"),
    "roll_center_front": ("front roll centre height", "m"), "roll_center_rear": ("rear roll centre height", "m"),
    "model_K": ("model's roll stiffness", "N·m/rad"), "model_D": ("model's roll damping", "N·m·s/rad"), "model_h": ("model's CG height", "m"),
    "roll_noise_std": ("noise of the roll angle", "rad"), "rate_noise_std": ("noise of the roll rate", "rad/s"),
    "roll_per_lateral_acceleration": ("roll angle per lateral acceleration", "rad per m/s²"),
    "balance_noise_mps2": ("noise of the longitudinal balance", "m/s²"),
}  # fmt: skip
"""Names that no rule turns into words."""

_ENDINGS: tuple[tuple[str, str], ...] = (
    ("_own_std", ", spread within a cloud"), ("_between_clouds_std", ", spread between clouds"), ("_std_of_clouds", ", spread between clouds"),
    ("_of_models_std", ", over several models, spread"), ("_of_models", ", over several models"), ("_residual_std", ", residual's spread"),
    ("_std", ", spread"), ("_chi2", ", chi² a figure"), ("_correlation_rows", ", rows that hang together"),
)  # fmt: skip
"""What follows a quantity's name, and how it is said behind the quantity's words; the unit is the quantity's."""

_SPELT = {"std": "spread", "chi2": "chi²", "center": "centre", "tire": "tyre", "cg": "CG", "rms": "RMS"}
_SHARE = re.compile(r"_share$")


def _bare(name: str) -> tuple[str, str]:
    """A name in words, and its unit."""
    if name in _WHOLE:
        return _WHOLE[name]
    unit = ""
    for ending, known in _UNITS:
        if name.endswith(ending) and len(name) > len(ending):
            name, unit = name.removesuffix(ending), known
            break
    if name.startswith("spread_"):
        return f"height's spread from {_plain(name.removeprefix('spread_'))}", unit
    for ending, said in _ENDINGS:
        if name.endswith(ending) and len(name) > len(ending):
            words, own = _bare(name.removesuffix(ending))
            # chi² and counts of rows have no unit, whatever the quantity's
            return words + said, unit or ("" if ending in ("_chi2", "_correlation_rows") else own)
    return _plain(name), unit


def _plain(name: str) -> str:
    return " ".join(_SPELT.get(word, word) for word in name.split("_"))


def diagnostic(name: str, value: float) -> tuple[str, str]:
    """A figure's name in words, and its value with the unit; shares as percent."""
    words, unit = _bare(name)
    if _SHARE.search(name) and 0 <= value <= 1:
        return clean(words, 80), percent(value)
    return clean(words, 80), with_unit(significant(value, 4), unit)
