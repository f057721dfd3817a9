"""What is said of the vehicle file among what limited a result: that it contradicts itself, has what hardly any vehicle has, or is hardly
checked by the drive."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from pipelines.joint.rests import hanging_on, moved_by
from pipelines.parameters import PARAMETERS
from pipelines.results import ParameterEstimate
from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.spring_base import spring_base
from pipelines.vehicles.unheard_of import (
    LEAST_FRONT,
    MOST_FRONT,
    TRACKS_APART,
    front_share,
    odd_axles,
    tracks_apart,
)
from pipelines.vehicles.usual import usual_unsprung
from pipelines.vehicles.vehicle import Vehicle

FILE_AGAINST_ITSELF, FILE_UNLIKE = "The vehicle file contradicts itself", "The vehicle file puts"
HANGING = "This drive hardly checks the file's"
OF_FILE = (FILE_AGAINST_ITSELF, FILE_UNLIKE, HANGING)
"""Beginnings of these sentences: words for a terminal to know them by."""

MOST_MOVED = 3
"""Answers that are named with a rate that moves them."""


def with_two_stiffnesses(vehicle: Vehicle) -> list[str]:
    """That a file's roll stiffness is not what its springs and bars make, which are used where all are there."""
    total = vehicle.get("roll_stiffness_nmprad")
    made = variance = 0.0
    for axle in ("front", "rear"):
        spring, bar = (
            vehicle.get(f"spring_rate_{axle}_npm"),
            vehicle.get(f"anti_roll_stiffness_{axle}_nmprad"),
        )
        track = spring_base(vehicle, axle)
        if total is None or spring is None or bar is None or track is None:
            return []
        lever = 0.5 * track.value**2
        made += lever * spring.value + bar.value
        variance += (lever * spring.std) ** 2 + bar.std**2
    if total is None or abs(total.value - made) < max(
        0.1 * made, 3 * math.hypot(total.std, math.sqrt(variance))
    ):
        return []
    return [
        f"{FILE_AGAINST_ITSELF}: roll_stiffness_nmprad is {total.value:.0f}, its springs and bars make {made:.0f} "
        "(½ spring rate × spring base² + bar, of both axles; the base is the track where none is given): springs and bars are used."
    ]


def unlike_any(vehicle: Vehicle) -> list[str]:
    """That a file puts more of the empty vehicle on one axle, or into it, than any such vehicle has there."""
    share, place = front_share(vehicle), vehicle.get("cg_to_front_axle_m")
    said = []
    if share is not None and place is not None:
        said.append(
            f"{FILE_UNLIKE} {share:.1%} of the empty mass on the front axle (cg_to_front_axle_m {place.value:.3f}, wheelbase_m): hardly any car, "
            f"van or pickup has less than {LEAST_FRONT:.0%} or more than {MOST_FRONT:.0%}; are those figures from the front axle, and of this vehicle?"
        )
    for axle, part in odd_axles(vehicle).items():
        usual = usual_unsprung(vehicle, axle, 1.0)[0]
        said.append(
            f"{FILE_UNLIKE} {part:.2%} of the empty mass into the {axle} axle with its wheels (unsprung_mass_{axle}_kg); "
            f"{usual:.1%} is usual of such vehicles: is that figure of both wheels, and of this vehicle?"
        )
    tracks = tracks_apart(vehicle)
    if tracks is not None:
        mean, apart = tracks
        said.append(
            f"{FILE_UNLIKE} the {'front' if apart > 0 else 'rear'} wheels {abs(apart) * mean * 1000:.0f} mm further apart than the "
            f"{'rear' if apart > 0 else 'front'} ones (track_front_m, track_rear_m): hardly any such vehicle's differ by more "
            f"than {TRACKS_APART[kind_of(vehicle)] * mean * 1000:.0f} mm; is one of them mistyped?"
        )
    return said


def unchecked(verdict: Mapping[str, ParameterEstimate]) -> list[str]:
    """Which figures of the file the answers hang on without the drive checking them: such a one, if wrong, makes them wrong unseen."""
    pieces = []
    for key, names in hanging_on(verdict).items():
        whole = [name for name in names if not name.startswith("corner_mass_")]
        titles = [_title(name) for name in whole] + (["corner masses"] if len(whole) < len(names) else [])
        pieces.append(f"{key} ({', '.join(titles)})")
    for key, moved in moved_by(verdict).items():
        unit = {name: PARAMETERS[name].unit for name in moved}
        told = [f"{_title(name)} by {by} {unit[name]}" for name, by in list(moved.items())[:MOST_MOVED]]
        pieces.append(f"{key} (10 % off would move {', '.join(told)})")
    if not pieces:
        return []
    return [f"{HANGING} {_listed(pieces)}: if one is wrong, so is what hangs on it."]


def _title(name: str) -> str:
    """A parameter within a sentence."""
    title = PARAMETERS[name].title
    return title[:1].lower() + title[1:] if title[1:2].islower() else title


def _listed(pieces: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(pieces[:-1]), pieces[-1])))
