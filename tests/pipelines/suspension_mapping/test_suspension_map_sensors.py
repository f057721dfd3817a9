"""A suspension map takes strut force sensors for as good as the estimators by strut forces do."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from pipelines.estimators.load_transfer.companion import SETTINGS
from pipelines.suspension_mapping.sample import Sample
from pipelines.suspension_mapping.train import _zero_n


def test_one_training_drive_has_the_siblings_sensors() -> None:
    defaults = {s.name: s.default for s in SETTINGS}
    sample = cast(
        "Sample", SimpleNamespace(measured=np.full(100, 4000.0), drive=np.zeros(100, dtype=np.int64))
    )
    scale, zero = defaults["force_scale_std"] * 4000, defaults["force_offset_std"]
    # the struts' scale and zero from one drive to the other, and the measuring wheels' scale
    assert _zero_n(sample, np.zeros(100)) == pytest.approx(np.sqrt(zero**2 + 2 * scale**2))
