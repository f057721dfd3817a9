"""The keys of a vehicle file: of which sign each is, and what a bare number in it is worth."""

from __future__ import annotations

from parsers.signals import WHEELS

POSITIVE = frozenset(
    [
        "mass_kg",
        "unsprung_mass_front_kg",
        "unsprung_mass_rear_kg",
        "cg_to_front_axle_m",
        "cg_height_m",
        "wheelbase_m",
        "track_front_m",
        "track_rear_m",
        "spring_base_front_m",
        "spring_base_rear_m",
        "roll_inertia_kgm2",
        "pitch_inertia_kgm2",
        "roll_stiffness_nmprad",
        "roll_damping_nmsprad",
        "spring_rate_front_npm",
        "spring_rate_rear_npm",
        "spring_rate_front_bump_npm",
        "spring_rate_front_rebound_npm",
        "spring_rate_rear_bump_npm",
        "spring_rate_rear_rebound_npm",
        "bump_stop_clearance_front_m",
        "bump_stop_clearance_rear_m",
        "damper_rate_front_nspm",
        "damper_rate_rear_nspm",
        "tire_vertical_rate_npm",
        "tire_lateral_rate_npm",
        "tire_longitudinal_rate_npm",
        "wheel_radius_m",
        "steering_ratio",
        "brake_gain_nmppa",
    ]
)
ZERO_OR_MORE = frozenset(
    [
        "anti_roll_stiffness_front_nmprad",
        "anti_roll_stiffness_rear_nmprad",
        "rolling_resistance",
        # none in simulators that leave them out
        "drag_area_m2",
        "wheel_inertia_kgm2",
    ]
)
ANY_SIGN = frozenset(
    [
        "roll_center_height_front_m",
        "roll_center_height_rear_m",
        "roll_center_drop_front",
        "roll_center_drop_rear",
        "patch_path_front_mprad",
        "patch_path_rear_mprad",
        "patch_path_pitch_mprad",
        "wheel_recession_front",
        "wheel_recession_rear",
        "pitch_center_height_m",
        "pitch_center_height_drive_m",
        "cg_lateral_offset_m",
    ]
)
RIG_SPARE = 0.1
SHARES = frozenset(["brake_front_share", "drive_front_share", "camber_compensation"])
VEHICLE_KEYS = POSITIVE | ZERO_OR_MORE | ANY_SIGN | SHARES
LOAD_ANY_SIGN = frozenset({"behind_front_axle_m", "left_m"})
LOAD_KEYS = frozenset({"mass_kg", "height_m"}) | LOAD_ANY_SIGN
TRAILER_KEYS = frozenset({"mass_kg", "drag_area_m2"})
ZERO_KEYS = tuple(f"suspension_deflection_{wheel}_m" for wheel in WHEELS)
"""What the deflection sensors show while the empty vehicle stands on level ground."""
SENSOR_KEYS = frozenset(
    {
        "imu_behind_front_axle_m",
        "imu_left_m",
        "imu_above_ground_m",
        "imu_roll_deg",
        "imu_pitch_deg",
        *ZERO_KEYS,
    }
)
TEXT_KEYS = frozenset(
    {
        "id",
        "name",
        "body",
        "suspension_map",
        "powertrain",
        "self_levelling",
        "deflection_zero",
        "axle_load_by",
        "recorded_on",
    }
)
LEVELLING = ("none", "rear", "both")
ZEROS = ("empty", "loaded")
AXLE_LOADS = ("tires", "springs")
RECORDED = ("vehicle", "simulation")

LEAST_STD = {
    "cg_lateral_offset_m": 0.005,
    "roll_center_drop_front": 0.2,
    "roll_center_drop_rear": 0.2,
    "patch_path_front_mprad": 0.03,
    "patch_path_rear_mprad": 0.03,
    "wheel_recession_front": 0.015,
    "wheel_recession_rear": 0.015,
    "imu_roll_deg": 0.2,
    "imu_pitch_deg": 0.2,
    **dict.fromkeys(ZERO_KEYS, 0.0005),
    "behind_front_axle_m": 0.1,
    "left_m": 0.05,
}
"""In the key's unit: what a bare figure of any sign is worth at least; 0.02 m where not named."""

RELATIVE_STD = {
    "mass_kg": 0.02,
    "cg_to_front_axle_m": 0.03,
    "wheelbase_m": 0.003,
    "track_front_m": 0.005,
    "track_rear_m": 0.005,
    "spring_base_front_m": 0.01,
    "spring_base_rear_m": 0.01,
    "spring_rate_front_bump_npm": 0.01,
    "spring_rate_front_rebound_npm": 0.01,
    "spring_rate_rear_bump_npm": 0.01,
    "spring_rate_rear_rebound_npm": 0.01,
    "bump_stop_clearance_front_m": 0.1,
    "bump_stop_clearance_rear_m": 0.1,
    "tire_lateral_rate_npm": 0.1,
    "tire_longitudinal_rate_npm": 0.1,
}
"""What a bare number in a vehicle file is worth: a data sheet's figure, not a calibration."""
DEFAULT_RELATIVE_STD = 0.05

LEAST_LOAD_STD_KG = 5.0
"""Of a load that is stated as a bare number: nobody weighs a jacket, and fuel is burnt."""
