"""Traces, scatter and diagnostics of the braking and roll batch."""

from __future__ import annotations

import numpy as np

from pipelines.estimators.brake_roll.answers import Found
from pipelines.estimators.brake_roll.data import BrakeRollData
from pipelines.estimators.brake_roll.vehicle import BrakeRollVehicle
from pipelines.models.roll import DEGREES
from pipelines.results import FloatArray, Scatter, Trace

MOST_POINTS = 3000


def batch_traces(time_s: FloatArray, data: BrakeRollData, found: Found) -> tuple[Trace, ...]:
    """Roll rate, wheel slips and longitudinal balance: measured, fit, residual."""
    traces: list[Trace] = []
    if found.lateral is not None and data.roll_rate is not None:
        fit = found.lateral
        measured = DEGREES * np.where(fit.used, data.roll_rate, np.nan)
        model = DEGREES * np.where(fit.used, fit.predicted, np.nan)
        columns = {"measured": measured, "fit": model, "residual": measured - model}
        traces.append(
            Trace(
                "roll rate",
                time_s,
                columns,
                dict.fromkeys(columns, "deg/s"),
                "least squares over the drive, eq. (21) of Park and Choi",
            )
        )
    if found.slip is not None and data.front is not None and data.rear is not None:
        rows = found.slip.rows
        front = data.front[rows] - found.slip.predicted[:, 0]
        rear = data.rear[rows] - found.slip.predicted[:, 1]
        columns = {"front axle residual": front, "rear axle residual": rear}
        traces.append(
            Trace(
                "wheel speeds in braking",
                time_s[rows],
                columns,
                dict.fromkeys(columns, "m/s"),
                "least squares over the drive, eqs. (1) to (8) of Park and Choi",
            )
        )
    if found.mass is not None and data.f_x is not None:
        rows = found.mass.rows
        residual = found.mass.fit.residual
        columns = {
            "measured": found.mass.predicted + residual,
            "fit": found.mass.predicted,
            "residual": residual,
        }
        traces.append(Trace("longitudinal balance", time_s[rows], columns, dict.fromkeys(columns, "m/s²")))
    return tuple(traces)


def batch_scatters(found: Found, known: BrakeRollVehicle) -> tuple[Scatter, ...]:
    """The longitudinal balance as a line: what the torques give against what the accelerometer reads."""
    if found.mass is None:
        return ()
    fit = found.mass
    x, y = fit.predicted, fit.predicted + fit.fit.residual
    every = max(1, len(x) // MOST_POINTS)
    line = np.linspace(float(x.min()), float(x.max()), 50)
    band = 1.96 * float(fit.fit.noise[0])
    return (
        Scatter(
            "longitudinal_balance",
            "Longitudinal balance",
            f"Torques, drag and rolling over {fit.mass:.0f} kg in m/s²",
            "Longitudinal specific force in m/s²",
            x[::every],
            y[::every],
            line,
            line,
            line - band,
            line + band,
            f"nominal mass {known.mass.value:.0f} kg",
        ),
    )


def batch_figures(data: BrakeRollData, found: Found) -> dict[str, float]:
    """Diagnostics by name."""
    figures: dict[str, float] = {}
    if data.true is not None:
        figures |= {"speed_delay_s": data.true.delay_s, "accel_x_gain": data.true.gain}
    if found.slip is not None:
        s = found.slip
        figures |= {
            "slip_height_m": s.height,
            "slip_height_std_m": s.std,
            "stops": float(s.stops),
            "strongest_braking_mps2": s.strongest,
            "slip_stiffness": float(np.median(s.slopes)),
            **{f"slip_{name}": s.fit.value(name) for name in ("radius_front", "radius_rear", "bend", "load")},
        }
    if found.lateral is not None:
        figures |= {
            "roll_per_lateral_acceleration": found.lateral.gain,
            "roll_per_lateral_acceleration_std": found.lateral.std,
            "roll_explained_share": found.lateral.explained,
        }
    if found.mass is not None:
        m = found.mass
        figures |= {
            "balance_mass_kg": m.mass,
            "balance_mass_std_kg": m.std,
            "balance_noise_mps2": float(m.fit.noise[0]),
        }
    return figures
