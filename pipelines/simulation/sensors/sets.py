"""The sensor sets that a simulated vehicle can carry: one line each, name -> title and units."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import replace

from parsers.errors import SettingsError
from pipelines.simulation.sensors import parts as parts
from pipelines.simulation.sensors import wheel_force
from pipelines.simulation.sensors.errors import SensorModel
from pipelines.simulation.sensors.truth import Fit, Mount
from pipelines.simulation.sensors.units import SensorSet, SensorUnit

DEFAULT_MOUNT = Mount(1.3, 0.0, 0.5)
"""On the floor, near the CG of a car."""

PERFECT_HZ = 100.0
Units = Callable[[Mount], tuple[SensorUnit, ...]]


def _imu(mount: Mount) -> tuple[SensorUnit, ...]:
    wheels = parts.wheels()
    speed = tuple(s for s in wheels.sensors if s.signal == "speed")
    return (parts.production_imu(mount), replace(wheels, sensors=speed))


def _production(mount: Mount) -> tuple[SensorUnit, ...]:
    return (parts.production_imu(mount), parts.wheels(), parts.driver(), parts.torques(), parts.gps(1.0))


def _deflection(mount: Mount) -> tuple[SensorUnit, ...]:
    return (*_production(mount), parts.deflections())


def _ins(mount: Mount) -> tuple[SensorUnit, ...]:
    return (parts.ins(mount), parts.wheels(), parts.driver(), parts.torques(), parts.gps(10.0))


def _axle_load(mount: Mount) -> tuple[SensorUnit, ...]:
    return (
        parts.production_imu(mount),
        parts.wheels(),
        parts.driver(),
        parts.torques(0.02),
        parts.axle_loads(("rear",)),
        parts.grade_sensor(),
    )


def _vertical(_: Mount) -> tuple[SensorUnit, ...]:
    speed = SensorUnit(
        "wheels", 50.0, (SensorModel("speed", noise=0.02, step=0.01, low=0.0, zero_below=0.3),)
    )
    return (parts.vertical_accelerometers(), speed)


def _struts(mount: Mount) -> tuple[SensorUnit, ...]:
    forces = parts.forces()
    struts = replace(
        forces, sensors=tuple(s for s in forces.sensors if s.signal.startswith("suspension_force"))
    )
    vertical = parts.vertical_accelerometers()
    body = replace(vertical, sensors=tuple(s for s in vertical.sensors if "_sprung_" in s.signal))
    return (parts.production_imu(mount), parts.wheels(), parts.driver(), parts.deflections(), struts, body)


def _everything(mount: Mount) -> tuple[SensorUnit, ...]:
    return (
        *_ins(mount),
        parts.deflections(),
        parts.forces(),
        parts.wheel_torques(),
        parts.axle_loads(("front", "rear")),
        parts.vertical_accelerometers(),
        parts.grade_sensor(),
    )


def _perfect(mount: Mount) -> tuple[SensorUnit, ...]:
    return tuple(
        SensorUnit(
            unit.name,
            PERFECT_HZ,
            tuple(SensorModel(sensor.signal) for sensor in unit.sensors),
            None if unit.mount is None else replace(unit.mount, misalignment_std_rad=0.0),
        )
        for unit in _everything(mount)
    )


SENSOR_SETS: Mapping[str, tuple[str, Units]] = {
    "deflection": ("production CAN signals and four ride height sensors", _deflection),
    "production": ("CAN only: 6 axes, wheel speeds, steering, pressure, torques, GPS at 1 Hz", _production),
    "imu": ("6 axes and the vehicle's speed, nothing else", _imu),
    "ins": ("navigation unit with roll and pitch, wheel speeds, pressure, torques, GPS at 10 Hz", _ins),
    "axle_load": ("a truck's rear axle load and road slope beside its CAN signals (Wu)", _axle_load),
    "vertical": ("accelerometers on body and hub at each wheel, 200 Hz (Pence)", _vertical),
    "struts": (
        "strut forces, accelerometers and ride heights at each corner beside CAN (gPC dissertation)",
        _struts,
    ),
    "wheel_force": (
        "struts, ride heights, 6 axes, speeds, and measuring wheels (suspension mapping)",
        wheel_force.units,
    ),
    "everything": ("every canonical signal, each with the errors of its kind", _everything),
    "perfect": ("every canonical signal without any error, at 100 Hz", _perfect),
}


def sensor_set(name: str, mount: Mount = DEFAULT_MOUNT, fit: Fit | None = None) -> SensorSet:
    """A named set. mount: of the inertial unit. Raises SettingsError for an unknown name, naming the nearest."""
    if name not in SENSOR_SETS:
        near = difflib.get_close_matches(name, SENSOR_SETS, n=1, cutoff=0.5)
        raise SettingsError(
            f"there is no sensor set {name!r}",
            hint=f"did you mean {near[0]!r}?" if near else f"known are {', '.join(SENSOR_SETS)}",
            wrong_usage=True,
        )
    title, units = SENSOR_SETS[name]
    return SensorSet(name, title, units(mount), fit or Fit())
