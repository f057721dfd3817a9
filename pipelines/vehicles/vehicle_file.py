"""Reads the vehicle file (TOML): every key known, every figure one that vehicles have, else an error in words."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from parsers.errors import VehicleError
from parsers.finite import is_number
from parsers.small_text import read_small_text
from pipelines.parameters import PARAMETERS, is_positive
from pipelines.vehicles.keys import (
    ANY_SIGN,
    AXLE_LOADS,
    DEFAULT_RELATIVE_STD,
    LEAST_LOAD_STD_KG,
    LEAST_STD,
    LEVELLING,
    LOAD_ANY_SIGN,
    LOAD_KEYS,
    POSITIVE,
    RECORDED,
    RELATIVE_STD,
    RIG_SPARE,
    SENSOR_KEYS,
    SHARES,
    TEXT_KEYS,
    TRAILER_KEYS,
    VEHICLE_KEYS,
    ZERO_KEYS,
    ZERO_OR_MORE,
    ZEROS,
)
from pipelines.vehicles.kinematics import check_kinematics
from pipelines.vehicles.measured import POWERTRAINS, known_body, near_body
from pipelines.vehicles.plausible import check_plausible
from pipelines.vehicles.vehicle import Quantity, Vehicle


def _number(raw: object, key: str, table: str, path: Path) -> tuple[float, float | None]:
    """Read a quantity: a number, or {value, std}."""
    place = f"[{table}] {key}"
    value: object = raw
    std: object = None
    if isinstance(raw, Mapping):
        for inner in raw:
            if inner not in ("value", "std"):
                raise VehicleError(
                    f"unknown key {inner!r}",
                    path=path,
                    place=place,
                    hint="a quantity is a number or {value = …, std = …}",
                )
        if "value" not in raw:
            raise VehicleError(
                "no `value`", path=path, place=place, hint="a quantity is a number or {value = …, std = …}"
            )
        value, std = raw["value"], raw.get("std")
    for part in (value, std):
        if part is not None and not is_number(part):
            raise VehicleError(f"found {part!r}, expected a finite number", path=path, place=place)
    assert isinstance(value, int | float)
    assert std is None or isinstance(std, int | float)
    if std is not None and std < 0:
        raise VehicleError(f"std is {std}, expected 0 or more", path=path, place=place)
    return float(value), None if std is None else float(std)


def _check_sign(table: str, key: str, value: float, path: Path) -> None:
    place = f"[{table}] {key}"
    if table in ("load", "trailer"):
        # an empty vehicle is a load of 0 kg, and one that tows nothing a trailer of 0 kg
        if value < 0 and key not in LOAD_ANY_SIGN:
            raise VehicleError(f"found {value:g}, expected 0 or more", path=path, place=place)
        return
    # a rig's reading of a rigid axle may lie a little past it
    spare = RIG_SPARE if key == "camber_compensation" else 0.0
    if key in SHARES and not -spare <= value <= 1 + spare:
        raise VehicleError(f"found {value:g}, expected a share from 0 to 1", path=path, place=place)
    if key in POSITIVE and value <= 0:
        raise VehicleError(f"found {value:g}, expected more than 0", path=path, place=place)
    if key in ZERO_OR_MORE and value < 0:
        raise VehicleError(f"found {value:g}, expected 0 or more", path=path, place=place)


def _reject_unknown(key: str, known: frozenset[str], table: str, path: Path) -> None:
    if key in known:
        return
    near = difflib.get_close_matches(key, sorted(known), n=1, cutoff=0.4)
    hint = f"did you mean {near[0]!r}?" if near else f"known keys are {', '.join(sorted(known))}"
    if table == "top level" and key in VEHICLE_KEYS | TEXT_KEYS:
        hint = "write [vehicle] on a line above it"
    raise VehicleError(f"unknown key {key!r}", path=path, place=f"[{table}]", hint=hint)


def _quantities(raw: Mapping[str, Any], table: str, known: frozenset[str], path: Path) -> dict[str, Quantity]:
    found: dict[str, Quantity] = {}
    for key, entry in raw.items():
        _reject_unknown(key, known, table, path)
        value, std = _number(entry, key, table, path)
        _check_sign(table, key, value, path)
        stated = std is not None
        if std is None:
            std = abs(value) * RELATIVE_STD.get(key, DEFAULT_RELATIVE_STD)
            if key in ANY_SIGN | LOAD_ANY_SIGN or table == "sensors":
                std = max(std, LEAST_STD.get(key, 0.02))
            elif table in ("load", "trailer") and key == "mass_kg":
                std = max(std, LEAST_LOAD_STD_KG)
        found[key] = Quantity(value, std, "vehicle file", stated)
    return found


def _table(raw: Mapping[str, Any], name: str, path: Path) -> Mapping[str, Any]:
    table = raw.get(name, {})
    if not isinstance(table, Mapping):
        raise VehicleError(f"{name!r} is no table", path=path, hint=f"write [{name}] on a line of its own")
    return table


def parse_vehicle(text: str, path: Path) -> Vehicle:
    """Read a vehicle file's text. Raises VehicleError that names the key, what was found and the nearest right key."""
    try:
        raw = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise VehicleError(f"not valid TOML ({error})", path=path) from error
    for table in raw:
        _reject_unknown(
            table, frozenset({"vehicle", "load", "trailer", "sensors", "reference"}), "top level", path
        )
    main = dict(_table(raw, "vehicle", path))
    texts: dict[str, str] = {}
    for key in TEXT_KEYS & main.keys():
        value = main.pop(key)
        if not isinstance(value, str):
            raise VehicleError(f"found {value!r}, expected text", path=path, place=f"[vehicle] {key}")
        texts[key] = value
    reference: dict[str, float] = {}
    for key, entry in _table(raw, "reference", path).items():
        _reject_unknown(key, frozenset(PARAMETERS), "reference", path)
        reference[key] = _number(entry, key, "reference", path)[0]
        if is_positive(key) and reference[key] <= 0:
            raise VehicleError(
                f"found {reference[key]:g}, expected more than 0", path=path, place=f"[reference] {key}"
            )
    unknown_text = TEXT_KEYS | VEHICLE_KEYS
    for key in main:
        _reject_unknown(key, unknown_text, "vehicle", path)
    if "id" in texts and not texts["id"].strip():
        raise VehicleError("found no text, expected a name", path=path, place="[vehicle] id")
    _check_body(texts.get("body"), path)
    _check_choices(texts, path)
    vehicle = Vehicle(
        name=texts.get("name"),
        body=texts.get("body"),
        quantities=_quantities(main, "vehicle", VEHICLE_KEYS, path),
        load=_quantities(_table(raw, "load", path), "load", LOAD_KEYS, path),
        sensors=_quantities(_table(raw, "sensors", path), "sensors", SENSOR_KEYS, path),
        trailer=_quantities(_table(raw, "trailer", path), "trailer", TRAILER_KEYS, path),
        reference=reference,
        path=path,
        suspension_map_path=_beside(texts.get("suspension_map"), path),
        id=texts["id"].strip() if "id" in texts else None,
        powertrain=texts.get("powertrain"),
        self_levelling=texts.get("self_levelling"),
        deflection_zero=texts.get("deflection_zero"),
        axle_load_by=texts.get("axle_load_by"),
        recorded_on=texts.get("recorded_on"),
    )
    if vehicle.deflection_zero == "loaded" and any(key in vehicle.sensors for key in ZERO_KEYS):
        raise VehicleError(
            'found "loaded" beside what the deflection sensors show with the empty vehicle', path=path,
            place="[vehicle] deflection_zero", hint="leave out one of the two",
        )  # fmt: skip
    check_plausible(vehicle, path)
    check_kinematics(vehicle.quantities, path)
    _check_geometry(vehicle, path)
    return vehicle


