"""Rows in memory: brought together, and written over only where nobody else holds them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.intake import Intake
from parsers.load import load_drive
from parsers.mapping import read_map
from parsers.opened_log import LoadOptions

ROWS = 70_000
"""More than one chunk of a table."""


def test_only_columns_made_here_may_be_written_over() -> None:
    infos = [ChannelInfo(name, "g", None) for name in ("a", "b")]
    intake = Intake()
    whole = intake.begin(infos, frozenset("ab"))
    given = np.arange(5.0)
    whole.add("g", np.arange(5) * 1000, {"a": given, "b": given})
    assert whole.groups()["g"].own == frozenset()
    parts = intake.begin(infos, frozenset("ab"))
    for start in (0, 5):
        parts.add("g", (start + np.arange(5)) * 1000, {"a": given, "b": given})
    assert parts.groups()["g"].own == {"a", "b"}
    late = intake.begin(infos, frozenset("ab"))
    late.add("g", np.array([0, 2000, 1000]), {"a": given[:3], "b": given[:3]})
    group = late.groups()["g"]
    assert group.own == {"a", "b"}
    assert list(group.columns["a"]) == [0, 2, 1]
    assert list(given) == [0, 1, 2, 3, 4]


def test_one_channel_in_two_signals_keeps_its_values(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    time, raw = np.arange(ROWS) * 0.01, np.round(rng.normal(0, 1, ROWS), 4)
    log, table = tmp_path / "log.csv", tmp_path / "map.toml"
    # late rows: the columns are then made anew
    order = np.arange(ROWS)
    order[100:102] = 101, 100
    lines = [f"{time[k]:.2f},{raw[k]:.4f}" for k in order]
    log.write_text("t,x\n" + "\n".join(lines) + "\n", encoding="utf-8")
    table.write_text(
        '[time]\nchannel = "t"\nunit = "s"\n'
        '[signals.accel_x]\nchannel = "x"\nunit = "m/s²"\nscale = 0.5\n'
        '[signals.accel_y]\nchannel = "x"\nunit = "m/s²"\nscale = 2.0\n',
        encoding="utf-8",
    )
    drive = load_drive([log], LoadOptions(map=read_map(table), fix=False))
    assert drive.signals["accel_x"].values == pytest.approx(raw * 0.5)
    assert drive.signals["accel_y"].values == pytest.approx(raw * 2.0)
