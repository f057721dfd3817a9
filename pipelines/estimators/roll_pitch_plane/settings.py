"""Settings of roll_plane and pitch_plane, and what both do alike before and after the fit."""

from __future__ import annotations

from parsers.drive import Drive
from pipelines.estimators.base import Setting, Settings
from pipelines.estimators.roll_pitch_plane.answers import SensorErrors
from pipelines.estimators.roll_pitch_plane.data import CORNERS, FORCES, OPTIONAL
from pipelines.estimators.roll_pitch_plane.fit import LinearFit
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.signals import prepare_signals

LEAST_EXPLAINED = 0.8
LEAST_TOLD = 0.25
"""Share of the struts' moment that the balance explains, and of an angular acceleration that is not noise, below which nothing
is said."""

SETTINGS: tuple[Setting, ...] = (
    Setting("cutoff_hz", 5.0, "Hz", "zero-phase low-pass of all signals", 0.5, 20.0),
    Setting("least_lateral", 0.25, "m/s²", "spread of lateral acceleration below which no roll arm is given", 0.0, 5.0),
    Setting("least_longitudinal", 0.3, "m/s²", "spread of longitudinal acceleration below which no pitch arm is given", 0.0, 5.0),
    Setting("force_scale_std", 0.01, "share", "scale error of a strut's force", 0.0, 0.5),
    Setting("force_offset_std", 40.0, "N", "zero error of a strut's force", 0.0, 5000.0),
    Setting("accel_scale_std", 0.005, "share", "scale error of an accelerometer", 0.0, 0.5),
    Setting("accel_offset_std", 0.12, "m/s²", "offset of accel_x and accel_y, mounting counted in", 0.0, 5.0),
    Setting("arm_model_std", 0.03, "share", "what the balance itself may be wrong by, of load transfer", 0.0, 0.5),
    Setting("inertia_model_std", 0.035, "share", "the same, of the inertia", 0.0, 0.5),
    Setting("mass_model_std", 0.007, "share", "the same, of the sprung mass: what links carry in the mean", 0.0, 0.5),
)  # fmt: skip


def setting(settings: Settings, name: str) -> float:
    """A setting, or its default."""
    return float(settings.get(name, next(s.default for s in SETTINGS if s.name == name)))


def sensor_errors(settings: Settings) -> SensorErrors:
    """The errors that go into the intervals."""
    names = (
        "force_scale",
        "force_offset",
        "accel_scale",
        "accel_offset",
        "arm_model",
        "inertia_model",
        "mass_model",
    )
    return SensorErrors(*(setting(settings, f"{name}_std") for name in names))


def prepare_planes(drive: Drive, settings: Settings, accel: str) -> Prepared:
    """Forces and one acceleration as wanted, everything else optional; at ten rows a period of the cutoff."""
    cutoff = setting(settings, "cutoff_hz")
    wanted = [*FORCES, accel]
    corners = all(name in drive.signals for name in CORNERS)
    rate = {"accel_y": "roll_rate", "accel_x": "pitch_rate"}[accel]
    if corners:
        wanted += CORNERS
    elif rate in drive.signals:
        wanted.append(rate)
    optional = [name for name in OPTIONAL if name not in wanted]
    return prepare_signals(drive, wanted, rate_hz=10 * cutoff, cutoff_hz=cutoff, optional=optional)


def unlike(fit: LinearFit) -> str:
    """What is said of a balance that explains too little."""
    return (
        f"the balance explains {100 * max(fit.explained, 0.0):.0f} % of the struts' moment: friction or linkage forces that the "
        "sensors do not see are as large as what the body's motion asks for"
    )
