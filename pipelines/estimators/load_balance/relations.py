"""The balances: each a sum of columns times coefficients of the unknowns that should be zero, and its instruments.

Sprung body, in body axes (specific force f, so that grade and bank drop out), S the suspension's vertical forces:

    vertical  sum S = m_s f_z - jacking
    pitch     a S_f - b S_r = -(m (h - h_links) - past) f_x - g pitch (m_u R + m_s h_path) - 4 I_w v'/R - h_D D - I_yy q'
              - m_s j_bend f_y²
    roll      sum y S + sum W h_rc lean = -(m_s (h_s - h_rc) + m_u R (1 - camber)) f_y - 4 I_w (1 - camber) v r / R + I_xx p'
              + y_s m_s f_z + ((h_rcf - h_rcr) I_zz / L - I_xz) r' - m s_shaft f_x (driving)

Where one axle's deflections are there alone, its springs against all that loads it: b (vertical) + (pitch) with b the lever of the
other axle, whose forces drop out (front; a (vertical) - (pitch) for the rear one).

The longitudinal balance is in `along`.

y: half the track, widened by a load (`laden`); W h_rc lean: the weight that the feet's sideways paths carry aside.

Tyre forces or axle loads in S's place see the whole vehicle: no links, no roll centre. m, h: whole vehicle. past: the part of
the hubs' inertia that their links take past the springs (`past_the_springs`). j_bend: what links lift in bends, more at the axle
with the higher roll centre.

A balance is divided by what its S scales with, so that nothing is won by letting stiffness and mass shrink together.
Its mean products with instruments (accelerations, speed: signals without the deflection sensors' noise and without
friction) are what must vanish, so that noise in the deflections biases nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipelines.estimators.load_balance.data import Columns
from pipelines.estimators.load_balance.forces import (
    FORCES,
    Terms,
    add,
    add_shafts,
    add_swing,
    air_pressure,
    by_side_path,
    stiffness_of,
)
from pipelines.estimators.load_balance.specific_force import forward, sideways, upward
from pipelines.joint.vehicle.body import body_inertias, hub_height
from pipelines.joint.vehicle.laden import axis_lever, patch_lag, side_patches, widened
from pipelines.joint.vehicle.poles import dip_levers, past_the_springs, pitch_centres
from pipelines.joint.vehicle.unknowns import AXLES, BY_SPRINGS, TOWED, Body, Known, Values, body_of
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray

IntArray = NDArray[np.int64]
WHOLE = ("tyre", "axle")
"""Carriers that see the whole vehicle, and not the body on its springs."""
EVENLY = (1.0, 1.0, 1.0, 1.0)
YAW_OVER_PITCH = 1.08
"""Yaw inertia of a car over its pitch inertia, give or take a twentieth."""

Coefficients = Callable[[Values], Terms]


@dataclass(frozen=True)
class Relation:
    """One balance. columns: names; table (n, k) and instruments (n, z) on the used rows `rows` of the drive.

    unknowns: rows of those that the coefficients depend on.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    table: FloatArray
    instruments: FloatArray
    instrument_names: tuple[str, ...]
    rows: IntArray
    block: IntArray
    coefficients: Coefficients
    unknowns: tuple[int, ...]

    def vector(self, p: Values) -> FloatArray:
        """(k,) coefficients of the columns; (k, n) where the values are (n,) of many vehicles."""
        terms = self.coefficients(p)
        return np.array(np.broadcast_arrays(*(terms[name] for name in self.columns)))


def scaled(terms: Terms, by: float) -> Terms:
    """All coefficients over one figure."""
    return {name: value / by for name, value in terms.items()}


def _lengthwise(p: Values, body: Body, whole: bool) -> list[float]:
    """The wheels' levers about the CG, + in front of it."""
    a = body.whole_x if whole else body.x
    return [a, a, a - p["wheelbase"], a - p["wheelbase"]]


