"""Signals as every method takes them: what the vehicle file says of sensors is put right, whoever reads the drive."""

from __future__ import annotations

from parsers.drive import Drive
from pipelines.prepare.deflection_zero import less_their_zeros
from pipelines.prepare.force_units import forces_in_newtons
from pipelines.prepare.level_unit import with_level_unit
from pipelines.prepare.spring_forces import at_the_wheels
from pipelines.vehicles.vehicle import Vehicle


def put_right(drive: Drive, vehicle: Vehicle, *, fix: bool) -> tuple[Drive, Vehicle]:
    """The inertial unit turned level, deflections less their zeros, springs' forces as forces at the wheels, in newtons.

    fix: whether signals may be put right by what the drive itself shows. The vehicle is the one whose deflections are now nought when it
    is empty. What was done is in the drive's record.
    """
    drive = with_level_unit(drive, vehicle, fix=fix)
    drive, vehicle = less_their_zeros(drive, vehicle)
    return forces_in_newtons(at_the_wheels(drive, vehicle), vehicle, fix=fix), vehicle
