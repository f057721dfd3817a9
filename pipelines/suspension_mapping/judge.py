"""A suspension map against measuring wheels: the error tables of Chapter 9, for training and for other drives."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive
from parsers.errors import LogError
from parsers.signals import WHEELS
from pipelines.models.suspension_map import GRAVITY
from pipelines.suspension_mapping.apply import KINDS, Mapped, WheelError, apply_map, errors_against
from pipelines.suspension_mapping.data import MEASURED, MapData, collect, narrowed, prepare_map
from pipelines.suspension_mapping.record import SuspensionMap


@dataclass(frozen=True)
class Judged:
    """One drive by one part of the map. wheels: wheel -> error; ratio: RMS over all wheels by that in training.

    load_kg: how much more the suspension carries than in training.
    """

    log: str
    sha256: str
    kind: str
    form: str
    duration_s: float
    wheels: Mapping[str, WheelError]
    ratio: float
    load_kg: float

    @property
    def rms_n(self) -> float:
        """Over all wheels."""
        return math.sqrt(sum(e.rms_n**2 for e in self.wheels.values()) / len(self.wheels))


def training_rms_n(record: SuspensionMap, kind: str) -> float:
    """RMS of the training residual over all wheels."""
    return math.sqrt(float(np.mean([w.rms_n**2 for w in record.parts[kind].wheels.values()])))


def judge_data(
    record: SuspensionMap, data: MapData, kind: str
) -> tuple[Mapped, Mapping[str, WheelError]] | None:
    """One part of the map on a drive's rows; None where the drive lacks what it stands on."""
    if data.band_hz > 1.01 * record.band_hz:
        data = narrowed(data, record.band_hz)
    mapped = apply_map(record, data, kind)
    return None if mapped is None else (mapped, errors_against(mapped, data))


def judge(record: SuspensionMap, drive: Drive, log: str) -> tuple[Judged, ...]:
    """Every part of the map that the drive serves. Raises LogError where it has no measuring wheel or nothing to map from."""
    if not any(name in drive.signals for name in MEASURED):
        raise LogError(
            "cannot validate: no tire_normal_force_fl …", path=log,
            hint="validation compares with wheel-force transducers; `cogest analyze --suspension-map` needs none",
        )  # fmt: skip
    data = collect(prepare_map(drive, record.band_hz))
    found = []
    for kind in KINDS:
        done = judge_data(record, data, kind)
        if done is None or not done[1]:
            continue
        mapped, errors = done
        rms = math.sqrt(sum(e.rms_n**2 for e in errors.values()) / len(errors))
        trained = [record.parts[kind].wheels[w].rms_n for w in WHEELS if w in errors]
        base = math.sqrt(sum(r * r for r in trained) / len(trained))
        load = sum(w.load_n for w in mapped.wheels.values()) / GRAVITY
        found.append(
            Judged(
                log, drive.record.sha256, kind, mapped.form, data.size / data.rate_hz, errors,
                rms / base if base > 0 else math.inf, load,
            )
        )  # fmt: skip
    if not found:
        raise LogError(
            f"cannot validate: the map stands on {' or '.join(record.parts)}, this log has neither for all wheels",
            path=log,
            hint="; ".join(data.notes[:2]) or None,
        )
    return tuple(found)
