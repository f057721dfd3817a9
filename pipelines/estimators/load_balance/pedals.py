"""What brakes and engine do: their torques at the full band, and where the brakes are on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipelines.joint.vehicle.unknowns import CORNERS, Known
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray

LEAST_BRAKING = 0.1
"""m/s²: less is not told from a pressure sensor's offset."""

BRAKING = 0.7
"""m/s² of deceleration from which the brakes are taken to be on where no brake signal is in the log."""


def _sum_of(prepared: Prepared, name: str) -> FloatArray | None:
    """A torque over all wheels: the sum as logged, or of the wheels that are logged."""
    c = prepared.columns
    if f"{name}" in c and np.isfinite(c[name]).any():
        return c[name]
    wheels = [c[f"{name}_{w}"] for w in CORNERS if f"{name}_{w}" in c]
    if not wheels or (name == "brake_torque" and len(wheels) < 4):
        return None
    # a driven axle is logged whole, or the sum would say nothing
    return np.asarray(np.sum(wheels, axis=0)) if len(wheels) in (2, 4) else None


def _middle(values: FloatArray) -> float:
    """Median of what is there, 0 where nothing is."""
    return float(np.nanmedian(values)) if np.isfinite(values).any() else 0.0


def released_at_zero(torque: FloatArray, least: float) -> tuple[FloatArray, NDArray[np.bool_]]:
    """(n,) brake torque, + where it brakes and nought where it does not, and where it does: at a fiftieth of the hardest braking and `least` N m.

    Logs have it of either sign. What a sensor reads of released brakes is its offset, and is in what it reads of applied ones.
    """
    hardest = float(np.nanmax(np.abs(torque), initial=0.0))
    turned = -1.0 if _middle(torque[np.abs(torque) > 0.5 * hardest]) < 0 else 1.0
    signed = turned * torque
    on = signed > max(0.02 * hardest, least)
    return np.asarray(signed - _middle(signed[~on])), np.asarray(on)


def pedals_of(prepared: Prepared, known: Known) -> tuple[dict[str, FloatArray], tuple[bool, bool]]:
    """Brake and drive torque at the full band, and where the brakes are on."""
    c, n = prepared.columns, len(prepared.time_s)
    brake, drive = _sum_of(prepared, "brake_torque"), _sum_of(prepared, "drive_torque")
    found: dict[str, FloatArray] = {}
    gain = known.mean[known.index("brake_gain")]
    pressure = c.get("brake_pressure")
    if pressure is not None and gain > 2e-6 and gain != 1.0:
        pushed = gain * pressure
        if brake is None:
            brake = pushed
            found["by_pressure"] = np.ones(n)
        else:
            found["pushed"] = pushed
    if brake is not None:
        # noise and offset of a sensor are no braking, in a drive without any neither
        least = LEAST_BRAKING * known.mean[known.index("empty_mass")] * known.mean[known.index("radius")]
        found["brake"], on = released_at_zero(brake, float(least))
        if "pushed" in found:
            # a foot that holds the standing vehicle pushes without braking it: the pressure's zero is its own
            found["pushed"], _ = released_at_zero(found["pushed"], float(least))
    elif pressure is not None:
        on = pressure > 1e5
    else:
        on = c.get("accel_x", np.zeros(n)) < -BRAKING
    if drive is not None:
        found["drive"] = drive
    found["on"] = np.where(on, 1.0, 0.0)
    return found, (drive is not None, brake is not None)
