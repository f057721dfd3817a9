"""Train a suspension map: drives with measuring wheels in, a map out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from parsers.signals import WHEELS
from pipelines.results import FloatArray
from pipelines.suspension_mapping.data import DEFLECTIONS, STRUTS
from pipelines.suspension_mapping.fit import Fitted, Known, fit, held_out, prior_of, stack
from pipelines.suspension_mapping.record import MapPart, Seen, SuspensionMap, WheelMap
from pipelines.suspension_mapping.regressors import FORMS, Shape, Springs
from pipelines.suspension_mapping.sample import (
    Sample,
    Training,
    known_of,
    sample_of,
    spring_law,
    thinned,
    training_drive,
)
from pipelines.suspension_mapping.spread import fit_spread
from pipelines.vehicles.usual import STRUT_SCALE, STRUT_ZERO_N
from pipelines.vehicles.vehicle import Vehicle

__all__ = ["choose_form", "train", "training_drive"]

TRAVELS_M = (0.001, 0.002, 0.004)
"""Deflections over which dry friction may turn over; the one of the least error is taken."""
RIDE_HEIGHTS_M = (0.12, 0.16, 0.21, 0.28, 0.4, 0.6)
"""h_s of (149)-(150): the one of the least error is taken; the dissertation has 0.21 m."""
SCALE_SHARE = STRUT_SCALE
"""Standard deviation over the force of the measuring wheels' own scale, which no training can see, and of what that of a strut changes from
drive to drive: as in all estimators by strut forces, with their zeros (STRUT_ZERO_N), which drift from drive to drive. An assumption."""
DRIFT_WEIGHT = 4.0
"""How many training drives' scatter the assumed drift is worth."""
USUAL_TRACK_M = 1.6
FAR_LEVER, LEVER_STD = 0.08, 0.04
"""From this difference to 1 on, the force sensors are taken for ones with a lever (struts that lean); std of that lever."""
THIN = 4
"""Of the rows, every fourth serves to compare shapes."""
WORTH = 0.9
"""A richer form must take the held-out error to this share of a simpler one's: left-out manoeuvres carry the load of the
others, and what a form wins by less it loses under another load."""


@dataclass(frozen=True)
class Trial:
    """A form fitted to one wheel: names of the regressors that there are, the fit, residuals of manoeuvres left out (n, 2)."""

    names: tuple[str, ...]
    fitted: Fitted
    left_out: FloatArray

    @property
    def square(self) -> float:
        """Mean square of the left-out residuals."""
        return float(np.mean(self.left_out**2))


def _setting(
    sample: Sample, form: str, regressors: tuple[str, ...], known: Known, kind: str
) -> tuple[tuple[str, ...], tuple[FloatArray, FloatArray]]:
    """The form's regressors that there are, and the prior of their coefficients."""
    names = tuple(name for name in regressors if name in sample.columns)
    force = float(np.mean(sample.measured))
    mean, std = prior_of(names, force, known, kind == "springs")
    own = np.array([name == "carried" for name in names])
    lever = (force - known.weight_n(force)) / max(float(np.mean(sample.columns["carried"])), 1e-9)
    if abs(lever - 1) > FAR_LEVER and kind == "struts":
        # a strut's own force, not brought to the wheel: the lever between them is learned
        mean, std = np.where(own, lever, mean), np.where(own, LEVER_STD * lever, std)
    if form == "published":
        # (146) takes the suspension's force as it is
        std = np.where(own, 1e-6, std)
    return names, (mean, std)


def _try(sample: Sample, form: str, regressors: tuple[str, ...], known: Known, kind: str) -> Trial:
    """Fit a form to a wheel."""
    names, prior = _setting(sample, form, regressors, known, kind)
    matrix = stack(sample.columns, names)
    found = fit(matrix, sample.measured, prior, sample.starts, sample.rate_hz)
    ways = [held_out(matrix, sample.measured, prior, found, g) for g in (sample.fold, sample.kind)]
    return Trial(names, found, np.column_stack(ways))


def _forms(sample: Sample, kind: str) -> dict[str, tuple[str, ...]]:
    """Forms whose regressors are there; a richer one that adds nothing for lack of signals is left out."""
    found: dict[str, tuple[str, ...]] = {}
    for name, regressors in FORMS[kind].items():
        there = tuple(r for r in regressors if r in sample.columns)
        if name == "published" and len(there) < len(regressors):
            continue
        if there not in [tuple(r for r in other if r in sample.columns) for other in found.values()]:
            found[name] = regressors
    return found


def _zero_n(sample: Sample, residual: FloatArray) -> float:
    """Standard deviation of the zeros' drift, N: the assumed one, moved by the scatter of the drives' mean residuals."""
    force, drives = float(np.mean(sample.measured)), int(sample.drive[-1]) + 1
    means = np.array([np.mean(residual[sample.drive == k]) for k in range(drives)])
    scatter = float(np.sum((means - np.mean(means)) ** 2))
    assumed = STRUT_ZERO_N**2 + (SCALE_SHARE * force) ** 2
    drift = (DRIFT_WEIGHT * assumed + scatter) / (DRIFT_WEIGHT + drives - 1)
    return float(np.sqrt(drift * (1 + 1 / drives) / 2 + (SCALE_SHARE * force) ** 2))


