"""Where the tyres' patches and the hubs go as the body rolls, pitches, brakes and corners: the weight and the hubs' inertia go along."""

from __future__ import annotations

import numpy as np

from pipelines.joint.vehicle.book import AXLES, SILENT, Book
from pipelines.models.axle_load import patch_shift
from pipelines.models.roll import GRAVITY
from pipelines.vehicles.spring_base import rigid_axle
from pipelines.vehicles.usual import usual_tyre_rate


def _patch_paths(book: Book) -> None:
    """What an axle's load takes off its roll stiffness, over that load, m a rad: as a rig found it, in place of what geometry says."""
    stated = {axle: book.vehicle.get(f"patch_path_{axle}_mprad") for axle in AXLES}
    book.put("paths_told", float(all(path is not None for path in stated.values())), 0.0)
    for axle, path in stated.items():
        if path is None:
            book.put(f"path_{axle}", 0.0, 0.0)
        else:
            book.put(f"path_{axle}", path.value, path.std, f"patch_path_{axle}_mprad", path.source)


PATCH_FOLLOWS = (1.0, 0.15)
"""Share of a tyre's sideways give by which its vertical force goes along, and how sure that is: crowned treads stay a little behind."""
ROLLING_SIDE_RATE = 0.65
"""A rolling tyre's sideways rate over its vertical one, where nobody says: two thirds."""
USUAL_GIVE = {False: (0.55, 0.55), True: (0.8, 0.4)}
"""Share of that give by which loads go along, where nobody says: a third to all of it on a vehicle, and none in most simulators; by whether
the log is of a vehicle for sure."""
LEAST_GIVE = 0.1
"""Of what tyres usually give: no rig tells a patch's place better."""


def _sideways_give(book: Book) -> None:
    """m that the patches of a wheel go sideways a m/s² of lateral acceleration, all wheels alike."""
    quarter = 0.25 * book.rows["empty_mass"][0]
    usual = quarter / (ROLLING_SIDE_RATE * book.rows["tyre_rate"][0])
    rate = book.vehicle.get("tire_lateral_rate_npm")
    if rate is None:
        share, unsure = USUAL_GIVE[book.vehicle.real]
        book.put("patch_side", share * usual, unsure * usual)
        return
    give, (share, unsure) = quarter / rate.value, PATCH_FOLLOWS
    spread = float(np.hypot(np.hypot(share * rate.std / rate.value, unsure) * give, LEAST_GIVE * usual))
    book.put(
        "patch_side", share * give, spread, "patches sideways by tire_lateral_rate_npm, m a m/s²", rate.source
    )


STANDING = {False: (0.8, 0.5), True: (0.4, 0.4)}
"""Of a standing tyre's sideways rate what resists that its wheel goes up, by the way it then goes sideways: by whether the axle is
rigid, whose wheels go straight up on the road, if not in every simulator."""
HARDEST = 2.0
"""Times the usual vertical rate: no tyre is harder."""
USUAL_SIDE_RATE = 0.5
"""A tyre's sideways rate over its vertical one, where nobody says; no tyre is stiffer sideways than upright."""


def _standing(book: Book) -> None:
    """N/m of a tyre by which a vehicle that stands is held where it is sideways."""
    rate = book.vehicle.get("tire_lateral_rate_npm")
    # tyres that are stated not to give (1e9) hold a standing vehicle no harder than real ones
    upright = min(book.rows["tyre_rate"][0], HARDEST * usual_tyre_rate(book.vehicle)[0])
    usual = USUAL_SIDE_RATE * upright if rate is None else min(rate.value, upright)
    for axle in AXLES:
        share, spread = STANDING[rigid_axle(book.vehicle, axle)]
        book.put(f"standing_{axle}", share * usual, spread * usual)


PITCH_PATH = {False: (0.6, 0.6), True: (1.0, 0.2)}
"""Height about which the body pitches over its wheels, in their radii. Round wheels that stay over their patches: one, less or more by what
the links carry; feet that are points of the body: 0; a model without gravity's part in pitching: the CG's height. By whether the log is of
a vehicle for sure."""


def _pitch_path(book: Book) -> None:
    """Height about which the body pitches over its wheels, m: how far their loads go along a rad of pitch."""
    stated = book.vehicle.get("patch_path_pitch_mprad")
    if stated is not None:
        book.put("pitch_path", stated.value, stated.std, "patch_path_pitch_mprad", stated.source)
        return
    radius = book.rows["radius"][0]
    share, unsure = PITCH_PATH[book.vehicle.real]
    book.put(
        "pitch_path",
        share * radius,
        unsure * radius,
        "height about which the body pitches over its wheels, m",
        SILENT,
    )


