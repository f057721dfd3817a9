"""Where the plant's kernels find their parameters, states and results: indices, and the packing of a vehicle."""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.plant.body import PlantVehicle
from pipelines.simulation.records import GRAVITY

AIR_DENSITY = 1.2

# --- states, one vector of STATES: place, body, wheels, driver -------------------------------------------------------
X, Y, HEADING, HEIGHT, ROLL, PITCH = 0, 1, 2, 3, 4, 5
VX, VY, VZ = 6, 7, 8
P, Q, R = 9, 10, 11
DEFLECTION, DEFLECTION_RATE, SPIN, U_X, U_Y, DRY = 12, 16, 20, 24, 28, 32
STEER, DRIVE, PRESSURE, INTEGRAL, DISTANCE, ALTITUDE, DRIVER_STEER, HEADING_ERROR = (
    36,
    37,
    38,
    39,
    40,
    41,
    42,
    43,
)
STATES = 44

# --- the whole vehicle, one vector of BODY_SIZE -----------------------------------------------------------------------
MASS, IXX, IYY, IZZ, IXZ, DRAG, RATIO, STEER_LAG, GAIN, POWER = range(10)
(
    WHEELBASE,
    HALF_TRACK_SHARE,
    SLIP_LIMIT,
    TOTAL_MASS,
    UNDERSTEER,
    RADIUS,
    KNEE,
    BLOW_OFF,
    BUMP_AT,
    REBOUND_AT,
) = range(10, 20)
BUMP_RATE, STIFFENING, DRY_FORCE, DRY_TRAVEL, TIRE_DAMPING, LOSS_STIFFNESS = range(20, 26)
LOSS_FRICTION, FRICTION, SLIDING_LOSS, SIGMA_X, SIGMA_Y, ROLLING, STIFFNESS_X, CAMBER = range(26, 34)
FOLLOW, DRY_ON, ROAD_ON, CG_BEHIND, DRIVEN_LOAD, SPIN_MASS, PATCH_GIVE, WIND_X, WIND_Y = range(34, 43)
BODY_SIZE = 43

# --- a wheel, one row of WHEEL_SIZE: places and paths from the sprung CG in body axes --------------------------------
FOOT_X, FOOT_Y, FOOT_Z, FOOT_PATH_X, FOOT_PATH_Y, UNSPRUNG = range(6)
HUB_X, HUB_Y, HUB_Z, HUB_PATH_X, HUB_PATH_Y, SPRING, PRELOAD, BAR, COMPRESSION, EXTENSION = range(6, 16)
TIRE, FREE_RADIUS, WHEEL_INERTIA, STIFFNESS_Y, NOMINAL, CAMBER_RATE, BRAKE_SHARE, DRIVE_SHARE = range(16, 24)
BRAKE_TURN, PATH_CURVE, SIDE_CURVE = 24, 25, 26
"""PATH_CURVE: growth of FOOT_PATH_Y and HUB_PATH_Y, a metre of deflection; SIDE_CURVE: of FOOT_PATH_X and HUB_PATH_X."""
WHEEL_SIZE = 27

# --- what the equations give beside the derivatives (W_STEER: the tangent of a wheel's angle) ----------------------------------------------------------------------
FORCE_X, FORCE_Y, FORCE_Z, ALPHA_X, ALPHA_Y, ALPHA_Z = range(6)
UP_X, UP_Y, UP_Z, WHEEL_ANGLE, GRADE, BANK, CG_VX, CG_VY = range(6, 14)
W_STEER, W_FORCE, W_NORMAL, W_LONG, W_LAT, W_SPRUNG, W_UNSPRUNG, W_BRAKE, W_DRIVE, W_ROAD = range(14, 54, 4)
AUX_SIZE = 54

# --- columns of the packed demand and road --------------------------------------------------------------------------------
D_STEER, D_TARGET, D_BRAKE, D_DRIVE, D_SLOPE = range(5)
R_CURVATURE, R_GRADE, R_BANK, R_LEFT, R_RIGHT, R_GRIP_LEFT, R_GRIP_RIGHT = range(7)


def pack(vehicle: PlantVehicle) -> tuple[FloatArray, FloatArray]:
    """The vehicle's body vector (BODY_SIZE,) and wheel rows (4, WHEEL_SIZE) for the kernels."""
    return _body(vehicle), _wheels(vehicle)


