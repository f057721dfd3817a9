"""Doubts of what signals of load show: the scale of a torque or force, springs that level themselves, bellows' pressures."""

from __future__ import annotations

from pipelines.joint.channels import WRONG, channels_of
from pipelines.joint.doubts.weighed import WRONG_FILE, Doubt, Place, elsewhere, wider
from pipelines.joint.vehicle.suspension import levelled_n, loaded_rate
from pipelines.joint.vehicle.unknowns import AXLES, BY_SPRINGS, CORNERS, SPRINGS_CARRY
from pipelines.vehicles.axle_loads import by_springs
from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.measured import known_body
from pipelines.vehicles.vehicle import Vehicle

LEVELLED = {"car": 0.003, "carrier": 0.03, "heavy": 0.4}
"""Chance beforehand that springs level themselves (air, by valve or compressor) where the vehicle file is silent: half of them at both
axles, half at the rear one."""
LEVELLED_SUV, LARGE_KG = 0.04, 1900.0
"""The same of SUVs of so much empty mass, of which air springs are a usual option."""
LEVELS = "springs that level themselves, so that deflections tell no load"

BELLOWS = "axle loads that are what the springs carry"


def level_chance(vehicle: Vehicle) -> float:
    """Chance beforehand of springs that level themselves, at both axles or at the rear one."""
    mass = vehicle.get("mass_kg")
    if known_body(vehicle.body) == "SUV" and mass is not None and mass.value > LARGE_KG:
        return LEVELLED_SUV
    return LEVELLED[kind_of(vehicle)]


def channel_doubts(joint: Place, _: Vehicle) -> list[Doubt]:
    """Every torque and force of the log: its scale off by several of the spreads that such have."""
    return [
        doubt
        for channel, (scales, _) in channels_of(joint.evidence).items()
        for doubt in wider(WRONG.format(channel), scales, WRONG_FILE)
    ]


def levelling(joint: Place, vehicle: Vehicle) -> list[Doubt]:
    """Deflections that have nothing to do with the load; nothing where no relation has any."""
    told = any(f"zero_{wheel}" in e.unknowns for e in joint.evidence for wheel in CORNERS)
    if vehicle.self_levelling is not None or vehicle.deflection_zero == "loaded" or not told:
        return []
    known = joint.known
    kilos = float(known.mean[known.index("empty_mass")])
    chance, spread = 0.5 * level_chance(vehicle), levelled_n(vehicle, kilos)

    def law(name: str) -> tuple[float, float]:
        row = known.index(name)
        return float(known.mean[row]), float(known.std[row])

    both = {f"zero_{wheel}": (0.0, spread) for wheel in CORNERS}
    both |= {f"spring_{a}": loaded_rate(a, law(f"spring_{a}"), law("load"), kilos) for a in AXLES}
    rear = {name: both[name] for name in ("zero_rl", "zero_rr", "spring_rear")}
    return [elsewhere(LEVELS, known, figures, chance) for figures in (both, rear)]


def bellows(joint: Place, vehicle: Vehicle) -> list[Doubt]:
    """Axle loads that lack what the links carry in braking and driving."""
    if vehicle.axle_load_by is not None or not any(BY_SPRINGS in e.unknowns for e in joint.evidence):
        return []
    return [elsewhere(BELLOWS, joint.known, {BY_SPRINGS: SPRINGS_CARRY}, by_springs(vehicle))]