def pitch_moments(kind: str, p: Values, body: Body) -> Terms:
    """The pitch balance of one vehicle, N m."""
    whole = kind in WHOLE
    lever, terms = _lengthwise(p, body, whole), Terms()
    FORCES[kind](p, lever, terms)
    gain = 1 + p[f"gain_pitch_{kind}"]
    # tyre loads and axle loads see the patches' lag as well: `behind_the_axles` takes it from their heights
    links, past = (0.0, 0.0), 0.0
    springs = p[BY_SPRINGS] if kind == "axle" else 1.0
    if kind == "axle" or not whole:
        braking, driving = pitch_centres(p, body)
        lag = patch_lag(p)
        links = (springs * (braking - lag), springs * (driving - lag))
        past = springs * past_the_springs(p)
    towed = p[TOWED] * p["hitch"]
    brake, drive = (
        gain * (body.moment + pull - body.mass * link - past)
        for link, pull in zip(links, (towed * p["pushes"], towed), strict=True)
    )
    # drag passes the tyres by, and rolling resistance is no brake's
    pressure = air_pressure(p) * p["drag"]
    add(terms, "on_rolling", -(links[0] - links[1]) * p["rolling"] * body.mass * GRAVITY)
    add(terms, "v2_on", -(links[0] - links[1]) * pressure)
    # an engine that holds back while the brakes are on does so through the shafts: by its torque, or by what is usual
    add_shafts(terms, gain * (links[0] - links[1]), p, body)
    mean = 0.5 * (brake + drive)
    forward(p, body, mean, terms, (brake, drive))
    add(terms, "dfx", -mean * p[f"late_pitch_{kind}"])
    if not whole:
        for name, lever_m in zip(("dip_brake", "dip_drive"), dip_levers(p, body), strict=True):
            add(terms, name, -gain * body.mass * lever_m)
    path = p["unsprung_front"] + p["unsprung_rear"]
    add(terms, "fx_tilt", path * hub_height(p) + body.sprung * p["pitch_path"])
    add(terms, "vdot", 4 * p["wheel_inertia"] / p["radius"])
    lift = lever[0] * p["lift_front"] + lever[2] * p["lift_rear"]
    add(terms, "v2", pressure * (p["drag_height"] - links[1]) + air_pressure(p) * (0.0 if whole else lift))
    add_swing(terms, "pitch", body_inertias(p)[1] * (1 + p["swing_pitch"]), p)
    add(terms, "yaw2", p["product"])
    # the steered wheels' side force holds the car back (see `along`): it is in f_x, but no torque that links would carry
    add(terms, "yaw2", -links[1] * body.mass * (p["wheelbase"] - body.whole_x))
    if kind == "axle" or not whole:
        add(terms, "fy2", body.sprung * p["jack_bend"] * (p[BY_SPRINGS] if kind == "axle" else 1.0))
        add(terms, "one", p["pitch_bias"])
        add(terms, "rest", p["pitch_wound"])
    add(terms, "move", p["rolling_shift"] * body.mass * GRAVITY * p["rolling"] * p["radius"])
    return terms


def pitch_terms(kind: str, known: Known, sag: float | None) -> Coefficients:
    """The pitch balance."""
    first, whole = known.at(np.zeros(len(known.names))), kind in WHOLE
    nominal = stiffness_of(kind, first, _lengthwise(first, body_of(first, sag), whole), bars=False)

    def coefficients(p: Values) -> Terms:
        body = body_of(p, sag)
        stiffness = stiffness_of(kind, p, _lengthwise(p, body, whole), bars=False)
        return scaled(pitch_moments(kind, p, body), stiffness / nominal)

    return coefficients


def _shaft(known: Known) -> bool:
    """Whether a propeller shaft may turn a live axle against the body."""
    return bool(known.std[known.index("shaft_roll")] > 1e-6)


def _by_shaft(p: Values, body: Body, amount: float, terms: Terms) -> None:
    """Adds amount * driving force: what accelerates, and what overcomes air and tyres. The springs hold what the shaft turns."""
    pressure, rolling = air_pressure(p) * p["drag"], p["rolling"] * body.mass * GRAVITY
    add(terms, "fx_drive", amount * body.mass)
    add(terms, "v2", amount * pressure)
    add(terms, "v2_on", -amount * pressure)
    add(terms, "move", amount * rolling)
    add(terms, "on_rolling", -amount * rolling)


