"""The published filters, set up: parameters with their first guesses and learning rates, collocation, gates, inputs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.chaos.bases import legendre
from pipelines.chaos.collocation import Collocation, collocate
from pipelines.chaos.space import Space
from pipelines.estimators.load_transfer.kernels import HFLTM, INPUTS, LTM, MLTM, run
from pipelines.models.load_transfer import Motion, Size, rotation
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray

TABLE_HZ = 1000.0
"""The rate that the tables' additions and variances belong to."""

MASSES = ("m_fl", "m_fr", "m_rl", "m_rr")
NAMES: dict[int, tuple[str, ...]] = {
    LTM: ("m", "a", "l", "h_r", "h_p", "C"),
    MLTM: (*MASSES, "h_r", "h_p", "C"),
    HFLTM: (*MASSES, "h_rfl", "h_rfr", "h_rr", "h_pf", "h_pr"),
}
"""Parameters of each model in the order of its state: (112), (127), (143)."""

START: dict[int, tuple[tuple[float, float], ...]] = {
    LTM: ((2000.0, 100.0), (2.0, 0.2), (0.8, 0.1), (1.0, 0.5), (1.0, 0.5), (1.0, 0.5)),
    MLTM: (*((400.0, 100.0),) * 4, (1.0, 0.5), (1.0, 0.5), (1.0, 0.5)),
    HFLTM: (*((400.0, 100.0),) * 4, *((1.0, 0.5),) * 5),
}
"""(114), (134), (142): first guess and its half width (the second coefficient on Legendre's P1 = mu)."""

ADDED: dict[int, tuple[float, ...]] = {
    LTM: (1e-7, 1e-9, 1e-9, 1e-9, 1e-9, 1e-10),
    MLTM: (1e-7, 1e-7, 1e-7, 1e-7, 1e-9, 1e-9, 1e-10),
    HFLTM: (1e-8, 1e-8, 1e-8, 1e-8, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6),
}
"""c of Tables 6.1, 7.1, 8.1, times the second coefficient of the first guess [a step of 1 ms]."""

FORCE_VARIANCE, BOUNCE_VARIANCE = 10.0, 100.0
"""R of the tables, N²."""


@dataclass(frozen=True)
class FilterSettings:
    """How a filter runs. order, factor: of the expansion and of its points. form: 0 as published, 1 square root.

    variance, bounce_variance: R, N². added: c a step of 1 ms, relative to each first half width. start: first guesses and
    half widths. gate: [g] of horizontal force below which an arm that it drives is held, 0 = none. calm: [g] of lateral force above which
    masses and place are held.
    """

    order: int
    factor: float
    form: int
    variance: float
    bounce_variance: float
    added: tuple[float, ...]
    start: tuple[tuple[float, float], ...]
    gate: float = 0.0
    calm: float = math.inf


@dataclass(frozen=True)
class FilterRun:
    """names of the parameters; track, spread (k, d) after rows `at` (k,); predicted (n, m) N before each update."""

    names: tuple[str, ...]
    track: FloatArray
    spread: FloatArray
    at: np.ndarray
    predicted: FloatArray
    terms: int
    points: int


def table_settings(model: int) -> FilterSettings:
    """Tables 6.1, 7.1, 8.1 taken literally: first order, as many points as terms, R = 10 N², collapsing spread."""
    gate = 0.05 if model == HFLTM else 0.0
    return FilterSettings(1, 1.0, 0, FORCE_VARIANCE, BOUNCE_VARIANCE, ADDED[model], START[model], gate)


def collocation_of(model: int, settings: FilterSettings, rng: np.random.Generator) -> Collocation:
    """Points for a model's parameters, uniform each: Hammersley's, or drawn where there are hardly more than terms."""
    space = Space(tuple(legendre() for _ in NAMES[model]))
    if settings.factor < 2:
        return collocate(space, settings.order, factor=settings.factor, kind="random", rng=rng)
    return collocate(space, settings.order, factor=settings.factor)


def inputs_of(motion: Motion, corners: FloatArray, size: Size) -> FloatArray:
    """(n, INPUTS) for the kernel. corners (n, 4): vertical specific force over the struts; motion in the road plane."""
    roll, pitch = rotation(corners, size)
    found = np.empty((len(corners), INPUTS))
    found[:, :4] = corners
    found[:, 4] = corners.mean(axis=1)
    found[:, 5], found[:, 6], found[:, 7] = motion.across, motion.along, motion.speed**2
    # as the kernel wants them: the CG's place as a share
    found[:, 8], found[:, 9] = roll * size.track, pitch * size.wheelbase
    found[:, 10], found[:, 11] = motion.accel_y / GRAVITY, motion.accel_x / GRAVITY
    return found


def run_filter(
    model: int, motion: Motion, corners: FloatArray, forces: FloatArray, size: Size, settings: FilterSettings,
    rate_hz: float, rng: np.random.Generator, points: int = 400,
) -> FilterRun:  # fmt: skip
    """Run a published filter over a drive.

    motion, corners (n, 4), forces (n, 4) N at rate_hz; additions and variances are brought from 1 kHz to that rate, so
    that it learns as much a second. The LTM takes motion.vertical for A_z, the others the corners' (117).
    """
    steps = TABLE_HZ / rate_hz
    chosen = collocation_of(model, settings, rng)
    inputs = inputs_of(motion, corners, size)
    if model == LTM:
        inputs[:, 4] = motion.vertical
    measured, noise = forces, np.full(4, settings.variance)
    if model != HFLTM:
        measured = np.column_stack((forces, forces.sum(axis=1)))
        noise = np.append(noise, settings.bounce_variance)
    start = np.array(settings.start)
    d, terms = len(start), len(chosen.indices)
    x = np.zeros((d, terms))
    x[:, 0] = start[:, 0]
    # P1 = mu is the first orthonormal polynomial over sqrt(3)
    width = start[:, 1] / np.sqrt(3.0)
    x[np.arange(d), 1 + np.arange(d)] = width
    every = max(1, len(forces) // points)
    track, spread = np.empty((len(forces) // every, d)), np.empty((len(forces) // every, d))
    predicted = np.empty_like(measured)
    run(
        model, inputs, np.ascontiguousarray(measured), (size.wheelbase, size.track), x,
        np.array(settings.added) * width * steps, noise / steps, np.ascontiguousarray(chosen.matrix.T),
        np.ascontiguousarray(chosen.inverse.T), settings.form, _gates(model, settings), every, track, spread,
        predicted,
    )  # fmt: skip
    at = np.arange(every - 1, len(track) * every, every)
    return FilterRun(NAMES[model], track, spread, at, predicted, terms, len(chosen.points))


def _gates(model: int, settings: FilterSettings) -> FloatArray:
    """(d, 3) limits by parameter: least |A_y| of roll arms, least |A_x| of pitch arms and drag, largest |A_y| of all others."""
    rows = []
    for name in NAMES[model]:
        roll, pitch = name.startswith("h_r"), name.startswith(("h_p", "C"))
        rows.append(
            (settings.gate * roll, settings.gate * pitch, math.inf if roll or pitch else settings.calm)
        )
    return np.array(rows, dtype=np.float64)
