"""The estimator "suspension_mapping": the four tyre normal forces over the drive, by a trained map."""

from __future__ import annotations

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.suspension_mapping.answers import (
    NAME,
    assumptions,
    diagnostics,
    nothing,
    parameter_name,
    parameters,
    remarks,
)
from pipelines.prepare.prepared import Prepared
from pipelines.results import Estimate, FloatArray, Trace
from pipelines.suspension_mapping.apply import KINDS, Mapped, apply_map, errors_against
from pipelines.suspension_mapping.data import BAND_HZ, MEASURED, MapData, collect, narrowed, prepare_map
from pipelines.tire_forces import TireForces, forces_as_traces
from pipelines.vehicles.vehicle import Vehicle

SETTINGS: tuple[Setting, ...] = (
    Setting(
        "band_hz", BAND_HZ, "Hz", "zero-phase low-pass of all signals; not above the map's own", 0.5, 50.0
    ),
)


class SuspensionMapping:
    """Suspension mapping, Chapter 9 of the dissertation: (146)-(150), or the linear form that held-out manoeuvres chose."""

    name: str = NAME
    title: str = "Tyre normal forces by suspension mapping"
    source: str = (
        "dissertation on generalized polynomial chaos estimation, Chapter 9, (146)-(150) with signs corrected; linear "
        "form with eta = 1 and friction, offset and interaction terms"
    )
    signal_needs: tuple[Need, ...] = tuple(
        Need((f"suspension_force_{w}", f"suspension_deflection_{w}"), "what the suspension carries")
        for w in WHEELS
    )
    vehicle_needs: tuple[Need, ...] = (
        Need(
            ("suspension_map",),
            "a map trained on a drive with measuring wheels, by `cogest suspension-map`; give it with --suspension-map",
        ),
    )
    parameters: tuple[str, ...] = tuple(map(parameter_name, WHEELS))
    settings: tuple[Setting, ...] = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """What the mapping uses, on one clock."""
        return prepare_map(drive, float(settings.get("band_hz", BAND_HZ)))

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Apply the map. Nothing is drawn. Signals that the map does not know give "not_identifiable"."""
        del settings, rng
        record = vehicle.suspension_map
        if record is None:
            return self._nothing(vehicle, "no suspension map: give one with --suspension-map")
        data = collect(prepared)
        if data.size == 0:
            return self._nothing(vehicle, "; ".join(prepared.notes) or "no usable stretch of the drive")
        if data.band_hz > 1.01 * record.band_hz:
            data = narrowed(data, record.band_hz)
        mapped = apply_map(record, data)
        if mapped is None:
            knows = " or ".join(f"{record_kind} ({KINDS[record_kind][0]} …)" for record_kind in record.parts)
            return self._nothing(
                vehicle, f"the map knows {knows}; this log does not have them for all wheels"
            )
        said = remarks(mapped, record, vehicle, data)
        errors = errors_against(mapped, data)
        remark = "".join(f"; {text}" for text in said)
        if errors:
            rms = ", ".join(f"{w} {e.rms_n:.0f}" for w, e in errors.items())
            said.append(f"RMS error against the measuring wheels {rms} N")
        return Estimate(
            self.name, "ran", "; ".join((f"from {mapped.kind}, form {mapped.form!r}", *said)),
            parameters(mapped, data, vehicle, remark),
            traces=(*self._traces(prepared, data, mapped), *self._residuals(prepared, data, mapped)),
            assumptions=assumptions(record, mapped, data),
            diagnostics=diagnostics(mapped, data, errors),
            used_fraction=min(data.size / max(len(prepared.time_s), 1), 1.0),
        )  # fmt: skip

    def _nothing(self, vehicle: Vehicle, reason: str) -> Estimate:
        return Estimate(self.name, "ran", reason, nothing(vehicle, reason))

    @staticmethod
    def _whole(prepared: Prepared, data: MapData, values: FloatArray) -> FloatArray:
        """On the drive's whole clock, NaN in gaps."""
        out = np.full(len(prepared.time_s), np.nan)
        out[data.rows] = values
        return out

    def _traces(self, prepared: Prepared, data: MapData, mapped: Mapped) -> tuple[Trace, ...]:
        def each(what: str) -> dict[str, FloatArray]:
            return {w: self._whole(prepared, data, getattr(own, what)) for w, own in mapped.wheels.items()}

        forces = TireForces(
            prepared.time_s, each("force"), each("low"), each("high"), False, f"{self.name}, {mapped.kind}", data.band_hz
        )  # fmt: skip
        measured = {
            w: self._whole(prepared, data, data.columns[name])
            for w, name in zip(WHEELS, MEASURED, strict=True)
            if name in data.columns
        }
        return forces_as_traces(forces, measured, "low, high: the 95 % interval at each instant")

    def _residuals(self, prepared: Prepared, data: MapData, mapped: Mapped) -> tuple[Trace, ...]:
        columns = {
            f"residual {w}": self._whole(prepared, data, data.columns[name] - mapped.wheels[w].force)
            for w, name in zip(WHEELS, MEASURED, strict=True)
            if name in data.columns
        }
        if not columns:
            return ()
        note = "measured by wheel-force transducers less mapped"
        return (Trace("tyre normal force", prepared.time_s, columns, dict.fromkeys(columns, "N"), note),)
