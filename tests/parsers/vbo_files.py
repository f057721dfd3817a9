"""VBO files for the tests: built by hand, then read whole."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from parsers.channels import ChannelInfo, FloatArray, IntArray
from parsers.importer import ImportLog, ReadOptions
from parsers.vbo_log import VboImporter

TITLES = [
    "satellites",
    "time",
    "latitude",
    "longitude",
    "velocity kmh",
    "heading",
    "height",
    "vertical velocity kmh",
    "Event 1 time",
    "latitude_raw",
    "Yaw_Rate",
    "Lat Accel",
    "Temp",
]
NAMES = "sats time lat long velocity heading height vert-vel event-1 _lat Yaw_Rate LatAccel Temp"
UNITS = ["°/s", "g", ""]


def row(time: str, yaw: str = "-1.000000E+00", sats: str = "009") -> str:
    return f"{sats} {time} +3608.22250787 -01086.93269549 008.931 231.91 +0036.11 -0000.06 0.000000 +3608.2 {yaw} +1.247217E-02 +1.060000E+01 "


def vbo(
    rows: list[str],
    *,
    names: str = NAMES,
    titles: list[str] = TITLES,
    units: list[str] = UNITS,
    created: str = "File created on 11/04/2014 @ 09:42     ",
    end: str = "\r\n",
) -> bytes:
    lines = [
        created,
        "",
        "[header]",
        *titles,
        "",
        "[channel units]",
        *units,
        "",
        "[comments]",
        "Log Rate (Hz) : 100.00",
        "",
        "[laptiming]",
        "Start +5773.4 +1832.2 +5773.4 +1832.2",
        "",
        "[column names]",
        f"{names} ",
        "",
        "[data]",
        *rows,
    ]
    return ("\r\n".join(lines) + end).encode("latin-1")


class Read:
    """A log read whole."""

    def __init__(self, path: Path) -> None:
        self.log = ImportLog()
        assert VboImporter().claims(path, path.read_bytes()[:4096])
        self.reader = VboImporter().open(path, ReadOptions(), self.log)
        self.info: dict[str, ChannelInfo] = {channel.name: channel for channel in self.reader.channels}
        chunks = list(self.reader.read(frozenset(self.info)))
        self.time: IntArray = np.concatenate([chunk.time_ns for chunk in chunks])
        self.columns: dict[str, FloatArray] = {
            name: np.concatenate([chunk.columns[name] for chunk in chunks]) for name in self.info
        }

    @property
    def said(self) -> str:
        return "\n".join(self.log.notes)


def read(tmp_path: Path, data: bytes) -> Read:
    path = tmp_path / "log.vbo"
    path.write_bytes(data)
    return Read(path)


def utc_ns(text: str) -> int:
    moment = datetime.fromisoformat(text).replace(tzinfo=UTC)
    return int(moment.timestamp()) * 10**9 + moment.microsecond * 1000
