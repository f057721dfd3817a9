"""Tracks, traces, scatter, assumptions and figures of the axle-load fit for the report."""

from __future__ import annotations

import math

import numpy as np

from pipelines.estimators.axle_load_gls.answers import Errors
from pipelines.estimators.axle_load_gls.balance import Balance
from pipelines.estimators.axle_load_gls.data import AxleData
from pipelines.estimators.axle_load_gls.known import (
    MassKnowledge,
    Pitch,
    rolling_arm,
    spin_moment,
)
from pipelines.models.axle_load import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.results import Assumption, ParameterEstimate, Scatter, Trace, Track
from pipelines.vehicles.axle_loads import carried_in_words
from pipelines.vehicles.vehicle import Quantity, Vehicle

SCATTER_POINTS = 2000


def height_track(data: AxleData, balance: Balance, height: ParameterEstimate) -> tuple[Track, ...]:
    """The height as data came in: the moment's track, scaled to the answer; what is not of the log stays as wide."""
    assert height.value is not None
    assert height.std is not None
    ratio = height.value / balance.moments[0]
    shown = np.isfinite(balance.track[:, 0]) & (balance.track[:, 0] > 0)
    value = balance.track[shown, 0] * ratio
    own = balance.track_std[shown, 0] * ratio
    log_part = math.sqrt(balance.covariance[0, 0]) * ratio
    rest = max(height.std**2 - log_part**2, 0.0)
    half = 1.96 * np.sqrt(own**2 + rest * (value / height.value) ** 2)
    time_s = data.time_s[balance.track_rows[shown]]
    return (Track("cg_height_m", time_s, value, value - half, value + half),)


def traces(data: AxleData, balance: Balance, prepared: Prepared) -> tuple[Trace, ...]:
    """What was fitted, the fit, and the residual; NaN between runs."""

    def whole(values: np.ndarray) -> np.ndarray:
        full = np.full(len(prepared.time_s), np.nan)
        full[data.rows] = values
        return full

    measured, fitted = whole(balance.measured), whole(balance.fitted)
    name, unit = ("speed", "m/s") if balance.by_speed else ("load moment", "N·m")
    columns = {"measured": measured, "fitted": fitted, "residual": measured - fitted}
    fit = Trace(
        f"axle_load_gls: {name}",
        prepared.time_s,
        columns,
        dict.fromkeys(columns, unit),
        "balance of axle loads",
    )
    force = Trace(
        "axle_load_gls: force", prepared.time_s, {"force along the road": whole(balance.force)},
        {"force along the road": "m/s²"}, "specific force that shifts the load",
    )  # fmt: skip
    return (fit, force)


def load_scatter(data: AxleData, balance: Balance, wheelbase: float) -> tuple[Scatter, ...]:
    """Axle load over force, and the straight line of the fit."""
    step = max(1, data.size // SCATTER_POINTS)
    x, y = balance.force[::step], balance.moment[::step] / wheelbase
    line = np.linspace(float(np.min(x)), float(np.max(x)), 50)
    level, slope = balance.moments[1] * GRAVITY, balance.moments[0]
    if not np.isfinite([level, slope]).all():
        return ()
    fit = (level + slope * line) / wheelbase
    covariance = balance.covariance
    spread = np.sqrt(np.maximum(
        covariance[1, 1] * GRAVITY**2 + 2 * covariance[0, 1] * GRAVITY * line + covariance[0, 0] * line**2, 0.0
    )) / wheelbase  # fmt: skip
    what = (
        "Rear axle load"
        if data.share_front == 0
        else ("Front axle load, turned" if data.share_rear == 0 else "Half of rear less front load")
    )
    return (
        Scatter(
            "axle_load_transfer", "Axle load over force along the road", "force along the road (m/s²)", f"{what} (N)",
            x, y, line, fit, fit - 1.96 * spread, fit + 1.96 * spread, "the slope is m h / L",
        ),
    )  # fmt: skip


def assumptions(
    data: AxleData, pitch: Pitch, errors: Errors, mass: MassKnowledge | None, vehicle: Vehicle, wheelbase: Quantity,
    notes: tuple[Assumption, ...],
) -> tuple[Assumption, ...]:  # fmt: skip
    """All that was taken as given."""
    arm = rolling_arm(vehicle, wheelbase.value)
    spin = spin_moment(vehicle, 1.0)
    found = [
        Assumption("wheelbase_m", f"{wheelbase.value:.4g} ± {wheelbase.std:.2g} m", wheelbase.source),
        Assumption("axle load", data.load_words, "log"),
        *carried_in_words(data.share_of("axle"), vehicle),
        Assumption(
            "axle load sensor", f"scale within {errors.load_scale:.1%}, offset within {errors.load_offset:.0f} N", "settings"
        ),
        Assumption("pitch", f"g times pitch per force {pitch.gain:.3f} ± {pitch.std:.3f}", pitch.how),
        Assumption("rolling resistance times radius", f"{arm[0]:.4f} ± {arm[1]:.4f} m", arm[2]),
        Assumption(
            "wheel spin", f"{spin[0]:.3g} {'kg·m' if spin[2] == 'vehicle file' else 'of m h'}", spin[2]
        ),
    ]  # fmt: skip
    if data.accel is None:
        found.append(
            Assumption(
                "road grade", f"constant error within {data.grade_source.std:g} rad", data.grade_source.how
            )
        )
    else:
        mean, std = errors.force_offset
        found.append(
            Assumption("accelerometer offset", f"{mean:.3f} ± {std:.3f} m/s²", "settings, speed and grade")
        )
    if not (data.front is not None and data.rear is not None) and mass is not None:
        found.append(
            Assumption("loaded mass", f"{np.mean(mass.draws):.0f} ± {np.std(mass.draws):.0f} kg", mass.how)
        )
    return (*found, *notes)


def figures(data: AxleData, balance: Balance) -> dict[str, float]:
    """Named figures."""
    fit = balance.fit
    with np.errstate(invalid="ignore", divide="ignore"):
        inflation = float(np.sqrt(fit.wide_covariance[0, 0] / fit.covariance[0, 0]))
    return {
        "moment_mh_kgm": float(balance.moments[0]),
        "moment_mh_std_kgm": math.sqrt(max(float(balance.covariance[0, 0]), 0.0)),
        "moment_ma_kgm": float(balance.moments[1]),
        "force_spread_mps2": balance.force_spread,
        "samples": float(data.size),
        "unexplained_share": balance.unexplained,
        "runs": float(len(data.runs())),
        "by_speed": float(balance.by_speed),
        "residual_memory": fit.colour.phi,
        "residual_colour_ratio": fit.colour.ratio,
        "residual_scale": fit.scale,
        "innovation_autocorrelation": fit.lag_one,
        "interval_inflation": inflation,
        "downweighted_share": float(np.mean(fit.weights < 1.0)),
    }
