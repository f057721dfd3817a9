"""A new format is one file and one registry line: this test adds one."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import parsers.registry
from parsers.load import load_drive

MODULE = """
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from parsers.channels import ChannelInfo, Chunk
from parsers.importer import ImportLog, LogReader, ReadOptions


class Reader:
    clock = "counter"
    absolute = False
    start_utc_ns = None
    channels = (ChannelInfo("ay", "rows", "g"), ChannelInfo("v", "rows", "km/h"))

    def __init__(self, path: Path, log: ImportLog) -> None:
        self.path, self.log = path, log

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        table = np.loadtxt(self.path, skiprows=1, ndmin=2)
        self.log.messages += len(table)
        columns = {name: table[:, i] for i, name in enumerate(("ay", "v"), start=1) if name in wanted}
        yield Chunk("rows", (table[:, 0] * 1e9).astype(np.int64), columns)


class KeyValueImporter:
    name = "keyvalue"
    title = "Key=value lines"
    suffixes = (".kv",)

    def claims(self, path: Path, head: bytes) -> bool:
        return head.startswith(b"#KV1")

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
        return Reader(path, log)
"""


def test_one_file_and_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "keyvalue_log.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(
        parsers.registry, "FORMATS", ("keyvalue_log:KeyValueImporter", *parsers.registry.FORMATS)
    )
    log = tmp_path / "drive.kv"
    rows = "\n".join(f"{i / 10:.1f} {0.01 * i:.2f} 36" for i in range(20))
    log.write_text(f"#KV1\n{rows}\n", encoding="ascii")
    drive = load_drive([log])
    assert drive.record.format == "Key=value lines"
    assert np.allclose(drive.signals["accel_y"].values, 0.01 * np.arange(20) * 9.80665)
    assert np.allclose(drive.signals["speed"].values, 10.0)
    sys.modules.pop("keyvalue_log", None)
