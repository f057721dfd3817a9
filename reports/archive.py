"""Store results so that the report can be printed again without the log: one JSON file, arrays packed inside.

Arrays are little-endian 64-bit floats, compressed (zlib) and in base64; nothing in the file is ever executed. Traces
are thinned first, just as the report thins them, so that the report from the archive equals the first one.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
import types
import typing
import zlib
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin

import numpy as np

from parsers.errors import ReportError
from pipelines.drive_results import DriveResults
from reports.files import write_whole
from reports.reduce import reduce_results

FORMAT = 1
FILE_NAME = "results.archive.json"
"""The archive's name in a report's folder."""
MOST_BYTES = 512 * 1024 * 1024
"""No archive is larger: beyond this a file is not one of ours."""
MOST_VALUES = 20_000_000
"""No array is longer; checked before anything is unpacked."""


class _BadArchiveError(Exception):
    """Something in the file is not as it must be: where, and what."""


def _pack(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _pack(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value, dtype="<f8")
        packed = base64.b64encode(zlib.compress(array.tobytes(), 6)).decode("ascii")
        return {"values": int(array.size), "zlib": packed}
    if isinstance(value, Mapping):
        return {str(k): _pack(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_pack(v) for v in value]
    if isinstance(value, np.generic):
        return _pack(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)  # "nan", "inf": JSON has none
    if value is None or isinstance(value, bool | int | float):
        return value
    return str(value).encode("utf-8", "replace").decode("utf-8")


@cache
def _hints(kind: type) -> dict[str, Any]:
    return typing.get_type_hints(kind)


def _array(raw: Any, place: str) -> Any:
    if (
        not isinstance(raw, dict)
        or not isinstance(raw.get("values"), int)
        or not isinstance(raw.get("zlib"), str)
    ):
        raise _BadArchiveError(f"{place}: expected a packed array")
    size = raw["values"]
    if not 0 <= size <= MOST_VALUES:
        raise _BadArchiveError(f"{place}: an array of {size} values")
    try:
        unpacker = zlib.decompressobj()
        content = unpacker.decompress(base64.b64decode(raw["zlib"], validate=True), 8 * size + 1)
    except (zlib.error, binascii.Error, ValueError) as error:
        raise _BadArchiveError(f"{place}: a damaged array ({error})") from error
    if len(content) != 8 * size:
        raise _BadArchiveError(f"{place}: {len(content)} bytes for {size} values")
    return np.frombuffer(content, dtype="<f8").astype(np.float64)


def _record(raw: Any, kind: type, place: str) -> Any:
    if not isinstance(raw, dict):
        raise _BadArchiveError(f"{place}: expected a record")
    hints = _hints(kind)
    given: dict[str, Any] = {}
    for field in fields(kind):
        if field.name in raw:
            given[field.name] = _unpack(raw[field.name], hints[field.name], f"{place}.{field.name}")
        elif field.default is MISSING and field.default_factory is MISSING:
            raise _BadArchiveError(f"{place}: {field.name!r} is missing")
    return kind(**given)


def _scalar(raw: Any, kind: Any, place: str) -> Any:
    if kind is float and isinstance(raw, str) and raw in ("nan", "inf", "-inf"):
        return float(raw)
    if kind is float and isinstance(raw, int | float) and not isinstance(raw, bool):
        try:
            return float(raw)
        except OverflowError:
            raise _BadArchiveError(f"{place}: a number of {len(str(raw))} digits") from None
    if kind is Path and isinstance(raw, str):
        return Path(raw)
    if kind in (int, str, bool) and type(raw) is kind:
        return raw
    raise _BadArchiveError(f"{place}: found {str(raw)[:40]!r}, expected {getattr(kind, '__name__', kind)}")


def _unpack(raw: Any, kind: Any, place: str) -> Any:
    """Read a value as its annotation says; anything else is refused."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        if raw is None and type(None) in inner:
            return None
        return _unpack(raw, next(k for k in inner if k is not type(None)), place)
    if origin is Literal:
        if raw not in inner:
            raise _BadArchiveError(
                f"{place}: found {str(raw)[:40]!r}, expected one of {', '.join(map(str, inner))}"
            )
        return raw
    if origin is tuple:
        if not isinstance(raw, list):
            raise _BadArchiveError(f"{place}: expected a list")
        return tuple(_unpack(item, inner[0], f"{place}[{i}]") for i, item in enumerate(raw))
    if origin is np.ndarray:
        return _array(raw, place)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        if not isinstance(raw, dict):
            raise _BadArchiveError(f"{place}: expected a table")
        return {key: _unpack(item, inner[1], f"{place}.{key}") for key, item in raw.items()}
    if isinstance(kind, type) and is_dataclass(kind):
        return _record(raw, kind, place)
    return _scalar(raw, kind, place)


def archive_bytes(results: DriveResults) -> bytes:
    """Results as the archive holds them."""
    content = {"cogest_archive": FORMAT, "results": _pack(reduce_results(results))}
    return json.dumps(content, ensure_ascii=False, allow_nan=False).encode("utf-8")


def save_results(results: DriveResults, path: Path) -> None:
    """Store results, whole or not at all. Raises ReportError where the file cannot be written."""
    write_whole(path, archive_bytes(results))


def load_results(path: Path) -> DriveResults:
    """Read stored results. Raises ReportError that says what is wrong with the file."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise ReportError(f"larger than {MOST_BYTES // 2**20} MiB, no archive of results is", path=path)
        content = path.read_bytes()
    except OSError as error:
        raise ReportError(f"cannot be read ({error.strerror or error})", path=path) from error
    return results_of(content, path)


def results_of(content: bytes, path: Path) -> DriveResults:
    """An archive's results; path: named in errors. Raises ReportError that says what is wrong with it."""
    hint = "run `cogest analyze` again to make it anew"
    try:
        raw = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise ReportError(f"not whole JSON ({error})", path=path, hint=hint) from error
    if not isinstance(raw, dict) or "cogest_archive" not in raw:
        raise ReportError("no archive of cogest results", path=path, hint=hint)
    if raw["cogest_archive"] != FORMAT:
        found = str(raw["cogest_archive"])[:20]
        raise ReportError(f"format {found}, this cogest reads {FORMAT}", path=path, hint=hint)
    try:
        loaded = _unpack(raw.get("results"), DriveResults, "results")
    except _BadArchiveError as error:
        raise ReportError(str(error), path=path, hint=hint) from error
    assert isinstance(loaded, DriveResults)
    return loaded


def load_folder(folder: Path) -> DriveResults:
    """Read the stored results of a folder that `write_reports` filled. Raises ReportError."""
    path = folder / FILE_NAME
    if not path.is_file():
        raise ReportError(
            f"no stored results ({FILE_NAME}) in this folder",
            path=folder,
            hint="give a folder that `cogest analyze` wrote",
        )
    return load_results(path)
