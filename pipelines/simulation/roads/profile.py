"""Road surfaces: roughness of two wheel tracks with a given spectrum and coherence, humps, smooth grades and banks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.records import Road

Spectrum = Callable[[FloatArray], FloatArray]
"""One-sided displacement spectrum G_d(n) [m³] over spatial frequency n [cycles/m]."""

REFERENCE_FREQUENCY = 0.1
"""n0 of ISO 8608 [cycles/m]."""

CLASS_ROUGHNESS: dict[str, float] = {name: 16e-6 * 4.0**k for k, name in enumerate("ABCDEFGH")}
"""Geometric mean of G_d(n0) [m³] for each class of ISO 8608 (its table of classes by displacement spectrum)."""

_BAND = (0.01, 10.0)
"""Waves between 100 m and 0.1 m: longer ones are grade, shorter ones vanish under the tyre's contact patch."""


def even_places(rows: int, step: float) -> FloatArray:
    """0, step, 2 step …: (rows,)."""
    return np.asarray(step * np.arange(rows), dtype=np.float64)


def iso_spectrum(surface: str, scale: float = 1.0, waviness: float = 2.0) -> Spectrum:
    """G_d(n) = G_d(n0) (n / n0)^-w of ISO 8608, times scale, for 0.01 to 10 cycles/m; 0 outside."""
    level = CLASS_ROUGHNESS[surface] * scale

    def spectrum(n: FloatArray) -> FloatArray:
        inside = (n >= _BAND[0]) & (n <= _BAND[1])
        ratio = np.where(inside, n, REFERENCE_FREQUENCY) / REFERENCE_FREQUENCY
        return np.where(inside, level * ratio**-waviness, 0.0)

    return spectrum


def terrain_spectrum(level_m3: float) -> Spectrum:
    """Off-road terrain: c (n² + 0.1²)^-1.5 / (1 + n²), with c such that G_d(n0) is level_m3.

    Stands for the ARIMA(8,1,0) terrain of Pence, Fathy & Stein, whose coefficients are not printed; it gives the
    published trends. Flat below 0.1 cycles/m: terrain has no endless hills of this kind; falls off above 1 cycle/m.
    """

    def shape(n: FloatArray) -> FloatArray:
        return (n**2 + 0.1**2) ** -1.5 / (1 + n**2)

    factor = level_m3 / float(shape(np.array([REFERENCE_FREQUENCY], dtype=np.float64))[0])

    def spectrum(n: FloatArray) -> FloatArray:
        return np.where((n > 0) & (n <= _BAND[1]), factor * shape(n), 0.0)

    return spectrum


def track_coherence(n: FloatArray, track_m: float) -> FloatArray:
    """Cross spectrum over spectrum of two parallel tracks on an isotropic surface of waviness 2: x K1(x), x = 2π n b.

    1 for waves much longer than the track, 0 for short ones. Isotropy: Dodds and Robson (1973), in the closed form by
    Kamash and Robson (1977). The coherence in the usual sense is its square.
    """
    from scipy.special import k1

    x = 2 * np.pi * np.maximum(n, 1e-9) * track_m
    return np.asarray(np.clip(x * k1(x), 0.0, 1.0))


def roughness(
    spectrum: Spectrum,
    length_m: float,
    step_m: float,
    track_m: float,
    rng: np.random.Generator,
    *,
    periodic: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """Heights [m] of the left and right track, each (ceil(length/step) + 1,) at even steps: a Gaussian process.

    Each track has exactly the spectrum that was asked for (in the mean over draws), both have the coherence of an
    isotropic surface. periodic: the profile repeats after length_m without a step, for laps (then length/step rows).
    """
    rows = int(np.ceil(length_m / step_m - 1e-9)) + (0 if periodic else 1)
    # cut out of a longer period, so that the ends of an open road are not tied to each other
    period = rows if periodic else max(int(1.25 * rows), int(400 / step_m))
    period += period % 2 if not periodic else 0
    n = np.asarray(np.fft.rfftfreq(period, step_m), dtype=np.float64)
    density = np.zeros_like(n)
    density[1:] = spectrum(n[1:])
    # a bin of width dn holds the variance G dn
    amplitude = 0.5 * period * np.sqrt(density * n[1])
    draws = rng.standard_normal((4, len(n)))
    first, second = draws[0] + 1j * draws[1], draws[2] + 1j * draws[3]
    shared = track_coherence(n, track_m)
    left = np.fft.irfft(amplitude * first, period)
    right = np.fft.irfft(amplitude * (shared * first + np.sqrt(1 - shared**2) * second), period)
    return np.asarray(left[:rows]), np.asarray(right[:rows])


def hump(place_m: FloatArray, start_m: float, length_m: float, height_m: float) -> FloatArray:
    """A traffic-calming hump: a raised cosine of the given length and height, level with the road at both ends."""
    inside = (place_m >= start_m) & (place_m <= start_m + length_m)
    wave = 0.5 * (1 - np.cos(2 * np.pi * (place_m - start_m) / length_m))
    return np.asarray(np.where(inside, height_m * wave, 0.0))


def smoothed(values: FloatArray, step: float, width: float) -> FloatArray:
    """Running mean with a raised-cosine window of the given full width (same unit as step); end values go on."""
    half = round(width / step / 2)
    if half < 1:
        return np.asarray(values, dtype=np.float64)
    window = np.hanning(2 * half + 3)[1:-1]
    padded = np.pad(values, half, mode="edge")
    return np.asarray(np.convolve(padded, window / window.sum(), mode="valid"))


def eased_in(place_m: FloatArray, over_m: float, start_m: float = 0.0) -> FloatArray:
    """Factor from 0 to 1 with level ends: so that a rough road begins flat, under a vehicle at rest."""
    x = np.clip((place_m - start_m) / over_m, 0.0, 1.0)
    return np.asarray(x * x * (3 - 2 * x))


def with_roughness(road: Road, left: FloatArray, right: FloatArray, step_m: float) -> Road:
    """The same road on the (finer) steps of a roughness, which is eased in over the first 5 m and added."""
    place = even_places(len(left), step_m)
    own = even_places(len(road.curvature_1pm), road.step_m)
    fade = eased_in(place, 5.0)

    def at(values: FloatArray) -> FloatArray:
        return np.asarray(np.interp(place, own, values))

    return replace(
        road,
        step_m=step_m,
        curvature_1pm=at(road.curvature_1pm),
        grade_rad=at(road.grade_rad),
        bank_rad=at(road.bank_rad),
        left_m=at(road.left_m) + fade * left,
        right_m=at(road.right_m) + fade * right,
        friction_left=at(road.friction_left),
        friction_right=at(road.friction_right),
    )


def altitude_m(road: Road) -> FloatArray:
    """Height of the smooth road above its beginning, (m,): the integral of the grade's sine."""
    slope = np.sin(road.grade_rad)
    rise = 0.5 * (slope[1:] + slope[:-1]) * road.step_m
    return np.concatenate(([0.0], np.cumsum(rise)))
