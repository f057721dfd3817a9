"""What is said about a roll fit: why a drive cannot tell, what looks wrong, and what was taken as given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipelines.estimators.roll_map.answers import (
    DISCREPANCY,
    DISCREPANCY_AXLES,
    LEFT_OVER,
    LEFT_OVER_AXLES,
)
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.fit import RollFit
from pipelines.estimators.roll_map.model import BANK_TIME_S, STANDARD
from pipelines.models.roll import DEGREES, GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.roll_angle import RollSource
from pipelines.results import Assumption, ParameterEstimate


def said_of_drive(prepared: Prepared, data: RollData | None, spread: float) -> str:
    """Why this drive cannot tell."""
    if not prepared.segments:
        return "; ".join(prepared.notes) or "no stretch of the drive holds the signals that are needed"
    if data is None:
        return "the drive has no lateral acceleration to speak of: drive a slalom, lane changes or a circle at 0.3 g or more"
    if not (data.has_roll or data.has_rate):
        return "no roll signal is there while the vehicle corners"
    return f"the lateral acceleration hardly changes (spread {spread:.2f} m/s²): drive a slalom or lane changes at 0.3 g or more"


BANKED_ROAD, AGREES = 0.5, 0.3
"""The bank's spread over the lean's from which a road explains an angle that does not follow the acceleration, and the
correlation of quick changes from which the channel itself is right."""


def _quick_agreement(data: RollData) -> float:
    """Correlation of what angle and lateral acceleration change by in a second, in which roads seldom bank."""
    apart = max(1, round(1 / data.step_s))
    lean, push = (
        np.concatenate(
            [x[i:j][apart:] - x[i:j][:-apart] for i, j in zip(data.starts, data.stops, strict=True)]
        )
        for x in (data.whole_roll, data.accel)
    )
    good = np.isfinite(lean) & np.isfinite(push)
    size = float(np.linalg.norm(lean[good]) * np.linalg.norm(push[good]))
    return float(lean[good] @ push[good]) / max(size, 1e-12)


def not_following(data: RollData, fit: RollFit, spread: float) -> str:
    """Why a roll signal that does not follow the lateral acceleration (spread: m/s²) tells nothing."""
    share = max(0.0, 100 * fit.explained)
    lean, bank = (
        DEGREES * spread / max(fit.values["a"], 1e-9),
        DEGREES * math.exp(fit.values.get("log_bank", -math.inf)),
    )
    if _of_a_car(fit) and bank > BANKED_ROAD * lean and _quick_agreement(data) > AGREES:
        return (
            f"the road's bank turns the roll angle by {bank:.1f} deg, the lean in bends by some {lean:.1f} deg: together they do not "
            f"follow the lateral acceleration ({share:.0f} % of the angle does). It takes level ground, quicker or harder "
            f"steering, or suspension deflections, which the road does not turn"
        )
    what = "angle" if data.has_roll else "rate"
    return (
        f"the roll {what} does not follow the lateral acceleration ({share:.0f} % of it does): the road banks into its bends, or the "
        f"channel, its sign or its mounting is another"
    )


def _of_a_car(fit: RollFit) -> bool:
    """Whether the roll gradient is one that road vehicles have: 1.5 to 20 deg/g."""
    return 1.5 < GRAVITY * DEGREES / max(fit.values["a"], 1e-9) < 20


def like_tilting_ground(fit: RollFit) -> str:
    """Why an angle that goes with the sensed acceleration as on tilting ground tells nothing of the springs."""
    gradient = math.degrees(9.80665 / fit.values["a"]) if fit.values["a"] > 0 else math.inf
    return (
        f"the roll angle goes with the sensed lateral acceleration as it does where the ground itself tilts "
        f"({gradient:.0f} deg/g; tilting ground gives 57, springs at most about 10): it shows the ground and not the suspension"
    )


PARTS = {
    "stiffening": "springs that stiffen",
    "friction": "dry friction",
    "knee": "dampers with a knee",
    "series": "tyres in series",
    "smoothing": "a smoothing of the angle against the acceleration",
}


def model_parts(fit: RollFit) -> str:
    """Which parts of the model the log asked for, and with what gain; what stays open. Empty where none was tried."""
    verdict = fit.verdict
    if verdict is None:
        return ""
    if not verdict.gains:
        return "The motion is too short to hold stretches of it out: the parts of the model (friction, knee, tyres, curved springs) are as usual."
    said = [
        f"{PARTS[name]} (+{verdict.gains[name].total:.1f} in log likelihood, t = {verdict.gains[name].t:.1f})"
        for name in PARTS
        if name in verdict.supported
    ]
    opened = [PARTS[name] for name in PARTS if name in verdict.gains and name not in verdict.supported]
    asked = (
        f"the log asks for {', '.join(said)}" if said else "the log asks for no part beyond the plain model"
    )
    rest = f"; it cannot tell {', '.join(opened)}" if opened else ""
    if verdict.liveliest_s is not None:
        usual = " and ".join(PARTS[name] for name in PARTS if name in STANDARD)
        of = f" of the drive's liveliest {verdict.liveliest_s / 60:.1f} min"
        share = f": the answers hold what every suspension has, {usual}" + (", and those" if said else "")
    else:
        of = ""
        share = f": the answers hold the models with and without them, {100 * verdict.full_weight:.0f} % with"
    end = share if opened else ""
    return f"By the likelihood of {verdict.stretches} held-out stretches{of}, {asked}{rest}{end}."


def conflicts(data: RollData, fit: RollFit) -> tuple[str, ...]:
    """Sentences on what looks wrong in the data."""
    found: list[str] = []
    delay, std = fit.values["delay"], fit.std("delay")
    # where b is hardly known, a delay and damping look alike: nothing is said then
    told = fit.std("b") < 0.2 * fit.values["b"] and fit.std("c") < 0.2
    if told and abs(delay) > 0.01 and abs(delay) > 2.5 * std:
        later = "after" if delay > 0 else "before"
        found.append(
            f"The roll channel comes {abs(delay) * 1000:.0f} ms {later} the lateral acceleration; this is allowed for."
        )
    if "rate_lag" in fit.values and abs(fit.values["rate_lag"]) > 0.005:
        lag = fit.values["rate_lag"]
        later = "after" if lag > 0 else "before"
        found.append(
            f"The roll rate comes {abs(lag) * 1000:.0f} ms {later} the angle's rate; this is allowed for."
        )
    if "log_bank" in fit.values:
        bank = math.exp(fit.values["log_bank"]) * DEGREES
        if bank > 0.4:
            found.append(
                f"The angle wanders by {bank:.1f} deg without lateral acceleration (banked road or drifting sensor); this widens the intervals."
            )
    worst = float(np.nanmean(np.abs(fit.normalised) > 4))
    if worst > 0.002:
        found.append(f"{100 * worst:.1f} % of the samples are outliers and were held back.")
    if not fit.converged:
        found.append("The fit did not settle; read its figures with care.")
    gradient = GRAVITY * DEGREES / fit.values["a"]
    if not _of_a_car(fit):
        found.append(f"A roll gradient of {gradient:.1f} deg/g is not a road vehicle's: check the units.")
    if fit.values["a"] > 900 or fit.values["a"] < 10.5:
        found.append("The fit ran into its bounds: the roll channel may have the wrong sign or unit.")
    return tuple(found)


def with_what_looks_wrong(entry: ParameterEstimate, odd: Sequence[str]) -> ParameterEstimate:
    """A parameter's entry with what looks wrong in the data behind its reason. odd: whole sentences."""
    words = "".join(f"; {text[:1].lower()}{text[1:].rstrip('.')}" for text in odd)
    return replace(entry, reason=entry.reason + words)


