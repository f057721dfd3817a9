"""The data of the HTML page as compact JSON: columns, not rows; figures rounded to what their intervals earn."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate
from typing import Any

import numpy as np

from reports.fleet.records import LOAD, NEAR_G, WIDTH_95, Answers, DriveView, FleetView, Row, VehicleView
from reports.fleet.view import NAME_LIMIT, finite, moment, title_of
from reports.text import clean, decimals_for, spec_of

Json = dict[str, Any]
_ESCAPES = {ord(c): f"\\u{ord(c):04x}" for c in "<>&\u2028\u2029"}


def script_json(data: object) -> str:
    """JSON that may stand inside a script element: nothing in it can end the element or open a comment."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.translate(_ESCAPES)


def _rounded(values: Sequence[float | None], digits: int) -> list[float | int | None]:
    out: list[float | int | None] = []
    for value in values:
        known = finite(value)
        short = None if known is None else round(known, digits)
        out.append(int(short) if short is not None and short == int(short) else short)
    return out


def digits_of(name: str, answers: Sequence[Answers]) -> int:
    """Digits after the point for a parameter of the fleet: two figures of the usual spread."""
    widths = [(a.high - a.low) / WIDTH_95 for a in answers]
    wide = np.concatenate(widths) if widths else np.zeros(0)
    wide = wide[np.isfinite(wide) & (wide > 0)]
    usual = float(np.median(wide)) if wide.size else None
    otherwise = spec_of(name).digits
    return min(decimals_for(usual, otherwise), otherwise + 1)


def _answers(answers: Answers | None, digits: int) -> Json | None:
    if answers is None:
        return None
    return {
        "value": _rounded(answers.value.tolist(), digits + 1),
        "low": _rounded(answers.low.tolist(), digits + 1),
        "high": _rounded(answers.high.tolist(), digits + 1),
        "status": "".join(map(str, answers.status)),
    }


def _parameters(view: FleetView) -> list[Json]:
    names = dict.fromkeys((*LOAD, *view.joined, *view.own))
    out = []
    for name in names:
        both = (view.joined.get(name), view.own.get(name))
        if both == (None, None):
            continue
        digits = digits_of(name, [a for a in both if a is not None])
        title, unit = view.titles[name]
        out.append(
            {
                "name": name,
                "title": title,
                "unit": unit,
                "digits": max(digits, 0),
                "joined": _answers(both[0], digits),
                "own": _answers(both[1], digits),
            }
        )
    return out


def _codes(texts: Sequence[str]) -> tuple[list[str], list[int]]:
    """Distinct texts in the order in which they are met, and the place of each."""
    known: dict[str, int] = {}
    places = [known.setdefault(text, len(known)) for text in texts]
    return list(known), places


def _drives(view: FleetView) -> Json:
    drives = view.drives

    def column(take: Callable[[DriveView], float | None], digits: int) -> list[float | int | None]:
        return _rounded([take(d) for d in drives], digits)

    statuses, status = _codes([d.status for d in drives])
    reasons, reason = _codes([d.reason for d in drives])
    formats, kind = _codes([d.format for d in drives])
    words, said = _codes([note for d in drives for note in d.notes])
    ends = list(accumulate(len(d.notes) for d in drives))
    notes = {
        str(k): said[end - len(d.notes) : end]
        for k, (d, end) in enumerate(zip(drives, ends, strict=True))
        if d.notes
    }
    return {
        "statuses": statuses,
        "reasons": reasons,
        "formats": formats,
        "status": status,
        "reason": reason,
        "format": kind,
        "name": [d.name for d in drives],
        "vehicle": [d.vehicle for d in drives],
        "start": [d.start for d in drives],
        "local": "".join("1" if d.local else "0" for d in drives),
        "duration": column(lambda d: d.duration_s, 1),
        "factor": column(lambda d: d.factor, 3),
        "threshold": column(lambda d: d.threshold_g, 3),
        "margin": column(lambda d: d.margin_g, 3),
        "exceedance": column(lambda d: d.exceedance, 4),
        "lifts": [d.lifts for d in drives],
        "near": "".join("1" if d.near else "0" for d in drives),
        "changed": "".join("1" if d.changed else "0" for d in drives),
        "gone": "".join("1" if d.gone else "0" for d in drives),
        "misfit": "".join("1" if d.apart == "misfit" else "0" for d in drives),
        "copy": "".join("1" if d.apart == "copy" else "0" for d in drives),
        "href": [d.href for d in drives],
        "words": words,
        "notes": notes,
    }


def _figures(row: Row, names: Sequence[str]) -> Json:
    """Figures with five significant digits."""
    out: Json = {}
    for name in names:
        known = finite(row[name])
        out[name] = None if known is None else float(f"{known:.5g}")
    return out


CHANGES = tuple(
    f"{what}_change{part}_{unit}"
    for what, unit in (("mass", "kg"), ("cg_height", "m"), ("cg_to_front_axle", "m"), ("cg_lateral", "m"))
    for part in ("", "_std")
)


def _change(row: Row, places: Mapping[object, int]) -> Json:
    detected = bool(row["detected"])
    return {
        "drive": places.get(clean(row["drive_id"], NAME_LIMIT)),
        "before": places.get(clean(row["before"], NAME_LIMIT)),
        "detected": detected,
        "probability": _figures(row, ["probability"])["probability"],
        # the figures of what is no change are not drawn
        "figures": list(_figures(row, CHANGES).values()) if detected else None,
        "text": clean(row["text"] or "", 300) if detected else "",
    }


def _shared(row: Row) -> Json:
    return {
        "name": clean(row["parameter"], 80),
        "title": title_of(row),
        "unit": clean(row["unit"] or "", 20),
        "status": clean(row["status"] or "", 20),
        "drives": row["drives"],
        **_figures(row, ("value", "std", "low", "high", "prior", "prior_std", "single_std")),
    }


def _trend(row: Row) -> Json:
    return {
        "name": clean(row["parameter"], 80),
        "title": title_of(row),
        "unit": clean(row["unit"] or "", 20),
        "detected": bool(row["detected"]),
        "from": moment(row["from_utc"]),
        "to": moment(row["to_utc"]),
        "drives": row["drives"],
        "text": clean(row["text"] or "", 300),
        **_figures(row, ("per_year", "std", "low", "high", "probability")),
    }


def _vehicle(vehicle: VehicleView, places: Mapping[object, int]) -> Json:
    outlier = vehicle.outlier
    return {
        "label": vehicle.label,
        "id": vehicle.vehicle_id,
        "failed": vehicle.failed,
        "shared": [_shared(row) for row in vehicle.shared],
        "changes": [_change(row, places) for row in vehicle.changes],
        "trends": [_trend(row) for row in vehicle.trends],
        "outlier": None
        if outlier is None
        else {
            "rank": outlier["rank"],
            "text": clean(outlier["text"] or "", 300),
            "outlying": vehicle.outlying,
            **_figures(outlier, ("score", "probability")),
        },
        "notes": list(vehicle.notes),
    }


def payload(view: FleetView) -> Json:
    """All that the page's script draws from."""
    places: dict[object, int] = {d.drive_id: k for k, d in enumerate(view.drives)}
    return {
        "near_g": NEAR_G,
        "drives": _drives(view),
        "parameters": _parameters(view),
        "vehicles": [_vehicle(vehicle, places) for vehicle in view.vehicles],
    }
