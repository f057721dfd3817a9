"""The map file (TOML): a suspension map as text that a person can read and check, and back, trusting nothing in it."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from parsers.errors import VehicleError
from parsers.signals import WHEELS
from pipelines.results import FloatArray
from pipelines.suspension_mapping.record import (
    SPREAD,
    MapPart,
    Seen,
    SuspensionMap,
    TrainingDrive,
    WheelMap,
)
from pipelines.suspension_mapping.regressors import FORMS, REGRESSORS, Shape, Springs
from pipelines.suspension_mapping.strict import StrictTable

FORMAT = 1
MOST_BYTES = 1_000_000
MOST_DRIVES = 1000
SPRING_KEYS = ("preload", "rate", "stiffening", "bar")
HEAD = (
    "# Suspension map: tyre normal forces from what the suspension feels. Made by `cogest suspension-map`, used by\n"
    '# `cogest analyze --suspension-map FILE`, or by `suspension_map = "FILE"` in a vehicle file. Forces in N, lengths in m.\n'
    "# F = sum of coefficient x regressor; low, high, mean, std: of the regressor in training; docs/suspension_map.md.\n"
)


def _text(value: str) -> str:
    """A TOML string: control characters and lone surrogates become "?"."""
    clean = "".join(c if c.isprintable() else "?" for c in value).encode("utf-8", "replace").decode("utf-8")
    return json.dumps(clean, ensure_ascii=False)


def _number(value: float) -> str:
    return f"{value:.10g}"


def _inline(entries: Mapping[str, float | str]) -> str:
    parts = (
        f"{key} = {_text(value) if isinstance(value, str) else _number(value)}"
        for key, value in entries.items()
    )
    return "{" + ", ".join(parts) + "}"


def _wheel_lines(place: str, own: WheelMap) -> Iterable[str]:
    yield f"\n[{place}]"
    for key in ("carried_n", "zero_n", "rms_n", "peak_n", "peak_s", "held_out_n", "factor"):
        yield f"{key} = {_number(getattr(own, key))}"
    yield f"spread = {_inline(dict(zip(SPREAD, own.spread, strict=True)))}"
    rows = [own.covariance[i, : i + 1].tolist() for i in range(len(own.coefficients))]
    yield "covariance = ["
    yield from ("  [" + ", ".join(map(_number, row)) + "]," for row in rows)
    yield "]"
    yield f"\n[{place}.coefficients]"
    for name, value in own.coefficients.items():
        seen = own.seen[name]
        line: dict[str, float | str] = {
            "value": value, "unit": REGRESSORS[name].unit, "low": seen.low, "high": seen.high, "mean": seen.mean,
            "std": seen.std,
        }  # fmt: skip
        yield f"{name} = {_inline(line)}  # {REGRESSORS[name].meaning}"


def map_text(record: SuspensionMap) -> str:
    """A map file's text. `read_map_text` gives the same record back, to ten digits."""
    shape = record.shape
    lines = [
        HEAD,
        "[suspension_map]",
        f"format = {FORMAT}",
        f"vehicle = {_text(record.vehicle)}",
        f"band_hz = {_number(record.band_hz)}",
        f"friction_travel_m = {_number(shape.friction_travel_m)}",
        f"ride_height_m = {_number(shape.ride_height_m)}",
        f"track_m = {_number(shape.track_m)}",
        f"zero_from = {_text(record.zero_from)}",
    ]
    for drive in record.training:
        lines += [
            "\n[[training]]",
            f"log = {_text(drive.log)}",
            f"sha256 = {_text(drive.sha256)}",
            f"duration_s = {_number(drive.duration_s)}",
        ]
    for kind, part in record.parts.items():
        lines += [f"\n[{kind}]", f"form = {_text(part.form)}", f"held_out_n = {_inline(part.held_out)}"]
        for wheel, law in part.springs.items():
            lines.append(f"law_{wheel} = {_inline({key: getattr(law, key) for key in SPRING_KEYS})}")
        for wheel in WHEELS:
            lines += _wheel_lines(f"{kind}.{wheel}", part.wheels[wheel])
    return "\n".join(lines) + "\n"


def _covariance(table: StrictTable, size: int) -> FloatArray:
    rows = table.rows("covariance", size)
    found = np.zeros((size, size))
    if len(rows) != size:
        raise table.error(f"{len(rows)} rows, expected {size}: one a coefficient", "covariance")
    for i, row in enumerate(rows):
        if not isinstance(row, list) or len(row) != i + 1:
            raise table.error(f"row {i + 1}: expected {i + 1} numbers", "covariance")
        for j, value in enumerate(row):
            found[i, j] = found[j, i] = table.as_number(value, f"covariance row {i + 1}", -1e30, 1e30)
    size_of = np.sqrt(np.maximum(np.diag(found), 0.0))
    size_of[size_of == 0] = 1.0
    if np.any(np.diag(found) < 0) or np.linalg.eigvalsh(found / np.outer(size_of, size_of)).min() < -1e-6:
        raise table.error("no covariance: it is not positive", "covariance", "train the map anew")
    return found


