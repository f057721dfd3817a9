"""The Cramér-Rao bound of mass and damper slopes on the paper's set-up.

Both accelerometers are noisy, so that the hub's true acceleration is unknown too, sample by sample. Eliminating it
leaves the sensitivities S = dy/d(theta) of the body's acceleration at a fixed true input, in the effective noise

    e = n_s - J n_u,   cov e = sigma_s² I + sigma_u² J J',

J being the derivative of the body's acceleration by the hub's, along the true motion (it changes with the damper's
slope). Information = S' (cov e)^-1 S. The inverse is never formed: e is the output of a system of two states that the
hub's noise drives, so that a time-varying Kalman filter whitens S row by row, which gives the same sum.
"""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from pipelines.models.base_excitation import body_response
from pipelines.results import FloatArray
from pipelines.simulation.quarter_car import QuarterRun


@kernel
def _whitened_information(
    slopes: FloatArray,
    damping: FloatArray,
    spring: float,
    mass: float,
    step: float,
    noises: FloatArray,
    out: FloatArray,
) -> None:
    """Add S' (cov e)^-1 S into out (p, p). slopes: (n, p); damping: (n,) the slope in force; noises: variances of the
    body's and the hub's accelerometers."""
    count = slopes.shape[1]
    state = np.zeros((2, count))
    error = np.zeros(count)
    p00, p01, p11 = 0.0, 0.0, 0.0
    half = 0.5 * step * step
    for k in range(slopes.shape[0]):
        c0, c1 = -spring / mass, -damping[k] / mass
        g0, g1 = p00 * c0 + p01 * c1, p01 * c0 + p11 * c1
        variance = noises[0] + c0 * g0 + c1 * g1
        for i in range(count):
            error[i] = slopes[k, i] - c0 * state[0, i] - c1 * state[1, i]
        for i in range(count):
            for j in range(count):
                out[i, j] += error[i] * error[j] / variance
        g0, g1 = g0 / variance, g1 / variance
        p00, p01, p11 = p00 - g0 * g0 * variance, p01 - g0 * g1 * variance, p11 - g1 * g1 * variance
        # second-order step of x' = v, v' = -(k x + b v) / m - n_u
        f00, f01 = 1.0 + half * c0, step + half * c1
        f10, f11 = step * c0 + half * c0 * c1, 1.0 + step * c1 + half * (c1 * c1 + c0)
        for i in range(count):
            x, v = state[0, i] + g0 * error[i], state[1, i] + g1 * error[i]
            state[0, i] = f00 * x + f01 * v
            state[1, i] = f10 * x + f11 * v
        q00, q01, q11 = f00 * p00 + f01 * p01, f00 * p01 + f01 * p11, f10 * p01 + f11 * p11
        r10 = f10 * p00 + f11 * p01
        push0, push1 = half, step + half * c1
        p00 = q00 * f00 + q01 * f01 + push0 * push0 * noises[1]
        p01 = r10 * f00 + q11 * f01 + push0 * push1 * noises[1]
        p11 = r10 * f10 + q11 * f11 + push1 * push1 * noises[1]


def cramer_rao_bound(
    run: QuarterRun, noise_mps2: float, gain_std: float = 0.0, delay_std_s: float = 0.0
) -> FloatArray:
    """Smallest standard deviations of (mass kg, extension, compression N·s/m) that an unbiased estimate can have, (3,).

    noise_mps2: of both accelerometers. gain_std, delay_std_s above 0: gain and delay of the body's accelerometer are
    unknown too, with those priors (the bound is then that of an average over the priors).
    """
    car = run.car
    truth = np.array([car.sprung_kg, car.extension_nspm, car.compression_nspm])

    def response(theta: FloatArray) -> FloatArray:
        damping = (float(theta[1]), float(theta[2]))
        return body_response(run.accel_unsprung, run.step_s, float(theta[0]), car.spring_npm, damping)

    columns = []
    for i in range(3):
        moved = 1e-4 * truth[i] * np.eye(3)[i]
        columns.append((response(truth + moved) - response(truth - moved)) / 2e-4)
    prior = [0.0, 0.0, 0.0]
    if gain_std > 0:
        columns.append(run.accel_sprung)
        prior.append(1 / gain_std**2)
    if delay_std_s > 0:
        # in milliseconds, so that the information stays well scaled
        columns.append(-1e-3 * np.gradient(run.accel_sprung, run.step_s))
        prior.append(1 / (1e3 * delay_std_s) ** 2)
    slopes = np.ascontiguousarray(np.column_stack(columns))
    damping = np.where(run.extension_rate > 0, car.extension_nspm, car.compression_nspm)
    information = np.diag(prior)
    noises = np.array([noise_mps2**2, noise_mps2**2])
    _whitened_information(slopes, damping, car.spring_npm, car.sprung_kg, run.step_s, noises, information)
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information)))[:3] * truth)