CHOICES = {
    "powertrain": POWERTRAINS,
    "self_levelling": LEVELLING,
    "deflection_zero": ZEROS,
    "axle_load_by": AXLE_LOADS,
    "recorded_on": RECORDED,
}
"""Texts that are one of a few words."""


def _check_choices(texts: Mapping[str, str], path: Path) -> None:
    """Raise VehicleError for a word that is none of a key's."""
    for key, choices in CHOICES.items():
        if key in texts and texts[key] not in choices:
            expected = ", ".join(map(repr, choices))
            raise VehicleError(
                f"found {texts[key]!r}, expected one of {expected}", path=path, place=f"[vehicle] {key}"
            )


def _check_body(body: str | None, path: Path) -> None:
    """Raise VehicleError for a slip of the pen, which would cost the prior without a word; other styles are none."""
    if body is None:
        return
    if known_body(body) is None and (near := near_body(body)) is not None:
        hint = f"did you mean {near!r}?"
        raise VehicleError(f"unknown body style {body!r}", path=path, place="[vehicle] body", hint=hint)


def _beside(name: str | None, path: Path) -> Path | None:
    """A file that a vehicle file names: taken from its folder. Raises VehicleError for a name that no file can have."""
    if name is None:
        return None
    if not name.strip() or "\0" in name:
        raise VehicleError(
            f"found {name!r}, expected a file's name", path=path, place="[vehicle] suspension_map"
        )
    return path.parent / name