def _lean_path(book: Book) -> None:
    """m above the roll axis about which weight does not tip a leaning body. 0 is physics; some models know no such weight (`doubts`)."""
    book.put("lean_path", 0.0, 0.01)


LAG_FOLLOWS = (1.0, 0.15)
"""Share of a tyre's give along by which its vertical force goes along, and how sure that is."""


USUAL_LAG = {False: (0.5, 1 / 3), True: (2 / 3, 0.2)}
"""The same over a tyre's squash, where nobody says: two thirds of it where no power comes from nowhere, nothing in simulators whose torque
is force on the loaded radius; by whether the log is of a vehicle for sure."""


def _patch_lag(book: Book) -> None:
    """m of height that braked tyres' patches, which lag behind their axles, seem to add to the CG; driven ones run ahead.

    A patch that gives F / k under a wheel's load W takes the moment W F / k of all four: that of W / k more height.
    """
    mass, rate = (book.vehicle.get(key) for key in ("mass_kg", "tire_vertical_rate_npm"))
    along = book.vehicle.get("tire_longitudinal_rate_npm")
    if along is not None:
        give = 0.25 * GRAVITY * book.rows["empty_mass"][0] / along.value
        share, unsure = LAG_FOLLOWS
        spread = float(np.hypot(share * along.std / along.value, unsure)) * give
        book.put(
            "patch_lag",
            share * give,
            spread,
            "patches along by tire_longitudinal_rate_npm, m a g",
            along.source,
        )
        return
    squash = 3 * patch_shift(mass.value if mass else None, rate.value if rate else None)[0]
    share, unsure = USUAL_LAG[book.vehicle.real]
    book.put("patch_lag", share * squash, unsure * squash)


HUB_LOW = (2 / 3, 1 / 3)
"""How much lower than the radius on which a wheel rolls its centre stands, over its tyre's squash: a belt does not shorten as it is
squashed, and rolls on a third of the squash less than its free radius. Files (and simulators) that state the free radius, or that height, are one spread off."""
MOST_SQUASH = 0.2
"""Of its radius: no tyre is squashed by more, whatever rate a file states."""


def hub_low(book: Book) -> tuple[float, float]:
    """m that wheel centres stand below the rolling radius, and how sure that is."""
    squash = 0.25 * GRAVITY * book.rows["empty_mass"][0] / book.rows["tyre_rate"][0]
    squash = min(squash, MOST_SQUASH * book.rows["radius"][0])
    share, unsure = HUB_LOW
    return share * squash, unsure * squash


def _hubs(book: Book) -> None:
    """What part of the braked hubs' inertia their links take past the springs (`poles.past_the_springs`), over the hubs' height."""
    stated = [book.vehicle.get(f"wheel_recession_{axle}") for axle in AXLES]
    front, rear = stated
    if front is None or rear is None:
        # braking hubs lean on their side-view swing arms: half the wheelbase over an arm's length of what they carry at hub height
        # goes past the springs. Long arms of front axles 0.1 to 0.3, parallel links none, short arms that point at the middle all
        book.put("hubs_past", 0.1, 0.25)
        return
    weights = [book.rows[f"unsprung_{axle}"][0] for axle in AXLES]
    ahead = book.rows["empty_x"][0]
    levers = [weights[0] * ahead, -weights[1] * (book.rows["wheelbase"][0] - ahead)]
    # hubs push forward along the way that their links let them go: anti-dive that a rising wheel's way back undoes
    centre = -(levers[0] * front.value + levers[1] * rear.value) / sum(weights)
    spread = float(np.hypot(levers[0] * front.std, levers[1] * rear.std)) / sum(weights)
    height = book.rows["radius"][0] - hub_low(book)[0]
    carried = book.rows["pitch_center_brake"][0] - centre
    book.put(
        "hubs_past",
        carried / height,
        spread / height,
        "hubs past the springs by wheel_recession_front and _rear, a share",
        front.source,
    )


def feet(book: Book) -> None:
    """The paths of patches and hubs. Roll and pitch centres are in the book."""
    _patch_paths(book)
    _pitch_path(book)
    _lean_path(book)
    _patch_lag(book)
    _sideways_give(book)
    _standing(book)
    _hubs(book)
