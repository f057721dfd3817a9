"""The units that sensor sets are made of, with the error sizes of their kind of instrument.

Sizes are data-sheet figures of the class of device, not of one product. The constant offsets of the series-production
inertial unit are of the size that Park & Choi name: about 0.1 m/s² and 0.004 rad/s.
"""

from __future__ import annotations

from parsers.signals import WHEELS
from pipelines.simulation.sensors.errors import SensorModel
from pipelines.simulation.sensors.truth import Mount
from pipelines.simulation.sensors.units import SensorUnit

DEG = 0.017453292519943295
ACCELS = ("accel_x", "accel_y", "accel_z")
RATES = ("roll_rate", "pitch_rate", "yaw_rate")


def production_imu(mount: Mount) -> SensorUnit:
    """Six axes as a stability control has them: filtered, quantised, 10 ms old, askew by about 0.7°."""
    common = {"scale_std": 0.005, "lowpass_hz": 15.0, "delay_s": 0.01}
    accels = (
        SensorModel(
            name,
            noise=0.05,
            offset_std=0.08,
            step=0.01,
            low=-40.0,
            high=40.0,
            wander=0.005,
            outlier=10.0,
            **common,
        )
        for name in ACCELS
    )
    rates = (
        SensorModel(
            name,
            noise=0.003,
            offset_std=0.0035,
            step=0.0005,
            low=-3.5,
            high=3.5,
            wander=0.0003,
            outlier=1.0,
            **common,
        )
        for name in RATES
    )
    return SensorUnit("imu", 100.0, (*accels, *rates), _askew(mount, 0.7 * DEG))


def ins(mount: Mount) -> SensorUnit:
    """A navigation unit with roll and pitch angles: calibrated, fixed with care."""
    common = {"scale_std": 0.001, "lowpass_hz": 40.0}
    accels = (
        SensorModel(name, noise=0.03, offset_std=0.02, wander=0.003, outlier=10.0, **common)
        for name in ACCELS
    )
    rates = (
        SensorModel(name, noise=0.0015, offset_std=0.0005, wander=0.0001, outlier=1.0, **common)
        for name in RATES
    )
    angles = (
        SensorModel(name, noise=0.0004, offset_std=0.001, wander=0.0005, outlier=0.1, delay_s=0.005)
        for name in ("roll", "pitch")
    )
    return SensorUnit("ins", 100.0, (*accels, *rates, *angles), _askew(mount, 0.3 * DEG))


def _askew(mount: Mount, std: float) -> Mount:
    return Mount(mount.behind_front_axle_m, mount.left_m, mount.above_ground_m, mount.misalignment_rad, std)


def gps(rate_hz: float) -> SensorUnit:
    """A satellite receiver: 0.15 s late, its position wandering by metres, lost now and then."""
    late = 0.15
    sensors = (
        SensorModel(
            "gps_speed_2d", noise=0.03, wander=0.02, wander_s=5.0, delay_s=late, low=0.0, outlier=2.0
        ),
        SensorModel(
            "gps_speed_3d", noise=0.05, wander=0.03, wander_s=5.0, delay_s=late, low=0.0, outlier=2.0
        ),
        SensorModel("latitude", noise=2e-7, wander=1e-5, delay_s=late, step=1e-8),
        SensorModel("longitude", noise=3e-7, wander=1.5e-5, delay_s=late, step=1e-8),
        SensorModel("altitude", noise=0.05, wander=2.0, wander_s=120.0, delay_s=late, step=0.01),
        SensorModel("satellites", wander=1.2, wander_s=30.0, step=1.0, low=0.0, delay_s=late),
        SensorModel("hdop", wander=0.08, wander_s=30.0, step=0.1, low=0.5, delay_s=late),
    )
    return SensorUnit("gps", rate_hz, sensors, dropouts_per_s=0.003, dropout_s=3.0)


