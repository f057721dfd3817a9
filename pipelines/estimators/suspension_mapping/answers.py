"""What the mapping says in words and figures: each wheel's static force, how least it was, and errors where it was measured."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from parsers.signals import WHEELS
from pipelines.models.suspension_map import GRAVITY
from pipelines.results import Assumption, Identification, ParameterEstimate
from pipelines.suspension_mapping.apply import LOAD_SHARE, Mapped, WheelError
from pipelines.suspension_mapping.data import MapData
from pipelines.suspension_mapping.record import SuspensionMap
from pipelines.suspension_mapping.regressors import REGRESSORS
from pipelines.suspension_mapping.spread import QUANTILE
from pipelines.vehicles.vehicle import Vehicle

NAME = "suspension_mapping"
IDENTIFIED, WEAK = 0.05, 0.2
"""Largest standard deviation over the force for these words."""
FAR = 0.02
"""Share of the time outside the training's range from which it is said."""
HEAVY_SHARE = 0.1
"""Change of load over the training's from which it is said."""


def parameter_name(wheel: str) -> str:
    """The parameter that holds a wheel's force."""
    return f"tire_normal_force_{wheel}_n"


def nothing(vehicle: Vehicle, reason: str) -> dict[str, ParameterEstimate]:
    """All four as not identifiable."""
    return {
        name: ParameterEstimate(
            name, None, None, None, None, "not_identifiable", reason, None, vehicle.reference.get(name)
        )
        for name in map(parameter_name, WHEELS)
    }


def parameters(mapped: Mapped, data: MapData, vehicle: Vehicle, remark: str) -> dict[str, ParameterEstimate]:
    """The static force of each wheel: its mean while the vehicle stands, else over the drive; said in the reason."""
    still = data.still
    standing = float(np.count_nonzero(still)) / data.rate_hz
    rows = still if standing >= 1.0 else np.ones(data.size, dtype=bool)
    what = (
        f"static force: mean over {standing:.0f} s of standstill"
        if standing >= 1.0
        else f"mean over {data.size / data.rate_hz:.0f} s of driving (the vehicle never stands)"
    )
    found = {}
    for wheel in WHEELS:
        own, name = mapped.wheels[wheel], parameter_name(wheel)
        value, std = float(np.mean(own.force[rows])), float(np.sqrt(np.mean(own.std[rows] ** 2)))
        share = std / value if value > 0 else math.inf
        status: Identification = "identified" if share <= IDENTIFIED else "weak"
        reason = f"{what}; over the drive {np.min(own.force):.0f} to {np.max(own.force):.0f} N{remark}"
        if share > WEAK:
            found[name] = ParameterEstimate(
                name, None, None, None, None, "not_identifiable",
                f"the map leaves this force open to {100 * share:.0f} %{remark}"
                if value > 0
                else f"the map gives {value:.0f} N, which no standing wheel carries: are the signals those that it was "
                "trained on?",
                None, vehicle.reference.get(name),
            )  # fmt: skip
            continue
        half = QUANTILE * std
        found[name] = ParameterEstimate(
            name, value, std, value - half, value + half, status, reason, None, vehicle.reference.get(name), (NAME,)
        )  # fmt: skip
    return found


def remarks(mapped: Mapped, record: SuspensionMap, vehicle: Vehicle, data: MapData) -> list[str]:
    """What a reader must know: other vehicle, other load, outside the training's range, signals that are missing."""
    said = []
    if vehicle.name and vehicle.name != record.vehicle:
        said.append(f"the map was trained on {record.vehicle!r}, this vehicle is {vehicle.name!r}")
    if data.band_hz < 0.99 * record.band_hz:
        said.append(
            f"signals reach {data.band_hz:.3g} Hz only, the map was trained up to {record.band_hz:.3g} Hz"
        )
    own = record.parts[mapped.kind].wheels
    load = sum(w.load_n for w in mapped.wheels.values())
    if abs(load) > HEAVY_SHARE * sum(abs(w.carried_n) for w in own.values()):
        said.append(
            f"the suspension carries {load / GRAVITY:+.0f} kg against training: intervals allow for it"
        )
    missing = list(dict.fromkeys(n for w in mapped.wheels.values() for n in w.missing))
    if missing:
        said.append(
            f"this log lacks what tells {', '.join(missing)}: their training mean stands in, intervals are wider"
        )
    worst: dict[str, float] = {}
    for wheel in mapped.wheels.values():
        for name, share in wheel.outside.items():
            worst[name] = max(share, worst.get(name, 0.0))
    far = {n: s for n, s in sorted(worst.items(), key=lambda entry: -entry[1]) if s > FAR}
    if far:
        words = ", ".join(
            f"{name.replace('_', ' ')} {100 * share:.0f} %" for name, share in list(far.items())[:4]
        )
        said.append(f"outside the training's range part of the time ({words}): wider there")
    return said


def diagnostics(mapped: Mapped, data: MapData, errors: Mapping[str, WheelError]) -> dict[str, float]:
    """Named figures: least force of each wheel and when, the load against training, errors where the force was measured."""
    found = {"band_hz": data.band_hz}
    for wheel, own in mapped.wheels.items():
        least = int(np.argmin(own.force))
        found[f"least_force_{wheel}_n"] = float(own.force[least])
        found[f"least_force_low_{wheel}_n"] = float(own.low[least])
        found[f"least_force_high_{wheel}_n"] = float(own.high[least])
        found[f"least_force_time_{wheel}_s"] = float(data.time_s[least])
        found[f"load_against_training_{wheel}_n"] = own.load_n
    for wheel, error in errors.items():
        found[f"rms_error_{wheel}_n"] = error.rms_n
        found[f"peak_error_{wheel}_n"] = error.peak_n
        found[f"peak_error_time_{wheel}_s"] = error.peak_s
        found[f"inside_interval_{wheel}"] = error.coverage
    return found


def assumptions(record: SuspensionMap, mapped: Mapped, data: MapData) -> tuple[Assumption, ...]:
    """What is taken as given."""
    part = record.parts[mapped.kind]
    drives = ", ".join(d.log for d in record.training[:3]) + (" …" if len(record.training) > 3 else "")
    zero = np.mean([w.zero_n for w in part.wheels.values()])
    terms = ", ".join(name.replace("_", " ") for name in part.wheels["fl"].coefficients if name in REGRESSORS)
    seconds = sum(d.duration_s for d in record.training)
    return (
        Assumption("suspension map", f"form {part.form!r} from {mapped.kind}: {terms}", f"trained on {drives}, {seconds:.0f} s"),
        Assumption("sensors' zeros", f"drift by {zero:.0f} N (std) from drive to drive", record.zero_from),
        Assumption(
            "another load", f"{100 * LOAD_SHARE[mapped.kind]:.3g} % (std) of how much more or less the wheel carries than in "
            "training", "usual scale error" if mapped.kind == "struts" else "a spring's rate, driving against standing",
        ),
        Assumption("filter", f"zero-phase low-pass at {data.band_hz:.3g} Hz: forces faster than that are not told", "map file"),
    )  # fmt: skip