def with_suspension_map(vehicle: Vehicle, path: Path) -> Vehicle:
    """The vehicle with the suspension map of that file. Raises VehicleError where it cannot be read or is wrong."""
    from pipelines.suspension_mapping.file import read_suspension_map

    return replace(vehicle, suspension_map=read_suspension_map(path), suspension_map_path=path)


MOST_UNSPRUNG = 0.45
"""Of the mass: an empty truck's chassis has a third."""


def _check_geometry(vehicle: Vehicle, path: Path) -> None:
    """Refuse what cannot be: a vehicle that is mostly axles, a CG outside the wheelbase."""
    mass = vehicle.get("mass_kg")
    unsprung = sum(
        q.value for k in ("unsprung_mass_front_kg", "unsprung_mass_rear_kg") if (q := vehicle.get(k))
    )
    if mass and unsprung > MOST_UNSPRUNG * mass.value:
        raise VehicleError(
            f"unsprung masses sum to {unsprung:g} kg, the vehicle has {mass.value:g} kg: no road vehicle has more than "
            f"{MOST_UNSPRUNG:.0%} of it in axles and wheels",
            path=path,
            place="[vehicle]",
        )
    wheelbase, a = vehicle.get("wheelbase_m"), vehicle.get("cg_to_front_axle_m")
    if wheelbase and a and a.value >= wheelbase.value:
        raise VehicleError(
            f"cg_to_front_axle_m {a.value:g} is not inside the wheelbase {wheelbase.value:g}",
            path=path,
            place="[vehicle]",
        )


def read_vehicle(path: Path, *, with_map: bool = True) -> Vehicle:
    """Read a vehicle file, and the suspension map that it names (with_map).

    Raises VehicleError where one cannot be read or is wrong.
    """
    try:
        text = read_small_text(path)
    except OSError as error:
        raise VehicleError(f"cannot be read ({error.strerror})", path=path) from error
    except UnicodeDecodeError as error:
        raise VehicleError("not UTF-8 text", path=path, place=f"byte {error.start}") from error
    vehicle = parse_vehicle(text, path)
    if vehicle.suspension_map_path is None or not with_map:
        return vehicle
    try:
        return with_suspension_map(vehicle, vehicle.suspension_map_path)
    except VehicleError as error:
        raise VehicleError(str(error), path=path, place="[vehicle] suspension_map") from error
