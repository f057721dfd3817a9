"""What `cogest suspension-map` says: forms tried, training and validation errors; as text and as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from parsers.signals import WHEELS
from pipelines.suspension_mapping.judge import Judged, training_rms_n
from pipelines.suspension_mapping.record import MapPart, SuspensionMap
from reports.layout import printable

CARRIES, LEAST_INSIDE = 1.5, 0.85
"""Ratio of a drive's errors to the training's up to which a map carries over to it, and the least share inside its 95 % interval."""

SOURCES = {"struts": "strut forces", "springs": "deflections alone"}


def _heads(cells: Sequence[str]) -> str:
    return f"  {cells[0]:<8}" + "".join(f"{cell:>22}" for cell in cells[1:])


def _peak(value: float, time_s: float) -> str:
    return f"{value:+.0f} N @ {time_s:.1f} s"


def _training(part: MapPart) -> list[str]:
    lines = [_heads(("wheel", "RMS error", "peak error", "RMS, held out"))]
    for wheel, own in part.wheels.items():
        cells = (f"{own.rms_n:.0f} N", _peak(own.peak_n, own.peak_s), f"{own.held_out_n:.0f} N")
        lines.append(_heads((wheel, *cells)))
    return lines


def _forms(part: MapPart) -> list[str]:
    tried = ", ".join(
        f"{form} {error:.0f} N{' (chosen)' if form == part.form else ''}"
        for form, error in part.held_out.items()
    )
    return [f"  RMS over manoeuvres that were left out, by form: {tried}"]


def _was_trained_on(record: SuspensionMap, judged: Judged) -> bool:
    """Whether the drive is one of those that the map was made of, by its bytes."""
    return judged.sha256 in {drive.sha256 for drive in record.training if drive.sha256}


def _validation(record: SuspensionMap, judged: Judged) -> list[str]:
    again = _was_trained_on(record, judged)
    lines = [
        f"{'NO VALIDATION' if again else 'Validation'} from {SOURCES[judged.kind]}: {judged.log} ({judged.duration_s:.0f} s, load "
        f"{judged.load_kg:+.0f} kg against training)",
        *(
            ["  the map was trained on this very drive: its errors say nothing of others. Give another one"]
            if again
            else []
        ),
        _heads(("wheel", "RMS error", "peak error", "inside 95 %")),
    ]
    for wheel, error in judged.wheels.items():
        cells = (f"{error.rms_n:.0f} N", _peak(error.peak_n, error.peak_s), f"{100 * error.coverage:.0f} %")
        lines.append(_heads((wheel, *cells)))
    lines.append(f"  all wheels {judged.rms_n:.0f} N, {judged.ratio:.2f} times the training's")
    if not again:
        lines += _warning(judged)
    return lines


def _warning(judged: Judged) -> list[str]:
    """What is said of a map whose errors on another drive are no more those of its training."""
    short = [w for w, error in judged.wheels.items() if error.coverage < LEAST_INSIDE]
    if judged.ratio <= CARRIES and not short:
        return []
    what = [f"errors grow by more than {CARRIES:g} times"] if judged.ratio > CARRIES else []
    what += (
        [f"the 95 % interval holds less than {100 * LEAST_INSIDE:.0f} % at {', '.join(short)}"]
        if short
        else []
    )
    return [
        f"  WARNING: {' and '.join(what)}: the map does not carry over to this drive. Train it on more drives, other loads and rougher roads among them"
    ]


def map_report_text(record: SuspensionMap, judged: Sequence[Judged]) -> str:
    """Plain text for a terminal; free of control characters."""
    drives = ", ".join(f"{d.log} ({d.duration_s:.0f} s)" for d in record.training)
    out = [f"Suspension map of {record.vehicle}, trained on {drives}; signals below {record.band_hz:g} Hz"]
    for kind, part in record.parts.items():
        out += ["", f"Training from {SOURCES[kind]}, form {part.form!r}", *_training(part), *_forms(part)]
    for entry in judged:
        out += ["", *_validation(record, entry)]
    return "\n".join(printable(line) for line in out)


def map_report_dict(
    record: SuspensionMap, judged: Sequence[Judged], file: str, version: str
) -> dict[str, Any]:
    """The same figures as data, ready for JSON."""
    training = {
        kind: {
            "form": part.form,
            "rms_n": training_rms_n(record, kind),
            "held_out_by_form_n": dict(part.held_out),
            "wheels": {
                wheel: {
                    "rms_n": own.rms_n,
                    "peak_n": own.peak_n,
                    "peak_s": own.peak_s,
                    "held_out_n": own.held_out_n,
                    "coefficients": dict(own.coefficients),
                }
                for wheel, own in part.wheels.items()
            },
        }
        for kind, part in record.parts.items()
    }
    validation = [
        {
            "log": entry.log,
            "sha256": entry.sha256,
            "trained_on": _was_trained_on(record, entry),
            "from": entry.kind,
            "form": entry.form,
            "duration_s": entry.duration_s,
            "load_against_training_kg": entry.load_kg,
            "rms_n": entry.rms_n,
            "ratio_to_training": entry.ratio,
            "wheels": {
                wheel: {
                    "rms_n": e.rms_n,
                    "peak_n": e.peak_n,
                    "peak_s": e.peak_s,
                    "mean_n": e.mean_n,
                    "inside_interval": e.coverage,
                }
                for wheel, e in entry.wheels.items()
            },
        }
        for entry in judged
    ]
    drives = [{"log": d.log, "sha256": d.sha256, "duration_s": d.duration_s} for d in record.training]
    return {
        "cogest": version,
        "file": file,
        "vehicle": record.vehicle,
        "band_hz": record.band_hz,
        "drives": drives,
        "training": training,
        "validation": validation,
    }


def tire_force_errors(diagnostics: Mapping[str, float]) -> str:
    """RMS and peak error of each wheel where an analysed log measured its forces; "" where it did not."""
    wheels = [w for w in WHEELS if f"rms_error_{w}_n" in diagnostics]
    if not wheels:
        return ""
    lines = [
        "Mapped tyre normal forces against the measuring wheels",
        _heads(("wheel", "RMS error", "peak error", "inside 95 %")),
    ]
    for wheel in wheels:
        peak = _peak(diagnostics[f"peak_error_{wheel}_n"], diagnostics[f"peak_error_time_{wheel}_s"])
        inside = f"{100 * diagnostics[f'inside_interval_{wheel}']:.0f} %"
        lines.append(_heads((wheel, f"{diagnostics[f'rms_error_{wheel}_n']:.0f} N", peak, inside)))
    return "\n".join(lines)
