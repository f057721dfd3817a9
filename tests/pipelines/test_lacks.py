"""What the verdict says is missing: signals where no relation sees a parameter, else what would narrow it most."""

from __future__ import annotations

from pipelines.joint.answers import NEEDS, lacks_of
from pipelines.results import NextMeasurement


def test_signals_are_asked_for_only_where_no_relation_sees_the_parameter() -> None:
    step = NextMeasurement("Axle loads in braking.", 0.01)
    assert lacks_of("cg_height_m", False, (step,)) == NEEDS["height"]
    assert lacks_of("roll_inertia_kgm2", False, ()) == NEEDS["motion"]
    seen = lacks_of("cg_height_m", True, (step, NextMeasurement("A tilt table.", 0.02)))
    assert seen == "what would help most: axle loads in braking"
    assert "leaves them open" in lacks_of("cg_height_m", True, ())
