"""What both base-excitation estimators declare alike, and how they read a log and their settings."""

from __future__ import annotations

from parsers.drive import Drive
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.base_excitation.data import SIGNAL_NEEDS, VEHICLE_NEEDS, prepare_ride
from pipelines.prepare.prepared import Prepared


class RideMethod:
    """The part of `pipelines.estimators.base.Estimator` that does not hang on the method. settings: "cutoff_hz" is one."""

    signal_needs: tuple[Need, ...] = SIGNAL_NEEDS
    vehicle_needs: tuple[Need, ...] = VEHICLE_NEEDS
    settings: tuple[Setting, ...] = ()

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """The accelerations of all wheels that have both, on one clock."""
        return prepare_ride(drive, self.value(settings, "cutoff_hz"))

    def value(self, settings: Settings, name: str) -> float:
        """A setting's value, or its default."""
        defaults = {setting.name: setting.default for setting in self.settings}
        return float(settings.get(name, defaults[name]))
