"""What a drive's signals say against each other before any estimator is asked, and what that leaves of the answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from parsers.drive import Drive
from pipelines.joint.kept import KeptRelations
from pipelines.prepare.angle_scale import (
    AngleDoubt,
    angle_doubts,
    as_sure_as_angles,
    estimates_as_sure,
    kept_as_sure_as_angles,
    with_angle_doubts,
)
from pipelines.prepare.deflection_zero import with_zero_open
from pipelines.prepare.gravity import with_gravity
from pipelines.prepare.lateral_scale import HANG_ON_IT, lateral_doubt, left_without_gravity, wrong_weight
from pipelines.prepare.load_change import LoadStep
from pipelines.prepare.load_step import load_step, with_load_step
from pipelines.prepare.longitudinal_scale import hanging_along, longitudinal_doubt
from pipelines.prepare.put_right import put_right
from pipelines.prepare.scale_doubt import ScaleDoubt, as_sure_as_the_scale, kept_as_sure, with_doubt
from pipelines.prepare.steered import steered
from pipelines.prepare.stops_pressed import StopsPressed, stops_pressed, with_stops_said
from pipelines.prepare.track_by_wheels import STIFFNESS, hanging_on_it, track_doubt
from pipelines.results import Estimate, JointVerdict, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle
from pipelines.verdict.combine import Verdict
from pipelines.verdict.two_loads import holding_both_loads, taught_with_both_loads


@dataclass(frozen=True)
class DriveDoubts:
    """Of the scales of lateral and longitudinal acceleration and of angles, a load that changes on the way, stops that are pressed, and the
    file's track; None, or nothing, where the drive gives no cause. vehicle: as the answers are told with. by_track: what goes by that."""

    vehicle: Vehicle
    lateral: ScaleDoubt | None
    along: ScaleDoubt | None
    angles: tuple[AngleDoubt, ...]
    step: LoadStep | None
    pressed: StopsPressed | None
    track: ScaleDoubt | None = None
    by_track: tuple[str, ...] = ()

    def verdict(self, whole: Verdict, results: Sequence[Estimate]) -> dict[str, ParameterEstimate]:
        """Its parameters, no surer than the drive is."""
        sure = as_sure_as_the_scale(whole.parameters, self.lateral, HANG_ON_IT)
        sure = as_sure_as_the_scale(sure, self.along, self._hanging(whole, results))
        for doubt, names in self._of_track():
            sure = as_sure_as_the_scale(sure, doubt, names)
        sure = as_sure_as_angles(sure, self.angles)
        sure = sure if self.pressed is None else self.pressed.widened(sure)
        return holding_both_loads(sure, self.step, self.vehicle)

    def estimates(self, results: Sequence[Estimate]) -> list[Estimate]:
        """The estimators' own answers, likewise; what predicts is code, and no result."""
        return estimates_as_sure([replace(estimate, evidence=()) for estimate in results], self.angles)

    def joint(self, whole: Verdict, told: Mapping[str, ParameterEstimate]) -> JointVerdict | None:
        """What the drive taught. told: the verdict as `verdict` has it."""
        return taught_with_both_loads(whole.joint, self.step, told)

    def kept(self, whole: Verdict, results: Sequence[Estimate]) -> KeptRelations | None:
        """What is left for a vehicle's other drives to be joined with: relations of two loads are of no state that could be."""
        if self.step is not None:
            return None
        kept = kept_as_sure(whole.kept, self.lateral, HANG_ON_IT)
        kept = kept_as_sure(kept, self.along, self._hanging(whole, results))
        for doubt, names in self._of_track():
            kept = kept_as_sure(kept, doubt, names)
        kept = kept_as_sure_as_angles(kept, self.angles, whole.parameters)
        return kept if self.pressed is None else self.pressed.kept(kept)

    def _of_track(self) -> tuple[tuple[ScaleDoubt, tuple[str, ...]], ...]:
        """What a wrong track is in, and in what twice."""
        if self.track is None:
            return ()
        return (self.track, self.by_track), (replace(self.track, off=2 * self.track.off), STIFFNESS)

    def _hanging(self, whole: Verdict, results: Sequence[Estimate]) -> tuple[str, ...]:
        """Parameters that longitudinal acceleration brought."""
        return hanging_along(results, whole.joint, whole.parameters)


def made_ready(drive: Drive, vehicle: Vehicle, *, fix: bool) -> tuple[Drive, DriveDoubts]:
    """The drive as the estimators take it, with what was found in its record, and what it leaves open; fix: whether signals may be put right."""
    drive, vehicle = put_right(drive, vehicle, fix=fix)
    lateral, angles = lateral_doubt(drive, vehicle) or wrong_weight(drive), angle_doubts(drive)
    along, track = longitudinal_doubt(drive), track_doubt(drive, vehicle)
    drive = with_doubt(with_doubt(drive, along), track)
    drive = with_gravity(drive, vehicle, fix=fix, known={"accel_y"} if lateral else frozenset())
    drive, vehicle = steered(with_angle_doubts(with_doubt(drive, lateral), angles), vehicle)
    lateral = lateral or left_without_gravity(drive)
    step, pressed = load_step(drive, vehicle), stops_pressed(drive, vehicle)
    drive, vehicle = with_zero_open(with_stops_said(with_load_step(drive, step), pressed), vehicle)
    return drive, DriveDoubts(
        vehicle, lateral, along, tuple(angles), step, pressed, track, hanging_on_it(drive)
    )
