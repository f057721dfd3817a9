"""The estimators that cogest has: one line each."""

from __future__ import annotations

import importlib
from functools import cache
from typing import cast

from pipelines.estimators.base import Estimator

ESTIMATORS: tuple[str, ...] = (
    "pipelines.estimators.roll_map.estimator:RollMap",
    "pipelines.estimators.marginalized_particle_filter.estimator:MarginalizedParticleFilter",
    "pipelines.estimators.base_excitation.companion:BaseExcitationBatch",
    "pipelines.estimators.base_excitation.estimator:BaseExcitation",
    "pipelines.estimators.axle_load_gls.estimator:AxleLoadGls",
    "pipelines.estimators.hekf_ekf.estimator:HekfEkf",
    "pipelines.estimators.brake_roll.estimator:BrakeRollBatch",
    "pipelines.estimators.integrated_observer.estimator:IntegratedObserver",
    "pipelines.estimators.load_balance.estimator:LoadBalance",
    "pipelines.estimators.load_transfer.companion:LoadTransferBatch",
    "pipelines.estimators.load_transfer.published:LoadTransfer",
    "pipelines.estimators.load_transfer.published:ModifiedLoadTransfer",
    "pipelines.estimators.load_transfer.published:HighFrequencyLoadTransfer",
    "pipelines.estimators.gpc_bayesian_map.estimator:GpcBayesianMap",
    "pipelines.estimators.suspension_mapping.estimator:SuspensionMapping",
    "pipelines.estimators.roll_pitch_plane.roll:RollPlane",
    "pipelines.estimators.roll_pitch_plane.pitch:PitchPlane",
    "pipelines.estimators.roll_pitch_plane.published:GpcRollPlane",
)


@cache
def estimator_at(line: str) -> Estimator:
    """The estimator that a registry line "module:Class" names. Loaded when first asked for."""
    module, _, name = line.partition(":")
    return cast("Estimator", getattr(importlib.import_module(module), name)())


def estimators() -> tuple[Estimator, ...]:
    """All estimators, in the registry's order."""
    return tuple(estimator_at(line) for line in ESTIMATORS)
