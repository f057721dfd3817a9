"""The joint posterior over all drives of one vehicle: what is shared, and what is each drive's own.

API for whoever asks about differences between drives (load changes, trends):

    posterior = solve(parts)                       # or what `pipelines.hierarchy.join.joined` gives back
    mean, covariance = posterior.functional({i: W_i, j: W_j})   # of sum_i W_i v_i, W (m, k_i) or (k_i,), SI
    values, gradients = posterior.outputs(i)       # parameters of drive i (mass_kg, cg_height_m …) at its joint mean,
                                                   # and their derivatives (k_i,) by that drive's unknowns
    e.g. change of mass from i to j:  posterior.functional({j: gradients_j["mass_kg"], i: -gradients_i["mass_kg"]})
    posterior.mean(i), posterior.covariance(i), posterior.cross(i, j)     # (k_i,), (k_i, k_i), (k_i, k_j), SI
    posterior.extra("name")                        # mean and standard deviation of an `Extra`

i, j: rows of `posterior.drives` (drive ids, in order of time). What drives share cancels in differences as it must. An `Extra`
is one more shared unknown that moves unknowns of single drives: a trend of the front springs in N/m a year is
Extra("trend", std, {drive_id: {"spring_front": years since the first drive}, …}), and its posterior is the trend's.

The model. With u = (v - mean) / std of a drive, u = C s + D e, s shared and e the drive's own, both N(0, I) (see `shared`), its
whitened relations are A s + F e = r + N(0, I). The drives' own unknowns are eliminated one drive after the other (Schur
complement): with M = (I + F F')⁻¹ the shared precision is I + sum A' M A, and given s a drive's own are
N(E F' (r - A s), E), E = (I + F'F)⁻¹. The cost is linear in the number of drives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.hierarchy.own_outputs import outputs_at
from pipelines.results import FloatArray


@dataclass(frozen=True)
class Extra:
    """One more shared unknown, N(0, std²). moves: drive -> unknown -> SI by which one of this unknown moves it there."""

    name: str
    std: float
    moves: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class DrivePart:
    """One drive's whitened relations, as the solver takes them.

    names, mean, std: (k,) its unknowns before the log, SI. shared: (k, K) C in `u = C s + D e`; own: (k,) diagonal of D;
    a: (m, K), f: (m, k) and residual: (m,) of A s + F e = residual + N(0, I), K shared unknowns in all. given: figures that
    outputs need. place: (k,) where its relations are linear, SI.
    """

    drive_id: str
    names: tuple[str, ...]
    mean: FloatArray
    std: FloatArray
    shared: FloatArray
    own: FloatArray
    a: FloatArray
    f: FloatArray
    residual: FloatArray
    given: Mapping[str, float]
    place: FloatArray | None = None


@dataclass(frozen=True)
class _Own:
    """A drive at the joint posterior: v = base + by_shared s + N(0, rest), SI."""

    base: FloatArray
    by_shared: FloatArray
    rest: FloatArray


@dataclass(frozen=True)
class VehiclePosterior:
    """All drives of one vehicle. names: (K,) of the shared unknowns, s of N(0, I) before the logs.

    s, s_covariance: (K,), (K, K) with them. parts: by drive, in order. chi2: misfit of all `figures` figures to the model as
    a whole, of as many as there are in the mean.
    """

    names: tuple[str, ...]
    s: FloatArray
    s_covariance: FloatArray
    parts: tuple[DrivePart, ...]
    own: tuple[_Own, ...]
    extras: tuple[Extra, ...] = ()
    chi2: float = 0.0
    figures: int = 0

    @property
    def inflation(self) -> float:
        """Factor on spreads where the drives scatter more than the model of their errors has it, 1 or more."""
        return float(np.sqrt(max(1.0, self.chi2 / max(self.figures, 1))))

    @property
    def drives(self) -> tuple[str, ...]:
        """Drive ids in order."""
        return tuple(part.drive_id for part in self.parts)

    def mean(self, i: int) -> FloatArray:
        """(k_i,) unknowns of a drive, SI, in the order of `parts[i].names`."""
        own = self.own[i]
        return np.asarray(own.base + own.by_shared @ self.s)

    def covariance(self, i: int) -> FloatArray:
        """(k_i, k_i) of a drive's unknowns, SI."""
        return self.cross(i, i)

    def cross(self, i: int, j: int) -> FloatArray:
        """(k_i, k_j) covariance between the unknowns of two drives."""
        found = self.own[i].by_shared @ self.s_covariance @ self.own[j].by_shared.T
        return np.asarray(found + self.own[i].rest if i == j else found)

    def functional(self, weights: Mapping[int, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Mean (m,) and covariance (m, m) of the sum of W_i v_i. weights: drive's row -> (m, k_i), or (k_i,) for m = 1."""
        rows = {i: np.atleast_2d(w) for i, w in weights.items()}
        by_shared = sum(w @ self.own[i].by_shared for i, w in rows.items())
        value = sum(w @ self.mean(i) for i, w in rows.items())
        covariance = by_shared @ self.s_covariance @ np.transpose(by_shared)
        covariance = covariance + sum(w @ self.own[i].rest @ w.T for i, w in rows.items())
        return np.asarray(value), np.asarray(covariance)

    def outputs(self, i: int) -> tuple[dict[str, float], dict[str, FloatArray]]:
        """Parameters of a drive at its joint mean, and their derivatives (k_i,) by its unknowns, SI."""
        part = self.parts[i]
        return outputs_at(part.names, self.mean(i), part.std, part.given)

    def extra(self, name: str) -> tuple[float, float]:
        """Mean and standard deviation of an extra unknown. Raises ValueError where there is none of this name."""
        std = next((e.std for e in self.extras if e.name == name), None)
        if std is None:
            raise ValueError(f"there is no extra unknown {name!r}")
        row = self.names.index(name)
        return float(std * self.s[row]), float(std * np.sqrt(self.s_covariance[row, row]))


def inverse(matrix: FloatArray) -> FloatArray:
    """Of a symmetric matrix."""
    return np.asarray(np.linalg.inv(0.5 * (matrix + matrix.T)))


def reduced(part: DrivePart) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A drive's own unknowns eliminated: M (m, m), precision (K, K) and its right hand side (K,) of the shared ones."""
    m = inverse(np.eye(len(part.residual)) + part.f @ part.f.T)
    weighted = m @ part.a
    return m, part.a.T @ weighted, weighted.T @ part.residual


def solve(parts: Sequence[DrivePart], names: Sequence[str], extras: Sequence[Extra] = ()) -> VehiclePosterior:
    """The posterior of all drives. names: (K,) of the shared unknowns. Every drive's part has its columns for them."""
    precision, right, chi2 = np.eye(len(names)), np.zeros(len(names)), 0.0
    for part in parts:
        m, information, pull = reduced(part)
        precision += information
        right += pull
        chi2 += float(part.residual @ m @ part.residual)
    covariance = inverse(precision)
    s = covariance @ right
    own = tuple(_own(part) for part in parts)
    figures = sum(len(part.residual) for part in parts)
    return VehiclePosterior(
        tuple(names), s, covariance, tuple(parts), own, tuple(extras), chi2 - float(right @ s), figures
    )


def _own(part: DrivePart) -> _Own:
    """What is a drive's own, given the shared unknowns."""
    e_covariance = inverse(np.eye(len(part.own)) + part.f.T @ part.f)
    gain = e_covariance @ part.f.T
    turn = part.std * part.own
    base = part.mean + turn * (gain @ part.residual)
    by_shared = part.std[:, None] * part.shared - turn[:, None] * (gain @ part.a)
    return _Own(base, by_shared, turn[:, None] * e_covariance * turn)
