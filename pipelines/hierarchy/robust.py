"""Does each drive go with the others of its vehicle? One that does not must not move their answers.

A drive's relations are tested against what all others say (chi² of the cavity, as `pipelines.joint.conflict` tests a drive's
relations): with W = I + F F', T = A S A' and r = residual - A s at the joint posterior, y = W⁻¹ r and U = W⁻¹ - W⁻¹ T W⁻¹,
chi² = y' U⁻¹ y is that of its figures predicted without it. Over all figures that is blunt; so what is built into the vehicle
is looked at one by one besides: without the drive the shared s move by -S A' U⁻¹ y, whose variance is that of S A' U⁻¹ A S.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipelines.hierarchy.parts import Source, make_parts
from pipelines.hierarchy.posterior import DrivePart, VehiclePosterior, solve
from pipelines.results import FloatArray

UNLIKELY = 0.001
"""Probability of a misfit by chance, over all drives of a vehicle, below which one is said not to go with the others."""

LIKELY = 0.05
"""Widened so far that a misfit of this probability is left."""

WIDEST = 2.0
"""Factor on a drive's standard deviations beyond which it is left out: what is that far off is another vehicle or sensor."""


LOOKED_AT = (
    "spring_front", "spring_rear", "bar_front", "bar_rear", "empty_mass", "empty_x", "empty_y", "empty_h",
    "roll_center_front", "roll_center_rear", "bump_front", "bump_rear", "askew_roll", "askew_pitch", "drive_scale",
)  # fmt: skip
"""Shared unknowns that a drive of another vehicle, or with other parts, would see otherwise."""


@dataclass(frozen=True)
class Misfit:
    """A drive against the others. factor: on its own errors that makes it go with them. about: the unknown that it sees the
    most unlike the others, and by how many standard deviations."""

    chi2: float
    figures: int
    log_probability: float
    factor: float
    about: str = ""
    apart: float = 0.0


def _cavity(part: DrivePart, posterior: VehiclePosterior) -> tuple[FloatArray, FloatArray]:
    """Residual (m,) of the drive's figures to what the others predict, and its covariance (m, m)."""
    w = np.eye(len(part.residual)) + part.f @ part.f.T
    inverse = np.linalg.inv(w)
    spread = part.a @ posterior.s_covariance @ part.a.T
    kept = inverse - inverse @ spread @ inverse
    covariance = np.linalg.inv(0.5 * (kept + kept.T))
    y = inverse @ (part.residual - part.a @ posterior.s)
    return np.asarray(covariance @ y), np.asarray(0.5 * (covariance + covariance.T))


def _unlike(
    part: DrivePart, posterior: VehiclePosterior, r: FloatArray, covariance: FloatArray
) -> tuple[str, float]:
    """The shared unknown that moves the most, in its own standard deviations, when the drive is taken out."""
    rows = [posterior.names.index(name) for name in LOOKED_AT if name in posterior.names]
    if not rows:
        return "", 0.0
    w = np.eye(len(part.residual)) + part.f @ part.f.T
    gain = np.linalg.solve(w, part.a @ posterior.s_covariance[:, rows]).T
    moved, size = gain @ r, np.einsum("rm,mn,rn->r", gain, covariance, gain)
    # what the drive does not see moves by nothing, give or take nothing
    z = np.where(size > 1e-6, moved / np.sqrt(np.maximum(size, 1e-12)), 0.0)
    worst = int(np.argmax(np.abs(z)))
    return posterior.names[rows[worst]], float(z[worst])


def misfit(part: DrivePart, posterior: VehiclePosterior, rho: float) -> Misfit:
    """A drive's misfit to all others of its vehicle, its errors taken as all its own: how much of them is common is not known
    well enough to call a drive wrong for it."""
    from scipy.stats import chi2 as law
    from scipy.stats import norm

    size = len(part.residual)
    if size == 0:
        return Misfit(0.0, 0, 0.0, 1.0)
    r, covariance = _cavity(part, posterior)
    covariance = covariance + rho / (1 - rho) * np.eye(size)
    found = float(r @ np.linalg.solve(covariance, r))
    limit, factor = float(law.isf(LIKELY, size)), 1.0
    inner = covariance - np.eye(size)
    while factor < 1e3 and float(r @ np.linalg.solve(factor**2 * np.eye(size) + inner, r)) > limit:
        factor *= 1.1
    about, apart = _unlike(part, posterior, r, covariance)
    focused = float(norm.logsf(abs(apart))) + np.log(2 * len(LOOKED_AT))
    factor = max(factor, abs(apart) / 2) if focused < law.logsf(found, size) else factor
    return Misfit(found, size, min(float(law.logsf(found, size)), focused), factor, about, apart)


@dataclass(frozen=True)
class Weighed:
    """Drives as they go together. other_sensors: drive -> its misfit before its sensors were taken as its own; widened:
    drive -> factor; left_out: drive -> its misfit."""

    sources: tuple[Source, ...]
    posterior: VehiclePosterior | None
    widened: dict[str, float]
    left_out: dict[str, Misfit]
    other_sensors: dict[str, Misfit]


def weigh(sources: Sequence[Source], rho: float) -> Weighed:
    """Join the drives. Of those that contradict the others, the worst first, the sensors are taken as their own (another
    recorder, or one that was calibrated anew); if that does not explain it they are widened, or left out.

    Of two drives that contradict each other nobody can say which is wrong: then, and where no majority would be left,
    posterior is None and all stand on their own.
    """
    kept, widened, left_out = list(sources), dict[str, float](), dict[str, Misfit]()
    apart = dict[str, Misfit]()
    while True:
        posterior = solve(*make_parts(kept, rho))
        worst = [misfit(part, posterior, rho) for part in posterior.parts]
        row = int(np.argmin([m.log_probability for m in worst]))
        found, at = worst[row], kept[row]
        if found.log_probability >= np.log(UNLIKELY / len(kept)):
            return Weighed(tuple(kept), posterior, widened, left_out, apart)
        if not at.other_sensors:
            kept[row] = replace(at, other_sensors=True)
            apart[at.drive_id] = found
            continue
        if len(left_out) + 1 > (len(sources) - 1) // 2:
            return Weighed((), None, {}, {at.drive_id: found, **left_out}, {})
        total = widened.get(at.drive_id, 1.0) * max(found.factor, 1.1)
        if total > WIDEST:
            left_out[at.drive_id] = found
            widened.pop(at.drive_id, None)
            apart.pop(at.drive_id, None)
            kept.pop(row)
        else:
            widened[at.drive_id] = total
            kept[row] = replace(at, factor=at.factor * max(found.factor, 1.1))
