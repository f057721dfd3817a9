"""A load has an inertia of its own: two in front and as much in the boot are no lump between them."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.joint.vehicle.unknowns import before_the_log
from tests.pipelines.joint_parts import vehicle

KNOWN = before_the_log(vehicle())
LENGTH = KNOWN.mean[KNOWN.index("wheelbase")]


def pitch_inertia(**changes: float) -> float:
    values = KNOWN.at(np.zeros(len(KNOWN.names))) | changes
    return float(outputs_of(values, {})["pitch_inertia_kgm2"])


def test_its_own_inertia_is_an_unknown() -> None:
    lump, spread = (pitch_inertia(load=520.0, load_long=share) for share in (0.0, 0.15))
    assert spread - lump == pytest.approx(520.0 * 0.15 * LENGTH**2, rel=1e-9)
    assert pitch_inertia(load=0.0, load_long=0.0) == pitch_inertia(load=0.0, load_long=0.15)


def test_what_is_usual_holds_a_lump_and_two_rows_with_a_full_boot() -> None:
    mean, std = KNOWN.mean[KNOWN.index("load_long")], KNOWN.std[KNOWN.index("load_long")]
    # two persons of 75 kg over the front seats, 368 kg over the rear axle, each a metre long
    front, rear, apart = 150.0, 368.0, 0.75 * LENGTH
    own = (front * rear / (front + rear) * apart**2 + (front + rear) / 12) / (front + rear) / LENGTH**2
    for share in (0.01, own):
        assert abs(share - mean) < 2 * std
