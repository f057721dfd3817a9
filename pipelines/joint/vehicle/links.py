"""What the suspension's links carry past the springs: roll and pitch centres, and how they lift the body; inertias beside."""

from __future__ import annotations

import numpy as np

from pipelines.joint.vehicle.book import AXLES, Book
from pipelines.joint.vehicle.feet import feet
from pipelines.joint.vehicle.suspension import levels
from pipelines.models.roll import GRAVITY
from pipelines.vehicles.priors import measured_pitch_inertia, measured_roll_inertia
from pipelines.vehicles.spring_base import rigid_axle
from pipelines.vehicles.usual import usual_camber, usual_roll_center

PITCH_CENTER = {False: (0.15, 0.08), True: (0.18, 0.1)}
"""m above ground, where the vehicle file has no pitch_center_height_m: 20 to 40 % of anti-dive in front and 20 to 60 % of anti-lift behind;
more with a rigid rear axle, whose brakes turn against leaf springs or links. None at all is a doubt of its own (`doubts`)."""

RIGID_DRIVEN = (0.3, 0.2)
"""m above ground, where the file has no pitch_center_height_drive_m, of a driven rigid axle: its torque turns against leaf springs or links
of half a metre, which carry 0.4 to 0.7 m; simple models have none."""


FRONT_DRIVEN = (0.02, 0.06)
"""m above ground, where the file has no pitch_center_height_drive_m, of a car whose front wheels are driven through shafts: links see the force
at the hub, whose way leans back (-0.05 to 0.05 m) where that of the tyre's foot, which brakes, leans forward; simple models have one height for both."""


def drive_jacking(book: Book) -> tuple[float, float]:
    """Drop of the springs' force over the driving force: mean and spread.

    Links that carry `pitch_center_drive` of pitch moment at one axle do it by lifting the body there: over that axle's distance
    from the CG. A driven rigid axle's lift is a quarter of the driving force. With both axles driven it is unsure which lifts.
    """
    front, front_std = book.rows["drive_front"]
    ahead = book.rows["empty_x"][0]
    behind = book.rows["wheelbase"][0] - ahead
    height, std = book.rows["pitch_center_drive"]
    lever = (1 - front) / behind - front / ahead
    unsure = (0.03, std * lever, height * front_std * (1 / behind + 1 / ahead), 0.2 * front * (1 - front))
    return height * lever, float(np.linalg.norm(unsure))


def side_jacking(book: Book) -> tuple[float, float]:
    """Lift of the body in bends over its mass, a (m/s²)² across, s²/m: mean and spread.

    The outer tyres take more of the side force, W (a/g)² 2 h/t of an axle's load W if forces go with loads, and the links
    to a roll centre at h_rc stand h_rc / (t/2) steep: 4 h h_rc / (g t²). How forces really go with loads, and how roll
    centres move as the body rises, make about half of it unsure.
    """
    track = 0.5 * (book.rows["track_front"][0] + book.rows["track_rear"][0])
    axis = 0.5 * (book.rows["roll_center_front"][0] + book.rows["roll_center_rear"][0])
    mean = 4 * book.rows["empty_h"][0] * max(axis, 0.0) / (GRAVITY * track**2)
    return mean, 0.004 + 0.5 * mean


def bend_jacking(book: Book) -> tuple[float, float]:
    """Pitch moment of what the links lift in bends, over the body's mass, a (m/s²)² across, s²: mean and spread.

    Each axle's links lift their share of the body by 4 h h_rc / (g t²) as in `side_jacking`, ahead of its CG and behind
    it: roll centres that are higher at the rear lift the tail.
    """
    length, ahead = book.rows["wheelbase"][0], book.rows["empty_x"][0]
    lifts, spreads = [], []
    for axle in AXLES:
        centre, std = book.rows[f"roll_center_{axle}"]
        a_metre = 4 * book.rows["empty_h"][0] / (GRAVITY * book.rows[f"track_{axle}"][0] ** 2)
        lifts.append(a_metre * max(centre, 0.0))
        spreads.append(float(np.hypot(0.004 + 0.5 * lifts[-1], a_metre * std)))
    lever = ahead * (length - ahead) / length
    return lever * (lifts[0] - lifts[1]), lever * float(np.linalg.norm(spreads))


SHAFT_ARM = 0.1
"""m: a wheel's radius over the final drive's ratio."""


def _shaft_roll(book: Book) -> float:
    """Spread of the roll moment that a propeller shaft puts between body and rear axle, over the driving force, m.

    The engine turns the body as the pinion turns a live axle the other way; which way depends on the engine. A differential on the
    body keeps it to itself.
    """
    live = rigid_axle(book.vehicle, "rear")
    front, std = book.rows["drive_front"]
    return SHAFT_ARM * min(1 - front + std, 1.0) if live else 0.0


def _roll_links(book: Book) -> None:
    """Roll centres, and what load and lean make of them."""
    for axle in AXLES:
        usual = usual_roll_center(book.vehicle, axle, rigid_axle(book.vehicle, axle))
        book.quantity(f"roll_center_{axle}", f"roll_center_height_{axle}_m", *usual)
    # under load wheels stand further apart by what roll centres at a constant height make of it; those that sink make less
    book.put("track_grows", 0.8, 0.4)
    _sinking(book)
    # wheels that go sideways with their travel take the weight on them along, against the springs (`laden.side_moment`): all of
    # it where travel is the wheel's own (1), less than none where an axle's springs sit above its roll centre, none in a model of
    # a body that turns about an axis
    book.put("side_path", 0.6, 0.5)
    # feet that stay in the planes of wheels which do not lean with the body: 1 of thin discs, less of wide tyres, none in models
    # whose feet are below the hubs
    book.put("wheel_plane", 0.2, 0.4)


