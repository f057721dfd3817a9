"""Roll on tyres in series: the limit of rigid tyres, the answer at low frequency, the steady lean, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.models.roll import RollCoefficients, discretise
from pipelines.models.roll_series import LinearRoll, plain_roll, series_roll, suspension_alone

ROLL = RollCoefficients(110.0, 7.0, 0.8)


def _compliance(model: LinearRoll, omega: float) -> complex:
    """f over angle at a frequency."""
    states = len(model.matrix)
    answer = np.linalg.solve(1j * omega * np.eye(states) - model.matrix, model.feed[:, 0])
    return complex(1 / (model.angle @ answer))


def test_the_plain_model_is_that_of_the_paper() -> None:
    phi, before, after = discretise(ROLL, 0.05)
    found = plain_roll(ROLL, gravity=False).held(0.05)
    assert found[0] == pytest.approx(phi, rel=1e-12)
    assert found[1][:, 0] == pytest.approx(before, rel=1e-9)
    assert found[2][:, 0] == pytest.approx(after, rel=1e-9)
    assert found[1][:, 1] == pytest.approx(-before, rel=1e-9)


@pytest.mark.parametrize("axles", [False, True])
@pytest.mark.parametrize("gravity", [False, True])
def test_rigid_tyres_are_the_plain_model(axles: bool, gravity: bool) -> None:
    stiff = series_roll(ROLL, 1e-4, 0.2, against_axles=axles, gravity=gravity)
    plain = plain_roll(ROLL, gravity=gravity)
    for omega in (0.5, 5.0, 12.0):
        assert _compliance(stiff, omega) == pytest.approx(_compliance(plain, omega), rel=1e-3)


@pytest.mark.parametrize("axles", [False, True])
@pytest.mark.parametrize(("share", "moment"), [(0.17, 0.2), (0.3, 0.5)])
def test_slow_motion_is_that_of_the_apparent_coefficients(axles: bool, share: float, moment: float) -> None:
    model = series_roll(ROLL, share, moment, against_axles=axles, gravity=False)
    omega = 0.1
    found = _compliance(model, omega)
    assert found.imag / omega == pytest.approx(ROLL.b, rel=1e-4)
    assert (ROLL.a - found.real) / omega**2 == pytest.approx(ROLL.c, rel=1e-3)


def test_quick_motion_against_the_axles_shows_less_damping() -> None:
    """c b/k of the third order, at a car's roll mode."""
    model = series_roll(ROLL, 0.17, 0.2, against_axles=True, gravity=False)
    omega = 9.0
    own = suspension_alone(ROLL, 0.17, 0.2, against_axles=True)
    k = ROLL.a * 0.83 / 0.17
    lean = 1 - own.c * 0.2 / k * -(omega**2)
    wanted = (ROLL.b - own.c * ROLL.b / k * omega**2) / lean
    assert _compliance(model, omega).imag / omega == pytest.approx(wanted, rel=1e-9)
    assert wanted < 0.9 * ROLL.b


def test_steady_lean_and_springs_that_hold_nothing_up() -> None:
    model = series_roll(ROLL, 0.17, 0.2, against_axles=True, gravity=False)
    rest = model.steady(np.array([[2.2, 0.0], [2.2, 1.1]]))
    assert rest @ model.angle == pytest.approx([0.02, 0.01])
    falling = plain_roll(RollCoefficients(9.80665, 7.0, 0.8), gravity=True)
    assert falling.steady(np.array([[1.0, 0.0]])) == pytest.approx(np.zeros((1, 2)))


@pytest.mark.parametrize("share", [0.0, -0.1, 1.0])
def test_a_share_that_cannot_be_is_refused(share: float) -> None:
    with pytest.raises(ValueError, match="between 0 and 1"):
        series_roll(ROLL, share, 0.2, against_axles=False, gravity=False)
