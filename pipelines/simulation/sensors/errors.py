"""What one sensor does to a true signal: its parameters, and the errors in the order in which they arise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipelines.results import FloatArray
from pipelines.simulation.sensors.filter import low_pass, wander


@dataclass(frozen=True)
class SensorModel:
    """One sensor: SI, sizes in the signal's unit. A default of 0 is a sensor without that error.

    signal: canonical name. noise: std of white noise a sample. offset, scale_error: constants (0.01 = reads 1 % too
    much); offset_std, scale_std: what is drawn in addition for each drive. wander, wander_s: std and correlation time
    of a slowly moving offset. delay_s: how old the value is at its stamp. lowpass_hz: cut-off of the sensor's own
    second-order filter, 0 = none. step: quantisation. low, high: saturation. zero_below: reads 0 where the true size
    is smaller. dropouts_per_s, dropout_s: how often it gives nothing, and for how long in the mean. outlier_share,
    outlier: how many samples are wild, and by how much (std).
    """

    signal: str
    noise: float = 0.0
    offset: float = 0.0
    offset_std: float = 0.0
    scale_error: float = 0.0
    scale_std: float = 0.0
    wander: float = 0.0
    wander_s: float = 60.0
    delay_s: float = 0.0
    lowpass_hz: float = 0.0
    step: float = 0.0
    low: float = -np.inf
    high: float = np.inf
    zero_below: float = 0.0
    dropouts_per_s: float = 0.0
    dropout_s: float = 0.5
    outlier_share: float = 0.0
    outlier: float = 0.0

    def scaled(self, factor: float) -> SensorModel:
        """Noise, offset, scale error and wander times a factor."""
        names = ("noise", "offset", "offset_std", "scale_error", "scale_std", "wander")
        return replace(self, **{name: getattr(self, name) * factor for name in names})


@dataclass(frozen=True)
class Drawn:
    """The constant errors of one sensor in one drive."""

    offset: float
    scale_error: float
    delay_s: float


def draw(sensor: SensorModel, rng: np.random.Generator) -> Drawn:
    """Draw a sensor's constant errors."""
    first, second = rng.standard_normal(2)
    return Drawn(
        offset=float(sensor.offset + sensor.offset_std * first),
        scale_error=float(sensor.scale_error + sensor.scale_std * second),
        delay_s=sensor.delay_s,
    )


def lose(seconds: FloatArray, per_s: float, mean_s: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """(n,) true where nothing came: spans that begin at random, per_s of them a second, of exponential length."""
    n = len(seconds)
    if n == 0 or per_s <= 0:
        return np.zeros(n, dtype=np.bool_)
    duration = float(seconds[-1] - seconds[0])
    count = int(rng.poisson(per_s * duration))
    starts = seconds[0] + duration * rng.random(count)
    ends = starts + rng.exponential(mean_s, count)
    edges = np.zeros(n + 1, dtype=np.int64)
    np.add.at(edges, np.searchsorted(seconds, starts), 1)
    np.add.at(edges, np.searchsorted(seconds, ends), -1)
    return np.asarray(np.cumsum(edges[:n]) > 0)


def measure(
    clean: FloatArray,
    rate_hz: float,
    start_s: float,
    seconds: FloatArray,
    sensor: SensorModel,
    drawn: Drawn,
    rng: np.random.Generator,
) -> FloatArray:
    """What the sensor reads. clean: (m,) true signal at rate_hz from start_s; seconds: (n,) stamps from the start.

    Returns (n,), NaN in dropouts. Before the first true sample the first one holds (delay).
    """
    if sensor.lowpass_hz > 0:
        clean = low_pass(clean, sensor.lowpass_hz, rate_hz)
    grid = start_s + np.arange(len(clean)) / rate_hz
    true = np.interp(start_s + seconds - drawn.delay_s, grid, clean)
    values = true * (1 + drawn.scale_error) + drawn.offset
    n = len(values)
    values += sensor.noise * rng.standard_normal(n)
    if sensor.wander > 0:
        period = float(seconds[1] - seconds[0]) if n > 1 else 1.0
        values += wander(n, sensor.wander, sensor.wander_s, period, rng)
    if sensor.outlier_share > 0:
        wild = rng.random(n) < sensor.outlier_share
        values = values + np.where(wild, sensor.outlier * rng.standard_normal(n), 0.0)
    values = np.clip(values, sensor.low, sensor.high)
    if sensor.step > 0:
        values = np.round(values / sensor.step) * sensor.step
    if sensor.zero_below > 0:
        values = np.where(np.abs(true) < sensor.zero_below, 0.0, values)
    lost = lose(seconds, sensor.dropouts_per_s, sensor.dropout_s, rng)
    return np.asarray(np.where(lost, np.nan, values))
