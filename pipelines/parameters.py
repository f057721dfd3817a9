"""The parameters that cogest estimates: names, units, and how they are printed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from parsers.signals import WHEELS


@dataclass(frozen=True)
class ParameterSpec:
    """name as in results.json; title for tables; unit as printed; digits after the point; positive by nature; meaning: what exactly
    is meant, where a reader could take it for something near by."""

    name: str
    title: str
    unit: str
    digits: int
    positive: bool = True
    meaning: str = ""


_TABLE: list[ParameterSpec] = [
    ParameterSpec("cg_height_m", "CG height above ground", "m", 3, meaning=
        "of the whole vehicle as driven, with its load, at rest on level ground"),
    ParameterSpec("mass_kg", "Mass", "kg", 0, meaning="of the whole vehicle as driven, with driver and load"),
    ParameterSpec("sprung_mass_kg", "Sprung mass", "kg", 0, meaning="what the springs carry of it, load included"),
    ParameterSpec("sprung_cg_height_m", "Sprung mass CG height above ground", "m", 3, meaning="as driven, at rest on level ground"),
    ParameterSpec("cg_to_front_axle_m", "CG to front axle", "m", 3, meaning=
        "of the whole vehicle as it stands under its load: along the ground, from the line through the front wheels' centres backwards"),
    ParameterSpec("cg_lateral_offset_m", "CG lateral offset (+ left)", "m", 3, positive=False, meaning=
        "of the whole vehicle as it stands under its load, from the middle of the tracks"),
    ParameterSpec("roll_center_height_m", "Roll axis height above ground, under the CG", "m", 3, positive=False, meaning=
        "of the line through the axles' roll centres, at the height at which the vehicle was driven"),
    ParameterSpec("roll_arm_m", "Sprung CG height above roll axis", "m", 3, meaning=
        "height of the sprung mass's CG over the line through the axles' roll centres, below the CG"),
    ParameterSpec("pitch_arm_m", "Sprung CG height above pitch axis", "m", 3, meaning=
        "height of the sprung mass's CG over that point through which the links pass the wheels' braking forces to the body "
        "(pitch_center_height_m): the moment that the springs feel is this times the sprung mass's inertia force; driving has another"),
    ParameterSpec("roll_gradient_degpg", "Roll gradient", "deg/g", 2, meaning=
        "steady roll of the body against level ground, tyres included, per g of lateral acceleration as sensed in the body, small angles, without friction"),
    ParameterSpec("roll_natural_frequency_hz", "Roll natural frequency (undamped)", "Hz", 2, meaning=
        "of the body about the roll axis on springs and tyres, gravity's part not taken off"),
    ParameterSpec("roll_damping_ratio", "Roll damping ratio", "–", 2, meaning="roll damping over twice the root of stiffness times inertia about the roll axis"),
    ParameterSpec("roll_stiffness_nmprad", "Roll stiffness", "N·m/rad", 0, meaning=
        "of the suspension, body against axles: springs and bars of both axles without the tyres, at the height at which the loaded body stands (data sheets: the empty one)"),
    ParameterSpec("roll_damping_nmsprad", "Roll damping", "N·m·s/rad", 0, meaning=
        "of the dampers, body against axles: the mean of bump and rebound at this drive's speeds"),
    ParameterSpec("roll_inertia_kgm2", "Roll inertia", "kg·m²", 0, meaning="of the whole vehicle as driven, about its own CG"),
    ParameterSpec("pitch_inertia_kgm2", "Pitch inertia", "kg·m²", 0, meaning="of the whole vehicle as driven, about its own CG"),
    ParameterSpec("suspension_damping_nspm", "Suspension damping (a wheel)", "N·s/m", 0, meaning=
        "force per speed at a wheel, the mean of all wheels, at this drive's speeds"),
    *(ParameterSpec(f"corner_mass_{w}_kg", f"Corner mass {w}", "kg", 0, meaning=
        "what a scale under this wheel would show, at rest on level ground") for w in WHEELS),
    ParameterSpec("drag_area_m2", "Drag area", "m²", 2, meaning="drag coefficient times frontal area, in the drive's air"),
    *(ParameterSpec(f"tire_normal_force_{w}_n", f"Tyre normal force {w}", "N", 0, meaning=
        "between tyre and road: the mean while the vehicle stands, or over the drive where it never does") for w in WHEELS),
]  # fmt: skip

PARAMETERS: dict[str, ParameterSpec] = {spec.name: spec for spec in _TABLE}


def is_positive(name: str) -> bool:
    """Whether a parameter is above nought in every vehicle."""
    return name in PARAMETERS and PARAMETERS[name].positive


def spread_text(std: float) -> str:
    """A standard deviation as tables print it: two figures, thousands apart by a narrow no-break space from 10 000 on."""
    if not (math.isfinite(std) and std > 0):
        return f"{std:g}"
    decimals = 1 - int(f"{std:.1e}".partition("e")[2])  # of the rounded one: 0.0998 is 0.10
    rounded = round(std, decimals)
    thousands = "," if rounded >= 1e4 else ""
    return f"{rounded:{thousands}.{max(decimals, 0)}f}".replace(",", "\u202f")
