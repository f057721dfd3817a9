"""The vehicle file's wheel radius, as the importers take it for wheel speeds that are logged as turn rates."""

from __future__ import annotations

from parsers.mapping import WheelRadius
from pipelines.vehicles.vehicle import Vehicle


def wheel_radius(vehicle: Vehicle | None) -> WheelRadius | None:
    """None where no file, or a silent one, is at hand."""
    radius = vehicle.get("wheel_radius_m") if vehicle is not None else None
    if vehicle is None or radius is None:
        return None
    return WheelRadius(radius.value, radius.value, vehicle.path.name if vehicle.path else "the vehicle file")
