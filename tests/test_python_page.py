"""The examples of docs/python.md run as they stand."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]


def test_the_examples_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(ROOT / "sample_logs" / "ros" / "drive_ros2.mcap", tmp_path / "drive.mcap")
    shutil.copy(ROOT / "sample_logs" / "vehicle.toml", tmp_path / "vehicle.toml")
    (tmp_path / "settings.toml").write_text("[roll_map]\ncutoff_hz = 6\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) == 3
    names: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert names["table"].height == names["accel"].values.size > 1000
    assert "roll_map" in names["ran"]
    assert [e.estimator for e in names["again"].estimates] == ["roll_map"]
    assert {"report.html", "results.json"} <= {path.name for path in (tmp_path / "out").iterdir()}
    assert "m, 95 % between" in capsys.readouterr().out
