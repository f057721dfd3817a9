"""The marginalised particle filter over one drive (Algorithm 2 of Berntorp et al.)."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy

import numpy as np

from parsers.channels import IntArray
from pipelines.filters.lanes import LANES, random_state
from pipelines.filters.marginalized_particle.clouds import Given, cloud_of, uniform_cloud
from pipelines.filters.marginalized_particle.kernels import run
from pipelines.filters.marginalized_particle.layout import (
    LOG,
    THETA,
    WEIGHT,
    WIDTH2,
    WIDTH5,
    WIDTH_SENSED,
    Record,
    Rules,
    Signals,
    Start,
    columns_of,
    tiled,
    tiles_of,
)
from pipelines.filters.marginalized_particle.records import (
    PARAMETERS,
    QUANTILES,
    Cloud,
    Noise,
    Offsets,
    ParticleRun,
    ParticleSettings,
)
from pipelines.results import FloatArray

__all__ = ["Given", "cloud_of", "run_particles", "uniform_cloud"]

Segments = tuple[IntArray, IntArray]


def _check(
    y: FloatArray,
    accel: FloatArray,
    step_s: float,
    segments: Segments,
    settings: ParticleSettings,
    snapshots: Sequence[int],
) -> None:
    rows = len(accel)
    if rows < 1 or accel.shape != (rows,) or y.shape != (rows, 2):
        raise ValueError(f"measurements are (n, 2) and acceleration (n,), not {y.shape} and {accel.shape}")
    if not (np.isfinite(step_s) and step_s > 0):
        raise ValueError(f"the step is a positive time, not {step_s}")
    starts, stops = segments
    inside = len(starts) == len(stops) and len(starts) > 0 and starts[0] >= 0 and stops[-1] <= rows
    if not (inside and (starts < stops).all() and (starts[1:] >= stops[:-1]).all()):
        raise ValueError("segments are not empty, follow each other and stay within the drive")
    if any(not np.isfinite(accel[start:stop]).all() for start, stop in zip(starts, stops, strict=True)):
        raise ValueError("the acceleration has values that are not finite; fill or cut them first")
    if any(not 0 <= row < rows for row in snapshots):
        raise ValueError("a snapshot lies outside the drive")
    check_settings(settings)


def check_settings(settings: ParticleSettings) -> None:
    """Raise ValueError where the settings ask for no filter."""
    counts = (settings.wanted, settings.most, 1 if settings.fixed is None else settings.fixed)
    spreads = (settings.start_roll_rad, settings.start_rate_radps)
    if min(counts) < 1 or min(*settings.walk, settings.kernel, settings.threshold) < 0:
        raise ValueError("there is at least one particle, and walk, kernel and threshold are not negative")
    if settings.kernel >= 1:
        raise ValueError(f"a smoothed move has a bandwidth below one, not {settings.kernel}")
    if min(spreads) <= 0:
        raise ValueError("the first state has a positive spread")


def _rules(settings: ParticleSettings, noise: Noise, step_s: float, most: int, own: bool) -> Rules:
    return Rules(
        step=float(step_s),
        gravity=float(settings.gravity_mps2),
        r0=noise.roll_rad**2,
        r1=noise.roll_rate_radps**2,
        q=noise.accel_mps2**2,
        threshold=float(settings.threshold),
        kernel=float(settings.kernel),
        offsets=int(settings.offsets is not None or settings.sensed_input),
        hold=int(settings.first_order_hold),
        mirror=int(settings.above_mirror),
        sensed=int(settings.sensed_input),
        adaptive=int(settings.adaptive),
        fixed=0 if settings.fixed is None else int(settings.fixed),
        wanted=int(settings.wanted),
        most=most,
        every=int(settings.quantiles_every),
        own=int(own),
    )


def _record(rows: int, snapshots: int, most: int) -> Record:
    def empty(*shape: int) -> FloatArray:
        return np.full(shape, np.nan)

    return Record(
        mean=empty(rows, 3),
        std=empty(rows, 3),
        quantiles=empty(rows, len(PARAMETERS), len(QUANTILES)),
        particles=np.zeros(rows, dtype=np.int64),
        effective=empty(rows),
        state=empty(rows, 5),
        state_std=empty(rows, 5),
        log_likelihood=empty(rows),
        innovation=empty(rows, 2),
        innovation_std=empty(rows, 2),
        survivors=np.zeros(rows, dtype=np.int64),
        kept=np.empty((snapshots, most if snapshots else 1, 7)),
        kept_count=np.zeros(snapshots, dtype=np.int64),
    )


def run_particles(
    y: FloatArray,
    accel: FloatArray,
    step_s: float,
    prior: Cloud,
    noise: Noise,
    settings: ParticleSettings,
    rng: np.random.Generator,
    *,
    segments: Segments | None = None,
    snapshots: Sequence[int] = (),
) -> ParticleRun:
    """Algorithm 2 over a drive.

    y: (n, 2) roll in rad and roll rate in rad/s, NaN where not measured. accel: (n,) lateral acceleration in m/s², finite.
    segments: first rows and rows past the last; each starts its roll anew, with the particles and offsets that are there
    (None: one segment). Rows outside are NaN in the result. snapshots: rows whose weighted particles are kept.
    Raises ValueError where shapes, step, segments or settings do not fit, or the acceleration is not finite.
    """
    y = np.ascontiguousarray(y, dtype=np.float64)
    accel = np.ascontiguousarray(accel, dtype=np.float64)
    whole = (np.array([0]), np.array([len(accel)]))
    segments = whole if segments is None else segments
    _check(y, accel, step_s, segments, settings, snapshots)
    count = len(prior.weights)
    most = max(settings.most, count, 0 if settings.fixed is None else settings.fixed)
    given = prior.theta[:, len(PARAMETERS) :]
    rules = _rules(settings, noise, step_s, settings.most, bool((given != given[0]).any()))
    rows = np.unique(np.array(list(snapshots), dtype=np.int64))
    record = _record(len(accel), len(rows), most)
    if settings.offsets is None:
        record.state[:, 2:], record.state_std[:, 2:] = 0.0, 0.0
    width = WIDTH_SENSED if settings.sensed_input else WIDTH2 if settings.offsets is None else WIDTH5
    table, spare = _tables(prior, most, width)
    signals = Signals(
        y,
        accel,
        np.asarray(segments[0], dtype=np.int64),
        np.asarray(segments[1], dtype=np.int64),
        np.asarray(settings.walk, dtype=np.float64),
        rows,
    )
    random = random_state(rng)
    # as many as there could be; the generator itself moves on by those that were taken, so that what comes after does not hang on the length
    chances = deepcopy(rng).random(len(accel))
    left, lost, holds = run(
        chances,
        random,
        signals,
        _start(settings),
        rules,
        (table, spare),
        (table.reshape(-1), spare.reshape(-1)),
        count,
        record,
    )
    rng.random(int(np.count_nonzero(record.survivors)))
    final = columns_of((table, spare)[holds], left, WEIGHT // LANES + 1)
    cloud = Cloud(np.ascontiguousarray(final[:, :THETA]), np.ascontiguousarray(final[:, WEIGHT // LANES]))
    return _result(record, lost, cloud, rows, np.isfinite(y))


def _tables(prior: Cloud, most: int, width: int) -> tuple[FloatArray, FloatArray]:
    """Two of (tiles, width) with room for `most` particles, the prior's and their weights in the first."""
    table, spare = (tiled(prior.theta, tiles_of(most), width) for _ in range(2))
    weights = prior.weights / prior.weights.sum()
    where = np.arange(len(weights))
    with np.errstate(divide="ignore"):
        table[where // LANES, LOG + where % LANES] = np.log(weights)
    table[where // LANES, WEIGHT + where % LANES] = weights
    return table, spare


def _start(settings: ParticleSettings) -> Start:
    offsets = settings.offsets or Offsets(0.0, 0.0, 0.0)
    return Start(
        roll=settings.start_roll_rad**2,
        rate=settings.start_rate_radps**2,
        roll_offset=offsets.roll_rad**2,
        rate_offset=offsets.roll_rate_radps**2,
        accel_offset=offsets.accel_mps2**2,
    )


def _result(
    record: Record, lost: int, final: Cloud, rows: IntArray, measured: np.typing.NDArray[np.bool_]
) -> ParticleRun:
    snapshots = {
        int(row): Cloud(record.kept[i, :count, :6].copy(), record.kept[i, :count, 6].copy())
        for i, (row, count) in enumerate(zip(rows, record.kept_count, strict=True))
        if count
    }
    return ParticleRun(
        mean=record.mean,
        std=record.std,
        quantiles=record.quantiles,
        particles=record.particles,
        effective=record.effective,
        state=record.state,
        state_std=record.state_std,
        log_likelihood=record.log_likelihood,
        innovation=np.where(measured, record.innovation, np.nan),
        innovation_std=np.where(measured, record.innovation_std, np.nan),
        survivors=record.survivors,
        lost=lost,
        final=final,
        snapshots=snapshots,
    )
