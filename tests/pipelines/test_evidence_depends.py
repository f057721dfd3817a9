"""Every unknown that moves a relation's prediction is among those that it names: an unnamed one has no slope in the posterior."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.joint_mcmc import posterior_of
from pipelines.evidence import Evidence, Unknown
from pipelines.joint.posterior import values_at


@pytest.mark.parametrize("sensors", ["deflection", "ins", "struts", "axle_load", "everything"])
def test_what_moves_a_prediction_is_named(sensors: str) -> None:
    joint = posterior_of("mixed_minute", sensors, 3)
    known = joint.known
    assert joint.parts
    base = values_at(known, joint.u)
    for part in joint.parts:
        seen = part.evidence
        root = np.linalg.cholesky(seen.covariance)
        at = np.asarray(seen.predict(base)).reshape(len(seen.observed), -1)
        for i, name in enumerate(known.names):
            moved = joint.u.copy()
            moved[i] += 1.0
            there = np.asarray(seen.predict(values_at(known, moved))).reshape(at.shape)
            if name not in seen.unknowns:
                by = float(np.abs(np.linalg.solve(root, there - at)).max())
                assert by < 1e-6, f"{seen.title}: {name} moves it by {by:.2g} of its standard deviations"


def test_loads_of_both_axles_balance_in_pitch() -> None:
    """Beside deflections and alone, whatever carries them: one kind of truth of an array once ended `load_balance` where both are logged."""
    carriers = {
        (part.evidence.kind, part.evidence.carrier)
        for part in posterior_of("mixed_minute", "everything", 3).parts
    }
    assert ("pitch", "axle loads") in carriers


def test_an_own_unknown_that_is_not_named_is_refused() -> None:
    with pytest.raises(ValueError, match="own unknowns that are not among `unknowns`: rubs"):
        Evidence(
            "roll", "by hand", "roll", "test", np.zeros(1), np.eye(1), lambda values: np.zeros(1), ("load",),
            (Unknown("rubs", 0.5, 0.4),),
        )  # fmt: skip