def roll_terms(kind: str, known: Known, sag: float | None) -> Coefficients:
    """The roll balance."""
    first = known.at(np.zeros(len(known.names)))
    whole, shaft = kind == "tyre", _shaft(known)

    def levers(p: Values) -> list[float]:
        front, rear = (p[f"track_{axle}"] / 2 * widened(p, axle) for axle in AXLES)
        if kind == "suspension":
            front, rear = front * p["force_base_front"], rear * p["force_base_rear"]
        return [front, -front, rear, -rear]

    nominal = stiffness_of(kind, first, levers(first), bars=True)

    def coefficients(p: Values) -> Terms:
        body = body_of(p, sag)
        lever, terms = levers(p), Terms()
        FORCES[kind](p, lever, terms)
        share = body.whole_x / p["wheelbase"]
        axis = axis_lever(p, share)
        if not whole:
            by_side_path(p, body, kind, terms)
        gain = 1 + p[f"gain_roll_{kind}"]
        # the hubs' couples go into the springs as far as the wheels lean with the body; the tyres see all of them
        lean = 1.0 if whole else 1 - p["camber"]
        patches = lean * side_patches(p, body)
        hubs = body.unsprung * hub_height(p) * lean
        arm = gain * ((body.moment if whole else body.sprung * (body.h - axis) + hubs) + patches)
        inertia = body_inertias(p)[0] * (1 + p["swing_roll"])
        late = p[f"late_roll_{kind}"]
        sideways(p, body, arm, terms)
        # one unit is as late with its gyros as with its accelerometers; the square is 5 % of the inertia at 20 ms
        add(terms, "dfy", -arm * late)
        add(terms, "ddfy", 0.5 * arm * late**2)
        add_swing(terms, "roll", -inertia, p)
        add(terms, "droll_acc", inertia * late)
        # turning into a bend loads the front axle first: its links stand lower or higher than the mean of both
        split = 0.0 if whole else (p["roll_center_front"] - p["roll_center_rear"]) / p["wheelbase"]
        add(terms, "yaw_acc", -split * p["pitch_inertia"] * YAW_OVER_PITCH - p["product"])
        if shaft and not whole:
            _by_shaft(p, body, gain * p["shaft_roll"], terms)
        if whole:
            add(terms, "fy_tilt", body.unsprung * hub_height(p) + body.sprung * (axis + p["lean_path"]))
        add(terms, "vyaw", 4 * lean * p["wheel_inertia"] / p["radius"])
        mass, left = (body.mass, body.whole_y) if whole else (body.sprung, body.y)
        add(terms, "fz", -mass * left)
        return scaled(terms, stiffness_of(kind, p, lever, bars=True) / nominal)

    return coefficients


def vertical_forces(kind: str, p: Values, body: Body) -> Terms:
    """The vertical balance of one vehicle, N."""
    whole, terms = kind in WHOLE, Terms()
    FORCES[kind](p, EVENLY, terms)
    mass = body.mass if whole else body.sprung
    upward(p, body, -mass, terms)
    # at rest weight is weight: only what moves can be wrong in the model
    add(terms, "fz_dynamic", -mass * p[f"gain_vertical_{kind}"])
    add(terms, "dfz", mass * p[f"late_vertical_{kind}"])
    if kind == "axle" or not whole:
        # axle loads by springs lack what the links lift, as deflections do
        lifted = body.sprung * (p[BY_SPRINGS] if kind == "axle" else 1.0)
        add(terms, "fx_brake", lifted * p["jack_brake"])
        add(terms, "fx_drive", lifted * p["jack_drive"])
        add_shafts(terms, lifted / body.mass * (p["jack_drive"] - p["jack_brake"]), p, body)
        add(terms, "fy2", lifted * p["jack_side"])
    add(terms, "v2", air_pressure(p) * (p["lift_front"] + p["lift_rear"]))
    return terms


def vertical_terms(kind: str, known: Known, sag: float | None) -> Coefficients:
    """The vertical balance."""
    nominal = stiffness_of(kind, known.at(np.zeros(len(known.names))), EVENLY, bars=False)

    def coefficients(p: Values) -> Terms:
        stiffness = stiffness_of(kind, p, EVENLY, bars=False)
        return scaled(vertical_forces(kind, p, body_of(p, sag)), stiffness / nominal)

    return coefficients


def one_axle_terms(axle: str, known: Known) -> Coefficients:
    """Moments about the other axle: the springs of one axle against all that loads it. The other's forces drop out.

    Of the vertical balance times that axle's lever, and the pitch balance.
    """
    first, i = known.at(np.zeros(len(known.names))), 0 if axle == "front" else 2
    lever = [1.0 if wheel in (i, i + 1) else 0.0 for wheel in range(4)]
    nominal = stiffness_of("deflection", first, lever, bars=False)

    def coefficients(p: Values) -> Terms:
        body = body_of(p, None)
        behind, sign = (p["wheelbase"] - body.x, 1.0) if axle == "front" else (body.x, -1.0)
        terms = Terms()
        for part, by in (
            (pitch_moments("deflection", p, body), sign),
            (vertical_forces("deflection", p, body), behind),
        ):
            for name, value in part.items():
                add(terms, name, by * value)
        return scaled(terms, stiffness_of("deflection", p, lever, bars=False) / nominal)

    return coefficients


def _unknowns(terms: Coefficients, known: Known, columns: Sequence[str]) -> tuple[int, ...]:
    """Rows of the unknowns that change the coefficient of any of the columns, tried away from the mean, where products are not zero.

    A column that the drive lacks (a drive torque that is not in the log) shows nothing of what its coefficient holds.
    """
    # not all alike: front and rear often have one prior, and their difference would be none
    u = np.linspace(0.2, 0.6, len(known.names))

    def own(u: FloatArray) -> list[float]:
        found = terms(known.at(u))
        return [found[name] for name in columns]

    base = own(u)
    found = []
    for i in range(len(u)):
        moved = u.copy()
        moved[i] += 0.1
        if own(moved) != base:
            found.append(i)
    return tuple(found)


