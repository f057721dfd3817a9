"""CAN logs of a drive: 40 identifiers of which 12 are in the DBC (30 % of the frames), 32 signals.

Written as bytes in bulk, because a writer library would take longer than all the reading that is measured.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

KNOWN, OTHERS = 12, 28
CONTAINER = 128 * 1024
FRAMES_PER_SECOND = 2111
"""3.8 million frames in 30 minutes."""


@dataclass(frozen=True)
class Frames:
    """time_ns (n,) from the start, can_id (n,), data (n, width)."""

    time_ns: NDArray[np.int64]
    can_id: NDArray[np.uint32]
    data: NDArray[np.uint8]


def database(width: int) -> str:
    """The DBC: 12 messages; 8 of three signals and 4 of two, 16 bit, both byte orders."""
    lines = ['VERSION ""', "", "NS_ :", "", "BS_:", "", "BU_: X", ""]
    for number in range(KNOWN):
        lines.append(f"BO_ {256 + number} Message{number}: {width} X")
        for k in range(3 if number < 8 else 2):
            order = f"{16 * k}|16@1-" if number % 2 else f"{16 * k + 7}|16@0-"
            lines.append(f' SG_ Signal{k} : {order} (0.01,0) [-327|327] "m/s^2" X')
        lines.append("")
    return "\n".join(lines)


def make_frames(seconds: float, width: int, seed: int) -> Frames:
    """Frames at an even rate, identifiers and the first six bytes at random, the rest constant as in real traffic."""
    rng = np.random.default_rng(seed)
    n = round(seconds * FRAMES_PER_SECOND)
    wanted = rng.random(n) < 0.3
    known, other = 256 + rng.integers(0, KNOWN, n), 1024 + rng.integers(0, OTHERS, n)
    data = np.zeros((n, width), dtype=np.uint8)
    data[:, :6] = rng.integers(0, 256, (n, 6), dtype=np.uint8)
    # microseconds: the finest that every text format carries
    time_ns = np.linspace(0, seconds * 1e6, n, endpoint=False).astype(np.int64) * 1000
    return Frames(time_ns, np.where(wanted, known, other).astype(np.uint32), data)


def with_motion(frames: Frames, seed: int) -> Frames:
    """The same frames with signals that move as a vehicle's do: slow waves and a little noise instead of random numbers."""
    rng = np.random.default_rng(seed)
    data = frames.data.copy()
    time_s = frames.time_ns / 1e9
    for number in range(KNOWN):
        rows = np.flatnonzero(frames.can_id == 256 + number)
        for k in range(3):
            low, high = rng.uniform(0.05, 0.2), rng.uniform(0.3, 1.0)
            wave = np.sin(2 * np.pi * low * time_s[rows]) + 0.4 * np.sin(2 * np.pi * high * time_s[rows] + k)
            raw = (12_000 * wave + rng.normal(0, 40, len(rows))).astype(np.int16)
            order = "<i2" if number % 2 else ">i2"
            data[rows, 2 * k : 2 * k + 2] = raw.astype(order).view(np.uint8).reshape(-1, 2)
    return Frames(frames.time_ns, frames.can_id, data)


def _blf_file(objects: NDArray[np.void], path: Path) -> None:
    raw = objects.tobytes()
    with path.open("wb") as file:
        file.write(bytes(144))
        for at in range(0, len(raw), CONTAINER):
            part = raw[at : at + CONTAINER]
            packed = zlib.compress(part, 6)
            file.write(b"LOBJ" + struct.pack("<HHII", 16, 1, 32 + len(packed), 10))
            file.write(struct.pack("<HxxxxxxIxxxx", 2, len(part)) + packed + bytes((32 + len(packed)) % 4))
        size = file.tell()
        head = bytearray(144)
        struct.pack_into("<4sI", head, 0, b"LOGG", 144)
        struct.pack_into("<QQII", head, 16, size, 144 + len(raw), len(objects), 0)
        struct.pack_into("<8H", head, 40, 2025, 10, 4, 9, 8, 53, 20, 0)
        struct.pack_into("<8H", head, 56, 2025, 10, 4, 9, 9, 23, 20, 0)
        file.seek(0)
        file.write(head)


def _objects(dtype: list[tuple[object, ...]], kind: int, frames: Frames) -> NDArray[np.void]:
    head = [("sig", "S4"), ("hs", "<u2"), ("hv", "<u2"), ("size", "<u4"), ("kind", "<u4")]
    head += [("flags", "<u4"), ("client", "<u2"), ("version", "<u2"), ("time", "<u8")]
    objects = np.zeros(len(frames.time_ns), dtype=np.dtype([*head, *dtype]))
    objects["sig"], objects["hs"], objects["hv"] = b"LOBJ", 32, 1
    objects["size"], objects["kind"], objects["flags"] = objects.dtype.itemsize, kind, 2
    objects["time"], objects["id"], objects["bus"] = frames.time_ns, frames.can_id, 1
    objects["data"] = frames.data
    return objects


def write_blf(frames: Frames, path: Path) -> None:
    """CAN_MESSAGE objects in compressed containers."""
    layout = [("bus", "<u2"), ("f", "u1"), ("dlc", "u1"), ("id", "<u4"), ("data", "u1", (8,))]
    objects = _objects(layout, 1, frames)
    objects["dlc"] = 8
    _blf_file(objects, path)


def write_blf_fd(frames: Frames, path: Path) -> None:
    """CAN_FD_MESSAGE objects of 64 bytes in compressed containers."""
    layout = [("bus", "<u2"), ("f", "u1"), ("dlc", "u1"), ("id", "<u4"), ("length", "<u4"), ("bits", "u1")]
    layout += [("fd", "u1"), ("valid", "u1"), ("r1", "u1"), ("r2", "<u4"), ("data", "u1", (64,))]
    objects = _objects(layout, 100, frames)
    objects["dlc"], objects["fd"], objects["valid"] = 15, 1, 64
    _blf_file(objects, path)


def _lines(frames: Frames, form: str, path: Path, head: str) -> None:
    """One line a frame: `form` is given seconds, microseconds, milliseconds, number, id, compact and spaced bytes."""
    text = frames.data.tobytes().hex().upper()
    width = 2 * frames.data.shape[1]
    with path.open("w", encoding="ascii", newline="") as file:
        file.write(head)
        times, ids = (frames.time_ns // 1000).tolist(), frames.can_id.tolist()
        for i, (us, name) in enumerate(zip(times, ids, strict=True)):
            packed = text[i * width : (i + 1) * width]
            spaced = " ".join(packed[k : k + 2] for k in range(0, width, 2))
            file.write(
                form.format(
                    s=us // 1_000_000, us=us % 1_000_000, ms=us / 1000, n=i + 1, id=name, p=packed, b=spaced
                )
            )


def write_candump(frames: Frames, path: Path) -> None:
    """candump -l."""
    _lines(frames, "({s:010d}.{us:06d}) can0 {id:03X}#{p}\n", path, "")


def write_asc(frames: Frames, path: Path) -> None:
    """Vector ASC, absolute stamps."""
    head = "date Thu Oct 9 08:53:20.000 am 2025\nbase hex  timestamps absolute\ninternal events logged\n"
    _lines(frames, "{s:4d}.{us:06d} 1  {id:<15X} Rx   d 8 {b}\n", path, head)


def write_trc(frames: Frames, path: Path) -> None:
    """PEAK TRC 2.1."""
    head = ";$FILEVERSION=2.1\n;$STARTTIME=45939.370370\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n"
    _lines(frames, "{n:7d} {ms:13.3f} DT 1      {id:04X} Rx -  8    {b} \n", path, head)
