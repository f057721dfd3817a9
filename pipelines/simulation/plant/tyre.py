"""Tyre forces in the road plane: a brush with one slip for both directions, whose friction falls with load and sliding.

The slip is that of a first-order contact (Pacejka's transient slips): u_x, u_y are the deflections of the carcass,

    u' = -v_slip - |v| u / sigma,      kappa = u_x / sigma_x,      tan(alpha) = u_y / sigma_y

so that a standing tyre is a spring and a rolling one lags by its relaxation length. Normalised slip (similarity):

    s = (C_x kappa, C_y tan alpha) / mu,      rho = |s|,      F = mu F_z f(rho) s / rho

with the brush's f = rho - rho²/3 + rho³/27 up to full sliding at rho = 3, and a loss of friction beyond it.
"""

from __future__ import annotations

from parsers.jit import lean_kernel


@lean_kernel
def load_factor(sensitivity: float, load: float, nominal: float) -> float:
    """What is left of a coefficient at a load [N]: 1 at the nominal load, less above it; from 0.4 to 1.4."""
    return min(max(1.0 - sensitivity * (load / nominal - 1.0), 0.4), 1.4)


@lean_kernel
def brush(rho: float, loss: float) -> float:
    """f(rho) / rho: the share of the linear force that is left at a normalised slip, 1 at none.

    loss: share of the friction that is lost far beyond full sliding.
    """
    if rho < 3.0:
        return 1.0 - rho / 3.0 + rho * rho / 27.0
    beyond = 1.0 - 3.0 / rho
    return (1.0 - loss * beyond * beyond) / rho