USUAL_SINKING = (0.8, 0.55)
"""Of a roll centre, over the body's: struts 1 to 1.8, wishbones 0.5 to 1, beam axles and most simulators none."""


def _sinking(book: Book) -> None:
    """How far roll centres come down for a metre that the body does: of each axle as stated, else as usual of both."""
    stated = [book.vehicle.get(f"roll_center_drop_{axle}") for axle in AXLES]
    levelled = [levels(book.vehicle, axle) for axle in AXLES]
    if any(levelled) or all(drop is not None for drop in stated):
        book.put("axis_sinks", 0.0, 0.0)
    else:
        said = "how far roll centres sink for a metre that a load presses the springs"
        book.put("axis_sinks", *USUAL_SINKING, said)
    for axle, drop, stays in zip(AXLES, stated, levelled, strict=True):
        if stays:
            # a load does not bring it down
            book.put(f"sinks_{axle}", 0.0, 0.0)
        elif drop is None and any(levelled):
            book.put(
                f"sinks_{axle}",
                *USUAL_SINKING,
                f"how far the {axle} roll centre sinks for a metre that a load presses its springs",
            )
        elif drop is None:
            book.put(f"sinks_{axle}", 0.0, 0.0)
        else:
            book.put(f"sinks_{axle}", drop.value, drop.std, f"roll_center_drop_{axle}", drop.source)


def _pitch_links(book: Book) -> None:
    """Pitch centres in braking and in driving."""
    vehicle = book.vehicle
    stated = vehicle.get("pitch_center_height_m")
    mean, std = PITCH_CENTER[rigid_axle(vehicle, "rear")] if stated is None else (stated.value, stated.std)
    source = "the vehicle file is silent: usual for road vehicles" if stated is None else stated.source
    book.put(
        "pitch_center_brake", mean, std, "pitch_center_height_m (links' part in braking: anti-dive)", source
    )
    driven = vehicle.get("pitch_center_height_drive_m")
    if driven is not None:
        mean, std, source = driven.value, driven.std, driven.source
    elif (share := vehicle.get("drive_front_share")) is not None and share.value > 0.9:
        mean, std = FRONT_DRIVEN
        source = "what the links of a front axle that is driven through shafts carry"
    elif rigid_axle(vehicle, "rear"):
        # its links hold the torque that drives its wheels, where a differential on the body keeps it from them
        mean, std = RIGID_DRIVEN
        source = "what the links or leaf springs of a driven rigid axle carry"
    else:
        mean, std, source = 0.1, 0.11, "some to all of what a driven rear axle's links may carry"
    book.put("pitch_center_drive", mean, std, "pitch_center_height_drive_m (anti-squat)", source)


def links(book: Book) -> None:
    """What the links carry: roll centres, pitch centre, jacking."""
    vehicle = book.vehicle
    _roll_links(book)
    _pitch_links(book)
    # 1: the wheels stay upright, as those of a rigid axle; independent ones lean with the body in part, and their couples
    # (inertia of the hubs, gyroscopes) then go into the springs in that part
    camber = vehicle.get("camber_compensation")
    if camber is None:
        book.put("camber", *usual_camber(vehicle, rigid_axle(vehicle, "rear")))
    else:
        # a rig's figure is that about rest: it changes with travel and steering
        book.put("camber", camber.value, max(camber.std, 0.05), "camber_compensation", camber.source)
    share = vehicle.get("drive_front_share")
    book.put("drive_front", *((0.5, 0.5) if share is None else (share.value, share.std)))
    book.put("shaft_roll", 0.0, _shaft_roll(book))
    feet(book)
    book.put("jack_brake", 0.0, 0.04)
    book.put("jack_drive", *drive_jacking(book))
    book.put("jack_side", *side_jacking(book))
    book.put("jack_bend", *bend_jacking(book))


def inertias(book: Book, kilos: float) -> None:
    """Roll and pitch inertia of the empty vehicle of so many kilograms."""
    vehicle = book.vehicle
    roll = measured_roll_inertia(kilos, book.rows["track_front"][0])
    length = vehicle.get("wheelbase_m")
    pitch = measured_pitch_inertia(kilos, None if length is None else length.value)
    # beyond the measured vehicles: they go by the size
    wide, long = (
        0.15 * book.rows["track_front"][0] ** 2 * kilos,
        0.22 * book.rows["wheelbase"][0] ** 2 * kilos,
    )
    book.quantity(
        "roll_inertia", "roll_inertia_kgm2", *((roll.value, roll.std) if roll else (wide, 0.3 * wide))
    )
    book.quantity(
        "pitch_inertia", "pitch_inertia_kgm2", *((pitch.value, pitch.std) if pitch else (long, 0.3 * long))
    )
    for name in ("roll_inertia", "pitch_inertia"):
        # of the empty whole vehicle: what the load adds follows from its unknowns (`body_inertias`), but for its own shape
        mean, std = book.rows[name]
        book.put(name, mean, float(np.hypot(std, 0.03 * mean)))