def _body(v: PlantVehicle) -> FloatArray:
    body = np.zeros(BODY_SIZE)
    preload = v.preloads_n
    loads = [preload[i] + v.unsprung_masses_kg[i] * GRAVITY for i in range(4)]
    driven = sum(loads[:2]) * (v.drive_front_share > 0) + sum(loads[2:]) * (v.drive_front_share < 1)
    spin = 2 * v.wheel_inertia_front_kgm2 / v.wheel_radius_front_m**2
    spin += 2 * v.wheel_inertia_rear_kgm2 / v.wheel_radius_rear_m**2
    entries = {
        MASS: v.sprung_mass_kg,
        IXX: v.sprung_roll_inertia_kgm2,
        IYY: v.sprung_pitch_inertia_kgm2,
        IZZ: v.sprung_yaw_inertia_kgm2,
        IXZ: v.sprung_product_xz_kgm2,
        DRAG: 0.5 * AIR_DENSITY * v.drag_area_m2,
        RATIO: v.steering_ratio,
        STEER_LAG: v.steering_lag_s,
        GAIN: v.brake_gain_nmppa,
        POWER: v.power_w,
        WHEELBASE: v.wheelbase_m,
        HALF_TRACK_SHARE: v.track_front_m / (2 * v.wheelbase_m),
        SLIP_LIMIT: v.slip_limit,
        TOTAL_MASS: v.mass_kg,
        UNDERSTEER: v.understeer_radps2pm,
        RADIUS: v.wheel_radius_m,
        KNEE: v.damper_knee_mps,
        BLOW_OFF: v.damper_blow_off,
        BUMP_AT: v.bump_clearance_m,
        REBOUND_AT: v.rebound_clearance_m,
        BUMP_RATE: v.bump_rate_npm,
        STIFFENING: v.spring_stiffening_pm2,
        DRY_FORCE: v.friction_n,
        DRY_TRAVEL: v.friction_travel_m,
        TIRE_DAMPING: v.tire_damping_nspm,
        LOSS_STIFFNESS: v.stiffness_load_sensitivity,
        LOSS_FRICTION: v.friction_load_sensitivity,
        FRICTION: v.friction_scale,
        SLIDING_LOSS: v.sliding_loss,
        SIGMA_X: v.relaxation_longitudinal_m,
        SIGMA_Y: v.relaxation_lateral_m,
        ROLLING: v.rolling_resistance,
        STIFFNESS_X: v.longitudinal_stiffness_prad,
        CAMBER: v.camber_stiffness_prad,
        DRY_ON: 1.0,
        ROAD_ON: 1.0,
        CG_BEHIND: v.sprung_cg_behind_front_axle_m,
        DRIVEN_LOAD: driven,
        SPIN_MASS: spin,
        PATCH_GIVE: v.patch_give,
    }
    for index, value in entries.items():
        body[index] = value
    return body


def _wheels(v: PlantVehicle) -> FloatArray:
    wheels = np.zeros((4, WHEEL_SIZE))
    preload, unsprung = v.preloads_n, v.unsprung_masses_kg
    # a tyre's nominal load is the empty vehicle's, whatever rides in it
    weight = (sum(preload) + sum(unsprung) * GRAVITY) / 4
    for i in range(4):
        front, side = i < 2, 1.0 if i % 2 == 0 else -1.0

        def pick(a: float, b: float, front: bool = front) -> float:
            return a if front else b

        half = pick(v.track_front_m, v.track_rear_m) / 2
        radius = pick(v.wheel_radius_front_m, v.wheel_radius_rear_m)
        tire = pick(v.tire_vertical_rate_front_npm, v.tire_vertical_rate_rear_npm)
        load = preload[i] + unsprung[i] * GRAVITY
        camber = pick(v.camber_compensation_front, v.camber_compensation_rear) / half
        center = pick(v.roll_center_height_front_m, v.roll_center_height_rear_m)
        drive_slope = pick(v.side_slope_drive_front, v.side_slope_drive_rear)
        turn = (drive_slope - pick(v.side_slope_front, v.side_slope_rear)) / radius
        brake_share = pick(v.brake_front_share, 1 - v.brake_front_share)
        drive_share = pick(v.drive_front_share, 1 - v.drive_front_share)
        foot_x = v.sprung_cg_behind_front_axle_m - pick(0.0, v.wheelbase_m)
        foot_z = -v.sprung_cg_height_m - load / tire
        foot_path_y = side * center / half
        bar = pick(v.anti_roll_stiffness_front_nmprad, v.anti_roll_stiffness_rear_nmprad)
        entries = {
            FOOT_X: foot_x,
            FOOT_Y: side * half - v.sprung_cg_left_m,
            FOOT_Z: foot_z,
            FOOT_PATH_X: drive_slope,
            FOOT_PATH_Y: foot_path_y,
            UNSPRUNG: unsprung[i],
            HUB_X: foot_x,
            HUB_Y: side * half - v.sprung_cg_left_m,
            HUB_Z: foot_z + radius,
            HUB_PATH_X: drive_slope,
            HUB_PATH_Y: foot_path_y - side * camber * radius,
            SPRING: pick(v.spring_rate_front_npm, v.spring_rate_rear_npm),
            PRELOAD: preload[i],
            BAR: bar / (2 * half) ** 2,
            COMPRESSION: pick(v.damper_compression_front_nspm, v.damper_compression_rear_nspm),
            EXTENSION: pick(v.damper_extension_front_nspm, v.damper_extension_rear_nspm),
            TIRE: tire,
            FREE_RADIUS: radius,
            WHEEL_INERTIA: pick(v.wheel_inertia_front_kgm2, v.wheel_inertia_rear_kgm2),
            STIFFNESS_Y: pick(v.cornering_stiffness_front_prad, v.cornering_stiffness_rear_prad),
            NOMINAL: weight,
            CAMBER_RATE: side * camber,
            BRAKE_SHARE: 0.5 * brake_share,
            DRIVE_SHARE: 0.5 * drive_share,
            # a roll centre at h is a path of slope h over half the track; one that comes down with the body flattens it
            PATH_CURVE: -side * pick(v.roll_center_drop_front, v.roll_center_drop_rear) / half,
            BRAKE_TURN: turn,
            # a carrier that turns about a pole in the body turns its path along
            SIDE_CURVE: v.pole_follow * turn,
        }
        for index, value in entries.items():
            wheels[i, index] = value
    return wheels


def spins_at(wheels: FloatArray, speed_mps: float) -> FloatArray:
    """(4,) wheel spins [rad/s] that roll at a speed under the static load."""
    squash = (wheels[:, PRELOAD] + wheels[:, UNSPRUNG] * GRAVITY) / wheels[:, TIRE]
    return np.asarray(speed_mps / (wheels[:, FREE_RADIUS] - squash / 3))
