"""What the vehicle file states of combinations of unknowns: it binds them as a relation of the drive would."""

from __future__ import annotations

import numpy as np

from pipelines.evidence import Evidence, Values
from pipelines.joint.outputs import roll_stiffness_of
from pipelines.joint.unknowns import AXLES
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

DEPENDS = tuple(f"{part}_{axle}" for part in ("spring", "bar", "track") for axle in AXLES)


def _roll_stiffness(values: Values) -> FloatArray:
    # a data sheet's stiffness is that of the empty vehicle as it stands
    return (
        np.atleast_2d(roll_stiffness_of(values, empty=True))
        if np.ndim(values["bar_front"])
        else np.array([roll_stiffness_of(values, empty=True)])
    )


def stated_relations(vehicle: Vehicle) -> tuple[Evidence, ...]:
    """The roll stiffness where the file states it and not the springs and bars that make it up.

    With springs and bars stated as well it is most likely their sum, and would count them twice.
    """
    total = vehicle.get("roll_stiffness_nmprad")
    parts = [vehicle.get(f"spring_rate_{axle}_npm") for axle in AXLES]
    parts += [vehicle.get(f"anti_roll_stiffness_{axle}_nmprad") for axle in AXLES]
    if total is None or all(part is not None for part in parts):
        return ()
    std = max(total.std, 1e-3 * total.value)
    return (
        Evidence(
            "roll", "vehicle file", "stated roll stiffness", "vehicle file", np.array([total.value]),
            np.array([[std**2]]), _roll_stiffness, DEPENDS,
        ),
    )  # fmt: skip
