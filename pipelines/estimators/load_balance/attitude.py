"""The pitch balance by the horizon: the nose's motion in braking and driving against springs and tyres in series.

    theta + tau theta' + rub = -C [m (h - h_links) f_x + path g theta + 4 I_w v'/R + h_D D + I_yy q'] + H m_s (f_z - g)

C: compliance of springs and tyres about the pitch axis; tau: dampers over springs; rub: dry friction with its memory; H: what
pressing the body down pitches it where axles differ. theta is against the horizon and holds the road's grade too, which
does not know when the driver brakes: every column is high-passed alike, and the instruments are changes of speed, slow
and straight ones above all, where little road passes under the wheels.
"""

from __future__ import annotations

import numpy as np

from pipelines.estimators.load_balance.data import Columns
from pipelines.estimators.load_balance.forces import Terms, add, add_shafts, air_pressure
from pipelines.estimators.load_balance.relations import Coefficients, Relation, make_relation
from pipelines.joint.vehicle.body import body_inertias, held_rate, hub_height
from pipelines.joint.vehicle.laden import patch_lag, rate_under_load
from pipelines.joint.vehicle.poles import dip_levers, past_the_springs, pitch_centres
from pipelines.joint.vehicle.unknowns import AXLES, Body, Known, Values, body_of
from pipelines.models.roll import GRAVITY


def pitch_compliance(p: Values) -> tuple[float, float]:
    """rad per N·m about the pitch axis: of the springs where the load has them rest, and of the tyres in series."""
    square = p["wheelbase"] * p["wheelbase"]
    springs = 0.5 * (1 / rate_under_load(p, "front") + 1 / rate_under_load(p, "rear")) / square
    return springs, 1 / p["tyre_rate"] / square


def tipped(p: Values, body: Body) -> float:
    """rad of nose-down pitch for each N that presses the body down at its CG: axles give way by their own rates."""
    ahead, behind = body.x, p["wheelbase"] - body.x
    given: float = behind / rate_under_load(p, "front") - ahead / rate_under_load(p, "rear")
    return 0.5 * given / p["wheelbase"] ** 2


def nod(p: Values, mode: str, sag: float | None) -> float:
    """rad of nose-down pitch on springs and tyres for 1 m/s² of f_x. mode: "brake" or "drive" (links differ)."""
    body = body_of(p, sag)
    springs, tyres = pitch_compliance(p)
    moment: float = body.moment + body.mass * patch_lag(p)
    braking, driving = pitch_centres(p, body)
    past = body.mass * (braking if mode == "brake" else driving) + past_the_springs(p)
    # links carry a moment by lifting the body at one axle: what that takes off the axles' springs is not even
    lifted = tipped(p, body) * body.sprung * p[f"jack_{mode}"]
    nose_down: float = -(springs * (moment - past) + tyres * moment) - lifted
    return nose_down


def leans(p: Values, body: Body) -> float:
    """rad of roll for 1 m/s² that the body feels sideways, on springs and tyres."""
    share = body.x / p["wheelbase"]
    axis = (1 - share) * p["roll_center_front"] + share * p["roll_center_rear"]
    springs = sum(0.5 * rate_under_load(p, a) * p[f"track_{a}"] ** 2 + p[f"bar_{a}"] for a in AXLES)
    tyres = sum(0.5 * p["tyre_rate"] * p[f"track_{a}"] ** 2 for a in AXLES)
    angle: float = body.sprung * (body.h - axis) / springs + body.moment / tyres
    return angle


def held_share(p: Values) -> float:
    """Of the pitch since the wheels last rolled, what standing tyres hold of it, over what the springs do."""
    rates = {axle: rate_under_load(p, axle) for axle in AXLES}
    whole = sum(1 / rate for rate in rates.values())
    held: float = sum(held_rate(p, axle) / (rate * rate) for axle, rate in rates.items()) / whole
    return held


