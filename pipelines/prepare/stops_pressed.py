"""Wheels that are pressed into bump stops of which the vehicle file says where they begin: what they hold there no file knows.

A stop's force rises with travel as its foam does: from a tenth of the spring's rate to six of it within a centimetre. The balances have one
coefficient of one curve for it, which heights and arms then follow: with exact sensors and an exact file arms of a blind author's
simulator came out 4 to 14 % too large where a wheel was in its stop for a fifth of the drive and more, and heights 3 to 5 %.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.checks.grid import make_grid
from parsers.checks.motion import smooth, vehicle_speed
from parsers.drive import Decision, Drive
from parsers.signals import WHEEL_SPEEDS, WHEELS
from pipelines.joint.kept import KeptRelations
from pipelines.prepare.decided import decided
from pipelines.results import ParameterEstimate
from pipelines.vehicles.kinematics import AXLES, share_beyond, stop_places
from pipelines.vehicles.vehicle import Vehicle
from pipelines.verdict.widened import by_share

MAKES = {"cg_height_m": 0.015, "sprung_cg_height_m": 0.015, "roll_arm_m": 0.03, "pitch_arm_m": 0.035}
"""Share of each that stops make unsure where wheels are in them for OFTEN of the time; in proportion for less, and nothing from SELDOM on down."""
OFTEN, SELDOM = 0.2, 0.1
MOVES = 1.0
"""m/s."""


@dataclass(frozen=True)
class StopsPressed:
    """share: of the drive in which a wheel is in its stop."""

    share: float

    @property
    def found(self) -> str:
        """The sentence for the reader."""
        return f"wheels are pressed into their bump stops for {self.share:.0%} of the drive"

    @property
    def _strength(self) -> float:
        return min(self.share / OFTEN, 1.0)

    def widened(self, verdict: Mapping[str, ParameterEstimate]) -> dict[str, ParameterEstimate]:
        """The verdict, where heights and arms are no surer than what stops hold."""
        words = f"{self.found}, whose force no file tells"
        return {
            name: by_share(entry, MAKES[name] * self._strength, words) if name in MAKES else entry
            for name, entry in verdict.items()
        }

    def kept(self, kept: KeptRelations | None) -> KeptRelations | None:
        """What a drive leaves for others to be joined with, no surer either."""
        if kept is None:
            return None
        for name, share in MAKES.items():
            kept = kept.less_sure((name,), share * self._strength)
        return kept


def stops_pressed(drive: Drive, vehicle: Vehicle) -> StopsPressed | None:
    """None where the file does not say where stops begin, or they are hardly touched. drive: deflections from where the empty vehicle stands."""
    places = stop_places(vehicle)
    if places is None:
        return None
    wheels = {w: places[axle] for axle in AXLES for w in WHEELS if w[0] == axle[0] and axle in places}
    names = {w: f"suspension_deflection_{w}" for w in wheels}
    names = {w: name for w, name in names.items() if name in drive.signals}
    taken = ("speed", *WHEEL_SPEEDS, *names.values())
    grid = make_grid(
        {n: drive.signals[n] for n in taken if n in drive.signals and len(drive.signals[n].values)}
    )
    columns = {w: smooth(grid.columns[name]) for w, name in names.items() if name in grid.columns}
    if not columns:
        return None
    speed = vehicle_speed(grid)
    rows = np.all(np.isfinite(list(columns.values())), axis=0)
    if speed is not None:
        rows &= np.abs(speed) > MOVES
    if not rows.any():
        return None
    share = share_beyond({w: column[rows] for w, column in columns.items()}, {w: wheels[w] for w in columns})
    return StopsPressed(share) if share >= SELDOM else None


def with_stops_said(drive: Drive, pressed: StopsPressed | None) -> Drive:
    """The drive with what was found in its record."""
    if pressed is None:
        return drive
    action = "said: heights and arms hold what a stop's unknown force may make of them"
    return decided(
        drive,
        [
            Decision(
                "",
                "choice",
                pressed.found,
                action,
                "bump_stop_clearance_* of the vehicle file",
                applied=False,
            )
        ],
    )
