"""A vehicle fitted for suspension mapping: struts, ride heights, inertial unit, speed, and wheel-force transducers."""

from __future__ import annotations

from parsers.signals import WHEELS
from pipelines.simulation.sensors import parts
from pipelines.simulation.sensors.errors import SensorModel
from pipelines.simulation.sensors.truth import Mount
from pipelines.simulation.sensors.units import SensorUnit

STRUT_SCALES = dict(zip(WHEELS, (-0.005, 0.006, 0.002, -0.004), strict=True))
WHEEL_SCALES = dict(zip(WHEELS, (0.004, -0.003, 0.005, -0.002), strict=True))
"""Scale errors that stay with an instrument: the same ones in every drive, as in one vehicle that was fitted out once."""


def strut_cells() -> SensorUnit:
    """Strain gauges on the struts: zeros drift with temperature from drive to drive, scales hardly."""
    return SensorUnit(
        "struts",
        100.0,
        tuple(
            SensorModel(
                f"suspension_force_{w}", noise=15.0, offset_std=12.0, scale_error=STRUT_SCALES[w], scale_std=0.001,
                lowpass_hz=35.0, outlier=2000.0,
            )
            for w in WHEELS
        ),
    )  # fmt: skip


def wheel_transducers() -> SensorUnit:
    """Measuring wheels, set to zero before each drive; the slip ring's zero wanders over minutes."""
    return SensorUnit(
        "wheel_force",
        100.0,
        tuple(
            SensorModel(
                f"tire_normal_force_{w}", noise=30.0, offset_std=12.0, scale_error=WHEEL_SCALES[w], scale_std=0.001,
                wander=8.0, wander_s=120.0, lowpass_hz=35.0, outlier=2000.0,
            )
            for w in WHEELS
        ),
    )  # fmt: skip


def units(mount: Mount) -> tuple[SensorUnit, ...]:
    """All of it."""
    return (
        parts.production_imu(mount), parts.wheels(), strut_cells(), parts.deflections(), wheel_transducers()
    )  # fmt: skip
