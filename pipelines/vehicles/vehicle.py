"""The vehicle file (TOML): quantities with their uncertainty, the load, the sensors' places, and the reference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pipelines.suspension_mapping.record import SuspensionMap


@dataclass(frozen=True)
class Quantity:
    """A known quantity in SI: value, standard deviation (0 = exact), and where it came from in words."""

    value: float
    std: float
    source: str
    std_stated: bool = True


@dataclass(frozen=True)
class Vehicle:
    """A vehicle file. `quantities` are those of the empty vehicle; `load`, `sensors` and `trailer` by their own keys. id: which vehicle
    of a fleet it is (a VIN, a fleet number).

    powertrain: one of POWERTRAINS; None where the file is silent. self_levelling: which axle's springs keep the body's height under any load, one of LEVELLING; None where the file is silent.
    deflection_zero: the vehicle on which suspension deflections are nought, one of ZEROS; None where the file is silent (empty, unless
    the log looks otherwise). axle_load_by: what carries the load that axle loads show, one of AXLE_LOADS; None where the file is silent. recorded_on: what the log is of, one of RECORDED; None where the file is silent. reference: the loaded vehicle's truth, by parameter name. suspension_map: what a drive with measuring wheels taught of
    its suspension; suspension_map_path: its file as the vehicle file names it, taken from the vehicle file's folder.
    turning: steering ratio times wheelbase as a drive has them, over the file's; None where nothing tells (`pipelines.prepare.steered`).
    """

    name: str | None = None
    body: str | None = None
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    load: Mapping[str, Quantity] = field(default_factory=dict)
    sensors: Mapping[str, Quantity] = field(default_factory=dict)
    reference: Mapping[str, float] = field(default_factory=dict)
    path: Path | None = None
    suspension_map: SuspensionMap | None = None
    suspension_map_path: Path | None = None
    id: str | None = None
    powertrain: str | None = None
    self_levelling: str | None = None
    deflection_zero: str | None = None
    axle_load_by: str | None = None
    recorded_on: str | None = None
    trailer: Mapping[str, Quantity] = field(default_factory=dict)
    turning: float | None = None

    def get(self, key: str) -> Quantity | None:
        """A quantity of the empty vehicle, or None where the file is silent."""
        return self.quantities.get(key)

    @property
    def real(self) -> bool:
        """Whether the file says that the log is of a vehicle on the road, of which no piece of physics is left out."""
        return self.recorded_on == "vehicle"

    @property
    def load_stated(self) -> bool:
        """Whether the file says how heavy this drive's load is."""
        return "mass_kg" in self.load

    @property
    def load_unsaid(self) -> str:
        """In words, why this drive's load is not known."""
        return "the vehicle file's [load] has no mass_kg" if self.load else "the vehicle file has no [load]"