def make_relation(
    name: str,
    title: str,
    data: Columns,
    extra: dict[str, FloatArray],
    terms: Coefficients,
    instruments: Sequence[str],
    where: FloatArray,
    known: Known,
    least_s: float = 20.0,
) -> Relation | None:
    """Table and instruments on the rows where all of them are there; None where nearly nothing is."""
    at = known.at(np.zeros(len(known.names)))
    pool = {**data.columns, **extra}
    used = tuple(n for n in terms(at) if n in pool and np.isfinite(pool[n]).any())
    named = [n for n in instruments if n in pool and np.isfinite(pool[n]).any()]
    if not named:
        return None
    z = np.column_stack([pool[n] for n in named])
    table = np.column_stack([pool[n] for n in used])
    good = np.isfinite(table).all(axis=1) & np.isfinite(z).all(axis=1) & (where > 0)
    if good.sum() < least_s * data.rate_hz:
        return None
    z = z[good]
    size = np.sqrt(np.mean(z * z, axis=0))
    keep = size > 1e-9
    if not keep.any():
        # a vehicle that never moved shows nothing of what its motion would
        return None
    return Relation(
        name, title, used, table[good], z[:, keep] / size[keep],
        tuple(n for n, k in zip(named, keep, strict=True) if k), np.flatnonzero(good).astype(np.int64), data.block[good], terms,
        _unknowns(terms, known, used),
    )  # fmt: skip


CORNERING = 0.1
"""m/s² of lateral acceleration (rms) below which a drive is straight: what rolls it then is the road under single wheels, within
springs' dry friction, and of load transfer it shows nothing. Where the weight lies at rest, it does."""

TITLES = {
    "deflection": "spring deflections",
    "suspension": "suspension forces",
    "tyre": "tyre normal forces",
    "axle": "axle loads",
}


def relations(data: Columns, known: Known) -> tuple[Relation, ...]:
    """Every balance that the drive's signals and the vehicle file allow."""
    found: list[Relation | None] = []
    everywhere = np.ones(len(data.time_s))
    c = data.columns
    extra: dict[str, FloatArray] = {}
    if data.has("fx"):
        extra["fx_square"] = c["fx"] * np.abs(c["fx"])
    if data.has("fz"):
        extra["fz_dynamic"] = c["fz"] - GRAVITY
    else:
        # without a vertical accelerometer: gravity, on rows that are not shaken much in the mean. It is along the road's normal, and not the
        # body's as what an accelerometer reads is: nothing is to be turned
        level = np.full(len(everywhere), GRAVITY)
        data = replace(data, columns={**c, "fz": level, "fz_tilt": np.zeros_like(level)})
    names: tuple[str, ...]
    for kind in data.kinds:
        if kind == "deflection" and not known.springs:
            continue
        if data.has("fx"):
            names = ("rest", "move", "fx_brake", "fx_drive", "dfx", "ddfx", "fx_square", "v2", "fy2")
            found.append(make_relation(f"pitch by {TITLES[kind]}", f"pitch balance by {TITLES[kind]}", data, extra,
                                   pitch_terms(kind, known, data.sag), names, everywhere, known))  # fmt: skip
        if data.has("fy") and kind != "axle":
            names = ("rest", "move")
            if float(np.nanstd(c["fy"])) > CORNERING:
                shaft = ("fx_drive",) if _shaft(known) else ()
                names = (*names, "fy", "dfy", "ddfy", "fy3", "fx", "yaw_acc", *shaft)
            found.append(make_relation(f"roll by {TITLES[kind]}", f"roll balance by {TITLES[kind]}", data, extra,
                                   roll_terms(kind, known, data.sag), names, everywhere, known))  # fmt: skip
        # what comes late is also slow, and shows little of what a rough road does
        shaken = () if kind == "axle" and data.axles_late else ("fz_dynamic", "dfz", "ddfz")
        names = ("rest", "move", *shaken, "fx_brake", "fx_drive", "fy2", "v2")
        found.append(make_relation(f"vertical by {TITLES[kind]}", f"vertical balance by {TITLES[kind]}", data, extra,
                               vertical_terms(kind, known, data.sag), names, everywhere, known))  # fmt: skip
    for axle in data.one_axle if known.springs and data.has("fx") else ():
        names = ("rest", "move", "fz_dynamic", "dfz", "fx_brake", "fx_drive", "dfx", "v2", "fy2")
        found.append(make_relation(f"{axle} axle by {axle} {TITLES['deflection']}", f"load on the {axle} axle by its {TITLES['deflection']}",
                                   data, extra, one_axle_terms(axle, known), names, everywhere, known))  # fmt: skip
    return tuple(r for r in found if r is not None)