def assumptions_of_fit(
    data: RollData, fit: RollFit, roll: RollSource | None, prepared: Prepared
) -> tuple[Assumption, ...]:
    """The choices of the first stage."""
    table, share = (DISCREPANCY_AXLES, LEFT_OVER_AXLES) if data.against_axles else (DISCREPANCY, LEFT_OVER)
    model = ", ".join(
        f"{n.replace('_', ' ')} {100 * error:g} %" for n, error in table.items() if n in fit.values
    )
    if data.has_roll and roll is not None:
        made = roll.how
    else:
        made = f"roll rate alone ({prepared.sources.get('roll_rate', 'measured')})"
    found = [
        Assumption("roll signal", made, "the best of what the log holds"),
        Assumption(
            "error of the roll model itself",
            f"{model}; {100 * share:g} % of the springs' moment, which looks like stiffness, damping or inertia",
            "simulated cars with tyres, friction, curved springs and dampers with a knee",
        ),
        Assumption(
            "filter", f"zero-phase low-pass at {prepared.cutoff_hz:.3g} Hz on all signals", "settings"
        ),
    ]
    parts = model_parts(fit)
    if parts:
        found.append(
            Assumption("parts of the roll model", parts.rstrip("."), "chosen by held-out likelihood")
        )
    if data.has_roll:
        found.append(
            Assumption(
                "bank and drift of the angle",
                f"wander within {BANK_TIME_S:g} s, spread estimated",
                "part of the model",
            )
        )
    if data.against_axles:
        found.append(
            Assumption(
                "roll angle",
                "of the body against its axles, without the tyres' part",
                "suspension deflections",
            )
        )
    return tuple(found)
