"""Collects the unknowns of a vehicle: one line each, from the vehicle file or as usual, with what the report says of it."""

from __future__ import annotations

from dataclasses import dataclass, field

from pipelines.results import Assumption
from pipelines.vehicles.vehicle import Quantity, Vehicle

AXLES = ("front", "rear")
SILENT = "the vehicle file is silent: usual for road vehicles"


@dataclass
class Book:
    """Collects unknowns and says what was assumed."""

    vehicle: Vehicle
    rows: dict[str, tuple[float, float]] = field(default_factory=dict)
    assumptions: list[Assumption] = field(default_factory=list)
    keys: dict[str, str] = field(default_factory=dict)
    """Unknown -> the vehicle file's key that states it."""

    def put(self, name: str, mean: float, std: float, said: str = "", source: str = SILENT) -> None:
        """One unknown; said: its name in the report, empty for what needs no line there."""
        self.rows[name] = (mean, max(std, 1e-12))
        if said:
            self.assumptions.append(Assumption(said, f"{mean:.4g} ± {std:.3g}", source))

    def quantity(self, name: str, key: str, mean: float, std: float, said: str = "") -> Quantity | None:
        """One unknown from the vehicle file, or the usual where the file is silent."""
        known = self.vehicle.get(key)
        if known is None:
            self.put(name, mean, std, said or key)
        else:
            self.put(name, known.value, known.std, key, known.source)
            self.keys[name] = key
        return known