def _wheel_map(sample: Sample, trial: Trial) -> WheelMap:
    spread, factor = fit_spread(trial.left_out, sample.state)
    residual = trial.fitted.residual
    worst = int(np.argmax(np.abs(residual)))
    seen = {}
    for name in trial.names:
        column = sample.columns[name]
        low, high = (float(q) for q in np.quantile(column, (0.001, 0.999)))
        seen[name] = Seen(low, high, float(np.mean(column)), float(np.std(column)))
    return WheelMap(
        coefficients=dict(zip(trial.names, trial.fitted.coefficients.tolist(), strict=True)),
        covariance=trial.fitted.covariance,
        seen=seen,
        spread=spread,
        factor=factor,
        carried_n=float(np.mean(sample.columns["carried"])),
        zero_n=_zero_n(sample, residual),
        rms_n=float(np.sqrt(np.mean(residual**2))),
        peak_n=float(residual[worst]),
        peak_s=float(sample.time_s[worst]),
        held_out_n=float(np.sqrt(trial.square)),
    )


def _shape_error(
    drives: Sequence[Training],
    kind: str,
    form: str,
    laws: Mapping[str, Springs],
    known: Mapping[str, Known],
    shape: Shape,
) -> float:
    """Sum over the wheels of the training residual's mean square."""
    total = 0.0
    for wheel in WHEELS:
        sample = thinned(sample_of(drives, wheel, kind, laws, shape), THIN)
        names, prior = _setting(sample, form, FORMS[kind][form], known[wheel], kind)
        found = fit(stack(sample.columns, names), sample.measured, prior, sample.starts, sample.rate_hz)
        total += float(np.mean(found.residual**2))
    return total


def _best_shape(
    drives: Sequence[Training],
    kind: str,
    laws: Mapping[str, Springs],
    known: Mapping[str, Known],
    shape: Shape,
) -> Shape:
    """The friction's travel and h_s of the least error over all wheels; the richest form serves for the former."""
    if not all(t.data.has(DEFLECTIONS) for t in drives):
        return shape

    def error(trial: Shape, form: str) -> float:
        return _shape_error(drives, kind, form, laws, known, trial)

    friction = "friction" if kind == "struts" else "springs_friction"
    travels = {x: error(replace(shape, friction_travel_m=x), friction) for x in TRAVELS_M}
    shape = replace(shape, friction_travel_m=min(travels, key=lambda x: travels[x]))
    if kind == "struts":
        heights = {x: error(replace(shape, ride_height_m=x), "published") for x in RIDE_HEIGHTS_M}
        shape = replace(shape, ride_height_m=min(heights, key=lambda x: heights[x]))
    return shape


def choose_form(errors: Mapping[str, float]) -> str:
    """The form to keep of those tried, from plain to rich: a richer one where it is worth it (WORTH). errors: form -> N."""
    names = list(errors)
    best = names[0]
    for name in names[1:]:
        if errors[name] < WORTH * errors[best]:
            best = name
    return best


def _part(
    drives: Sequence[Training],
    kind: str,
    laws: Mapping[str, Springs],
    known: Mapping[str, Known],
    shape: Shape,
    form: str | None,
) -> MapPart:
    """One part of the map; form: that one, None = the one that left-out manoeuvres choose."""
    samples = {w: sample_of(drives, w, kind, laws, shape) for w in WHEELS}
    errors: dict[str, float] = {}
    for name, regressors in _forms(samples["fl"], kind).items():
        if form in (None, name):
            squares = [_try(thinned(samples[w], 2), name, regressors, known[w], kind).square for w in WHEELS]
            errors[name] = float(np.sqrt(np.mean(squares)))
    best = choose_form(errors)
    trials = {w: _try(samples[w], best, FORMS[kind][best], known[w], kind) for w in WHEELS}
    return MapPart(kind, best, {w: _wheel_map(samples[w], trials[w]) for w in WHEELS}, laws, errors)


def train(
    drives: Sequence[Training], vehicle: Vehicle, name: str, forced: Mapping[str, str] | None = None
) -> SuspensionMap:
    """Fit all forms and keep the best of each kind. drives: one or more of one vehicle; name: the vehicle's.

    forced: only these kinds, each with this form, to compare forms.

    Raises ValueError without a drive.
    """
    if not drives:
        raise ValueError("no drive to train on")
    known = {w: known_of(vehicle, w) for w in WHEELS}
    tracks = [q.value for k in ("track_front_m", "track_rear_m") if (q := vehicle.get(k)) is not None]
    shape = Shape(track_m=sum(tracks) / len(tracks) if tracks else USUAL_TRACK_M)
    kinds = [
        kind
        for kind, names in (("struts", STRUTS), ("springs", DEFLECTIONS))
        if all(t.data.has(names) for t in drives) and (forced is None or kind in forced)
    ]
    laws = {w: spring_law(drives, w, known[w]) for w in WHEELS} if "springs" in kinds else {}
    shape = _best_shape(drives, kinds[0], laws, known, shape)
    parts = {
        kind: _part(drives, kind, laws if kind == "springs" else {}, known, shape, (forced or {}).get(kind))
        for kind in kinds
    }
    zero = (
        f"assumed: drift of {STRUT_ZERO_N:.0f} N and {100 * SCALE_SHARE:.1f} %, scale of {100 * SCALE_SHARE:.1f} % of the static force"
        + (f", with the scatter over {len(drives)} training drives" if len(drives) > 1 else "")
    )
    return SuspensionMap(name, drives[0].data.band_hz, shape, tuple(t.drive for t in drives), parts, zero)