def _wheel(table: StrictTable, form: Iterable[str]) -> WheelMap:
    known = tuple(form)
    listed = table.table("coefficients")
    coefficients: dict[str, float] = {}
    seen: dict[str, Seen] = {}
    for name in listed.names:
        if name not in known:
            break
        entry = listed.table(name)
        coefficients[name] = entry.number("value")
        unit = entry.text("unit")
        if unit != REGRESSORS[name].unit:
            raise entry.error(f"found {unit!r}, expected {REGRESSORS[name].unit!r}", "unit")
        seen[name] = Seen(
            entry.number("low"), entry.number("high"), entry.number("mean"), entry.number("std", 0.0)
        )
        if seen[name].low > seen[name].high:
            raise entry.error("low is above high")
        entry.finish()
    for name in known:
        listed.has(name)
    listed.finish()
    if not coefficients:
        raise listed.error("no coefficient")
    spread = table.table("spread")
    amounts = tuple(spread.number(name, 0.0) for name in SPREAD)
    spread.finish()
    found = WheelMap(
        coefficients, _covariance(table, len(coefficients)), seen, amounts, table.number("factor", 0.1, 10.0),
        table.number("carried_n"), table.number("zero_n", 0.0), table.number("rms_n", 0.0), table.number("peak_n"),
        table.number("peak_s"), table.number("held_out_n", 0.0),
    )  # fmt: skip
    table.finish()
    return found


def _part(table: StrictTable, kind: str) -> MapPart:
    form = table.one_of("form", FORMS[kind])
    scores = table.table("held_out_n")
    held_out = {name: scores.number(name, 0.0) for name in FORMS[kind] if scores.has(name)}
    scores.finish()
    laws: dict[str, Springs] = {}
    if kind == "springs":
        for wheel in WHEELS:
            law = table.table(f"law_{wheel}")
            laws[wheel] = Springs(*(law.number(key) for key in SPRING_KEYS))
            law.finish()
    wheels = {wheel: _wheel(table.table(wheel), FORMS[kind][form]) for wheel in WHEELS}
    needed = "carried" if kind == "struts" else "deflection"
    for wheel, own in wheels.items():
        if needed not in own.coefficients:
            raise table.error(f"wheel {wheel} has no coefficient {needed!r}")
    table.finish()
    return MapPart(kind, form, wheels, laws, held_out)


def _training(top: StrictTable, path: Path) -> tuple[TrainingDrive, ...]:
    drives = []
    for number, raw in enumerate(top.rows("training", MOST_DRIVES)):
        entry = StrictTable(raw, path, f"[[training]] {number + 1}")
        digest = entry.text("sha256")
        if len(digest) != 64 or not all(c in "0123456789abcdef" for c in digest):
            raise entry.error(f"found {digest[:20]!r}, expected 64 hexadecimal digits", "sha256")
        drives.append(TrainingDrive(entry.text("log"), digest, entry.number("duration_s", 0.0)))
        entry.finish()
    return tuple(drives)


def read_map_text(text: str, path: Path) -> SuspensionMap:
    """Read a map file's text. Raises VehicleError that names the place, what was found and the nearest right key."""
    try:
        raw = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise VehicleError(f"not valid TOML ({error})", path=path) from error
    top = StrictTable(raw, path, "")
    if not top.has("suspension_map"):
        raise VehicleError(
            "no [suspension_map]: this is no suspension map", path=path,
            hint="make one with `cogest suspension-map LOG --out FILE`",
        )  # fmt: skip
    head = top.table("suspension_map")
    version = head.number("format")
    if version != FORMAT:
        raise head.error(f"format {version:g}, this cogest reads {FORMAT}", hint="train the map anew")
    shape = Shape(
        head.number("friction_travel_m", 1e-5, 0.1),
        head.number("ride_height_m", 0.01, 5.0),
        head.number("track_m", 0.3, 5.0),
    )
    vehicle, band, zero = head.text("vehicle"), head.number("band_hz", 0.1, 500.0), head.text("zero_from")
    head.finish()
    training = _training(top, path)
    parts = {kind: _part(top.table(kind), kind) for kind in FORMS if top.has(kind)}
    top.finish()
    if not parts:
        raise VehicleError("neither [struts] nor [springs]: the map is empty", path=path)
    return SuspensionMap(vehicle, band, shape, training, parts, zero)


def read_suspension_map(path: Path) -> SuspensionMap:
    """Read a map file. Raises VehicleError where it cannot be read or is wrong."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise VehicleError(f"larger than {MOST_BYTES} bytes: no suspension map is", path=path)
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise VehicleError(f"cannot be read ({error.strerror})", path=path) from error
    except UnicodeDecodeError as error:
        raise VehicleError("not UTF-8 text", path=path, place=f"byte {error.start}") from error
    return read_map_text(text, path)
