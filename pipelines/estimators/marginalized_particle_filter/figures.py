"""Traces, figures and assumptions of a particle filter's run, for the report."""

from __future__ import annotations

import numpy as np

from pipelines.estimators.marginalized_particle_filter.inputs import Inputs
from pipelines.estimators.marginalized_particle_filter.run import Clouds
from pipelines.estimators.roll_map.answers import Coefficients
from pipelines.estimators.roll_map.data import RollData
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.roll_angle import RollSource
from pipelines.results import Assumption, FloatArray, Trace

MODEL = ("K", "D", "h")


def _on_drive(values: FloatArray, data: RollData, prepared: Prepared) -> FloatArray:
    """A column of the excited rows on the drive's rows, NaN between."""
    whole = np.full(len(prepared.time_s), np.nan)
    whole[data.rows] = values
    return whole


def traces(clouds: Clouds, data: RollData, prepared: Prepared, inputs: Inputs) -> tuple[Trace, ...]:
    """What the filter tracks, and the number of its particles."""
    run = clouds.runs[0]
    found = []
    for column, name, unit in ((0, "roll angle", "rad"), (1, "roll rate", "rad/s")):
        if not np.isfinite(inputs.y[:, column]).any():
            continue
        scored = np.isfinite(inputs.y[:, column])
        columns = {
            "measured": _on_drive(np.where(scored, inputs.y[:, column], np.nan), data, prepared),
            "residual": _on_drive(np.where(scored, run.innovation[:, column], np.nan), data, prepared),
        }
        found.append(
            Trace(f"{name}, particle filter", prepared.time_s, columns, dict.fromkeys(columns, unit),
                  "Residual: what the first cloud did not foresee.")
        )  # fmt: skip
    columns = {
        "particles": _on_drive(run.particles.astype(np.float64), data, prepared),
        "effective": _on_drive(run.effective, data, prepared),
    }
    found.append(
        Trace("particles of the first cloud", prepared.time_s, columns, dict.fromkeys(columns, "particles"))
    )
    return tuple(found)


def figures(
    clouds: Clouds, coefficients: Coefficients, covariance: FloatArray, factor: float
) -> dict[str, float]:
    """Diagnostics: the model's own K, D, h beside a, b, c with and without what is added."""
    means = np.array([run.mean[np.flatnonzero(np.isfinite(run.mean[:, 0]))[-1]] for run in clouds.runs])
    stds = np.array([run.std[np.flatnonzero(np.isfinite(run.std[:, 0]))[-1]] for run in clouds.runs])
    found = {f"model_{name}": float(v) for name, v in zip(MODEL, means.mean(axis=0), strict=True)}
    found |= {f"model_{name}_own_std": float(v) for name, v in zip(MODEL, stds.mean(axis=0), strict=True)}
    found |= {
        f"model_{name}_between_clouds_std": float(v)
        for name, v in zip(MODEL, means.std(axis=0, ddof=1), strict=True)
    }
    for i, name in enumerate(coefficients.names):
        found[name] = float(coefficients.mean[i])
        found[f"{name}_std"] = float(np.sqrt(coefficients.covariance[i, i]))
        found[f"{name}_std_of_clouds"] = float(np.sqrt(covariance[i, i]))
    found |= {
        "variance_factor_for_correlated_residuals": factor,
        "explained_share": clouds.explained,
        "particles_mean": float(np.mean([run.particles[run.particles > 0].mean() for run in clouds.runs])),
        "effective_least": float(min(np.nanmin(run.effective) for run in clouds.runs)),
        "log_evidence": float(np.nanmean([np.nansum(run.log_likelihood) for run in clouds.runs])),
        "warm_start_kept_share": clouds.started.kept,
        "roll_noise_std": clouds.noise.roll_rad,
        "rate_noise_std": clouds.noise.roll_rate_radps,
    }
    return found


def assumptions(
    clouds: Clouds, data: RollData, roll: RollSource | None, inputs: Inputs
) -> tuple[Assumption, ...]:
    """The filter's own choices."""
    made = roll.how if data.has_roll and roll is not None else "roll rate alone"
    return (
        Assumption("particle filter: roll signal", made, "the best of what the log holds"),
        Assumption(
            "particle filter: model",
            "all mass is sprung and rolls about an axis on the ground; its own error is added afterwards",
            "Berntorp et al., assumption 1",
        ),
        Assumption(
            "particle filter: noise of roll and roll rate",
            f"{np.degrees(clouds.noise.roll_rad):.3g} deg, {np.degrees(clouds.noise.roll_rate_radps):.3g} deg/s",
            "what the warm start's best motion leaves over",
        ),
        Assumption(
            "particle filter: delay between roll channel and acceleration",
            f"± {inputs.delay_std_s * 1000:.0f} ms",
            "usual for signals of one unit" if inputs.delay_std_s < 0.02 else "usual for units of their own",
        ),
    )
