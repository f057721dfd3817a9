"""The parameters that cogest estimates: names, units, and how they are printed."""

from __future__ import annotations

from dataclasses import dataclass

from parsers.signals import WHEELS


@dataclass(frozen=True)
class ParameterSpec:
    """name as in results.json; symbol for tables; unit as printed; digits after the point; positive by nature."""

    name: str
    title: str
    unit: str
    digits: int
    positive: bool = True


_TABLE: list[ParameterSpec] = [
    ParameterSpec("cg_height_m", "CG height above ground", "m", 3),
    ParameterSpec("mass_kg", "Mass", "kg", 0),
    ParameterSpec("sprung_mass_kg", "Sprung mass", "kg", 0),
    ParameterSpec("sprung_cg_height_m", "Sprung mass CG height above ground", "m", 3),
    ParameterSpec("cg_to_front_axle_m", "CG to front axle", "m", 3),
    ParameterSpec("cg_lateral_offset_m", "CG lateral offset (+ left)", "m", 3, positive=False),
    ParameterSpec(
        "roll_center_height_m", "Roll axis height above ground, under the CG", "m", 3, positive=False
    ),
    ParameterSpec("roll_arm_m", "Sprung CG height above roll axis", "m", 3),
    ParameterSpec("pitch_arm_m", "Sprung CG height above pitch axis", "m", 3),
    ParameterSpec("roll_gradient_degpg", "Roll gradient", "deg/g", 2),
    ParameterSpec("roll_natural_frequency_hz", "Roll natural frequency (undamped)", "Hz", 2),
    ParameterSpec("roll_damping_ratio", "Roll damping ratio", "–", 2),
    ParameterSpec("roll_stiffness_nmprad", "Roll stiffness", "N·m/rad", 0),
    ParameterSpec("roll_damping_nmsprad", "Roll damping", "N·m·s/rad", 0),
    ParameterSpec("roll_inertia_kgm2", "Roll inertia", "kg·m²", 0),
    ParameterSpec("pitch_inertia_kgm2", "Pitch inertia", "kg·m²", 0),
    ParameterSpec("suspension_damping_nspm", "Suspension damping (a wheel)", "N·s/m", 0),
    *(ParameterSpec(f"corner_mass_{w}_kg", f"Corner mass {w}", "kg", 0) for w in WHEELS),
    ParameterSpec("drag_area_m2", "Drag area", "m²", 2),
    *(ParameterSpec(f"tire_normal_force_{w}_n", f"Tyre normal force {w}", "N", 0) for w in WHEELS),
]

PARAMETERS: dict[str, ParameterSpec] = {spec.name: spec for spec in _TABLE}