def _damping_s(p: Values) -> float:
    """Dampers over springs, s: the axles' mean by their share of the pitch."""
    share = {a: 1 / p[f"spring_{a}"] for a in AXLES}
    lag = sum(share[a] * 0.5 * (p[f"bump_{a}"] + p[f"rebound_{a}"]) / p[f"spring_{a}"] for a in AXLES)
    return lag / (share["front"] + share["rear"])


def attitude_terms(sag: float | None) -> Coefficients:
    """The balance as angles: 1 for the measured pitch, so that nothing is won by shrinking stiffness and mass."""

    def coefficients(p: Values) -> Terms:
        body, terms = body_of(p, sag), Terms()
        springs, tyres = pitch_compliance(p)
        both = springs + tyres
        hubs = p["unsprung_front"] + p["unsprung_rear"]
        path = hubs * hub_height(p) + body.sprung * p["pitch_path"]
        add(terms, "tip", 1 + both * path * GRAVITY)
        # a leaning body's pitch gyro turns with the vehicle
        add(terms, "quick_turned", -(1 + both * path * GRAVITY) * leans(p, body))
        lag = _damping_s(p)
        add(terms, "dtip", lag)
        gain = 1 + p["gain_pitch_attitude"]
        for mode in ("brake", "drive"):
            add(terms, f"quick_fx_{mode}", -gain * nod(p, mode, sag))
            # of a gentle nod dry friction takes a share
            add(terms, f"stuck_{mode}", p["nod_stuck"] * nod(p, mode, sag))
        for mode, lever_m in zip(("brake", "drive"), dip_levers(p, body), strict=True):
            add(terms, f"quick_dip_{mode}", -gain * springs * body.mass * lever_m)
        add(terms, "quick_dfx", lag * tyres * body.moment - p["late_pitch_attitude"] * both * body.moment)
        add(terms, "quick_vdot", both * 4 * p["wheel_inertia"] / p["radius"])
        pressure = air_pressure(p) * p["drag"]
        braking, driving = pitch_centres(p, body)
        add(terms, "quick_v2", pressure * (both * p["drag_height"] - springs * driving))
        # drag passes the tyres by, and rolling resistance is no brake's
        apart = springs * (braking - driving)
        add(terms, "quick_v2_on", -apart * pressure)
        resistance = p["rolling"] * body.mass * GRAVITY
        add(terms, "quick_on_rolling", -apart * resistance)
        # nor are shafts that pull or hold back while the brakes are on: by their torque, or by what is usual
        lifted = tipped(p, body) * body.sprung / body.mass * (p["jack_brake"] - p["jack_drive"])
        add_shafts(terms, gain * (apart - lifted), p, body, "quick_")
        add(terms, "quick_rolls", both * p["rolling_shift"] * resistance * p["radius"])
        add(terms, "quick_pitch_acc", both * body_inertias(p)[1])
        add(terms, "quick_fz", -tipped(p, body) * body.sprung)
        # tyres that stand hold the body as it came to rest, until they have rolled: sideways by the wheels' own way, along by brakes that
        # keep the axles pushing against each other, which the links turn into pitch
        add(terms, "quick_scrub", held_share(p))
        add(terms, "quick_held", springs * body.mass * p["nod_wound"])
        rub = sum(p[f"friction_{a}"] / p[f"spring_{a}"] for a in AXLES) / p["wheelbase"]
        add(terms, "tip_stick", p["rub"] * rub * (1 - p["yielding"]))
        add(terms, "tip_yield", p["rub"] * rub * p["yielding"])
        return terms

    return coefficients


INSTRUMENTS = ("slope_on", "slope_off", "slope_square", "slope_sign", "jerk", "jolt")


def attitude_relation(data: Columns, known: Known) -> Relation | None:
    """The balance, or None where pitch, speed or the springs' rates are missing."""
    if "deflection" in data.kinds or not known.springs or not data.has("tip", "slope_on"):
        return None
    return make_relation(
        "pitch by attitude", "pitch balance by the pitch angle", data, {}, attitude_terms(data.sag), INSTRUMENTS,
        np.ones(len(data.time_s)), known,
    )  # fmt: skip
