"""One drive with 300 kg in the boot and deflections at all wheels, and what the joint posterior makes of it."""

from __future__ import annotations

import numpy as np
from plant_balance import Car, demand, logged, simulate

from parsers.drive import Drive
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.joint.inference import infer
from pipelines.results import ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

LOADED = Car(load=300.0, load_at=(2.4, 0.0, 0.9))


def loaded_drive() -> Drive:
    """As sensors with noise log it; no torques and no forces in the struts."""
    rng = np.random.default_rng(15)
    motion = simulate(LOADED, demand(330, rng), rng)
    return logged(motion, np.random.default_rng(16), "suspension_force", "drive", "brake")


def told(drive: Drive, vehicle: Vehicle) -> dict[str, ParameterEstimate]:
    """The answers by the balances of that drive."""
    estimator = LoadBalance()
    found = estimator.estimate(estimator.prepare(drive, {}), vehicle, {}, np.random.default_rng(0))
    joined = infer(found.evidence, vehicle, np.random.default_rng(0))
    assert joined is not None
    return dict(joined.parameters)
