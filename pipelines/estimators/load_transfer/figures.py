"""Tracks and traces of the strut-force estimators for the report."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.signals import WHEELS
from pipelines.estimators.load_transfer.batch import LOOSE, STATIC, TOGETHER, BatchFit
from pipelines.estimators.load_transfer.data import Known, StrutData
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray, ParameterEstimate, Trace, Track

TRACK_POINTS = 40


def force_traces(
    name: str,
    data: StrutData,
    prepared: Prepared,
    fitted: FloatArray,
    words: str = "strut force of the whole drive",
) -> tuple[Trace, ...]:
    """Measured and fitted force of each strut with the difference; NaN between runs."""
    found = []
    for i, wheel in enumerate(WHEELS):
        columns = {"measured": data.forces[:, i], "model": fitted[:, i]}
        columns["residual"] = columns["measured"] - columns["model"]
        full = {}
        for key, values in columns.items():
            out = np.full(len(prepared.time_s), np.nan)
            out[data.rows] = values
            full[key] = out
        found.append(
            Trace(f"{name}: strut force {wheel}", prepared.time_s, full, dict.fromkeys(full, "N"), words)
        )
    return tuple(found)


def mass_tracks(
    found: BatchFit, data: StrutData, known: Known, parameters: Mapping[str, ParameterEstimate]
) -> tuple[Track, ...]:
    """Mass and CG place from the first stretches on, scaled to the answers; the sensors' part stays as wide."""
    blocks = len(found.edges)
    ends = np.unique(np.linspace(min(3, blocks), blocks, min(TRACK_POINTS, blocks)).round().astype(int))
    noise = float(np.sqrt(np.mean(found.residual**2)))
    ridge = np.diag(noise**2 * TOGETHER / LOOSE**2)
    products, targets = np.cumsum(found.products, axis=0), np.cumsum(found.targets, axis=0)
    loads = np.array([np.linalg.solve(products[e - 1] + ridge, targets[e - 1])[STATIC] for e in ends])
    total = loads.sum(axis=1)
    halves = 0.5 * np.array(
        [known.track[0].value, -known.track[0].value, known.track[1].value, -known.track[1].value]
    )
    own = {
        "mass_kg": total / GRAVITY,
        "cg_to_front_axle_m": known.wheelbase.value * (loads[:, 2] + loads[:, 3]) / total,
        "cg_lateral_offset_m": loads @ halves / total,
    }
    past = np.append(found.edges[1:], data.size) - 1
    time_s = data.time_s[past[ends - 1]]
    tracks = []
    for name, values in own.items():
        entry = parameters.get(name)
        if entry is None or entry.value is None or entry.std is None:
            continue
        value = entry.value + values - values[-1]
        # the path still to go is a measure of what the data so far leave open
        left = np.abs(values - values[-1])
        half = 1.96 * np.hypot(entry.std, left)
        tracks.append(Track(name, time_s, value, value - half, value + half))
    return tuple(tracks)