def wheels() -> SensorUnit:
    """Wheel speeds from the brake control, with a radius error each, zero at a crawl; the vehicle speed from them."""
    each = (
        SensorModel(
            f"wheel_speed_{w}",
            noise=0.02,
            scale_std=0.003,
            delay_s=0.01,
            step=0.01,
            low=0.0,
            zero_below=0.3,
            outlier=5.0,
        )
        for w in WHEELS
    )
    speed = SensorModel(
        "speed", noise=0.02, scale_std=0.004, delay_s=0.02, step=0.01, low=0.0, zero_below=0.3, outlier=5.0
    )
    return SensorUnit("wheels", 50.0, (*each, speed))


def driver() -> SensorUnit:
    """Steering-wheel angle and brake pressure."""
    return SensorUnit(
        "driver",
        100.0,
        (
            SensorModel(
                "steering_wheel_angle",
                noise=0.001,
                offset_std=0.01,
                step=0.1 * DEG,
                delay_s=0.01,
                outlier=1.0,
            ),
            SensorModel("brake_pressure", noise=1e4, offset_std=2e4, scale_std=0.01, step=1e4, outlier=1e6),
        ),
    )


def torques(scale_std: float = 0.04) -> SensorUnit:
    """Torques as the engine and the brake control estimate them: smooth, off by some per cent."""
    kinds = ("brake_torque", "drive_torque")
    return SensorUnit(
        "torque",
        50.0,
        tuple(
            SensorModel(
                name, noise=8.0, offset_std=10.0, scale_std=scale_std, delay_s=0.02, step=1.0, outlier=500.0
            )
            for name in kinds
        ),
    )


def wheel_torques() -> SensorUnit:
    """Torque at each wheel by a measuring wheel."""
    return SensorUnit(
        "wheel_torque",
        100.0,
        tuple(
            SensorModel(f"{kind}_{w}", noise=4.0, offset_std=3.0, scale_std=0.005, outlier=200.0)
            for kind in ("brake_torque", "drive_torque")
            for w in WHEELS
        ),
    )


def deflections() -> SensorUnit:
    """Ride height sensors: compression at the wheel, each with a zero of its own."""
    return SensorUnit(
        "suspension",
        100.0,
        tuple(
            SensorModel(
                f"suspension_deflection_{w}",
                noise=2e-4,
                offset_std=1e-3,
                scale_std=0.01,
                step=1e-4,
                lowpass_hz=30.0,
                outlier=0.02,
            )
            for w in WHEELS
        ),
    )


def forces() -> SensorUnit:
    """Suspension force by strain gauges, normal force by measuring wheels."""
    kinds = (("suspension_force", 25.0, 30.0), ("tire_normal_force", 40.0, 40.0))
    return SensorUnit(
        "forces",
        100.0,
        tuple(
            SensorModel(
                f"{kind}_{w}",
                noise=noise,
                offset_std=offset,
                scale_std=0.007,
                lowpass_hz=35.0,
                outlier=2000.0,
            )
            for kind, noise, offset in kinds
            for w in WHEELS
        ),
    )


def axle_loads(axles: tuple[str, ...], noise: float = 100.0) -> SensorUnit:
    """Axle load sensors."""
    return SensorUnit(
        "axle_load",
        50.0,
        tuple(
            SensorModel(
                f"axle_load_{axle}", noise=noise, offset_std=100.0, scale_std=0.005, low=0.0, outlier=3000.0
            )
            for axle in axles
        ),
    )


def vertical_accelerometers() -> SensorUnit:
    """Accelerometers on the body over each wheel and on each hub, at 200 Hz."""
    sprung = (
        SensorModel(
            f"accel_z_sprung_{w}", noise=0.08, offset_std=0.05, scale_std=0.005, lowpass_hz=60.0, outlier=10.0
        )
        for w in WHEELS
    )
    unsprung = (
        SensorModel(
            f"accel_z_unsprung_{w}",
            noise=0.37,
            offset_std=0.1,
            scale_std=0.005,
            lowpass_hz=60.0,
            outlier=50.0,
        )
        for w in WHEELS
    )
    return SensorUnit("vertical", 200.0, (*sprung, *unsprung))


def grade_sensor() -> SensorUnit:
    """Slope of the road as a map or an inclinometer with a filter gives it."""
    return SensorUnit(
        "grade", 20.0, (SensorModel("road_grade", noise=0.001, offset_std=0.002, wander=0.001, delay_s=0.05),)
    )
