"""Random text logs in many dialects, with lines that are damaged at random: for tests of the text formats' kernels."""

from __future__ import annotations

import random
from collections.abc import Callable

_STRANGE = "0123456789abcdefABCDEF gGxX#.,:()[]-+_\t\r\x00\xff;/RrTtds"


def _payload(rng: random.Random, size: int) -> bytes:
    return rng.randbytes(size)


def _id(rng: random.Random) -> tuple[int, bool]:
    extended = rng.random() < 0.3
    return rng.randrange(1 << (29 if extended else 11)), extended


def _size(rng: random.Random, *, fd: bool) -> int:
    return rng.choice([8, 8, 8, 12, 16, 64, 3]) if fd else rng.choice([8] * 8 + [0, 1, 2, 3, 5, 7])


def candump_file(rng: random.Random, t: float) -> str:
    can_id, extended = _id(rng)
    fd = rng.random() < 0.2
    data = _payload(rng, _size(rng, fd=fd)).hex()
    data = data if rng.random() < 0.2 else data.upper()
    mark = rng.choice(["##0", "##1"]) if fd else "#"
    tail = rng.choice(["", "", "", " R", " T", "\r"])
    name = rng.choice(["can0", "can0", "vcan1", "slcan_long"])
    number = f"{can_id:08X}" if extended else f"{can_id:03X}"
    return f"({1_700_000_000 + t:017.6f}) {name} {number}{mark}{data}{tail}"


def candump_console(rng: random.Random, t: float) -> str:
    can_id, extended = _id(rng)
    fd = rng.random() < 0.2
    size = _size(rng, fd=fd)
    data = _payload(rng, size).hex(" ").upper()
    brackets = f"[{size:02d}]" if fd else f" [{size}]"
    tail = rng.choice(["", "", "   '.....'", " "])
    way = rng.choice(["", "", "RX - -  ", "TX B E  "])
    number = f"{can_id:08X}" if extended else f"{can_id:03X}"
    return f" ({1_700_000_000 + t:.6f})  can{rng.randrange(2)}  {way}{number}  {brackets}  {data}{tail}"


def candump_delta(rng: random.Random, t: float) -> str:
    return f" ({rng.random() * 0.5:010.6f})" + candump_console(rng, t).split(")", 1)[1]


def candump_dated(rng: random.Random, t: float) -> str:
    minute, second = divmod(t, 60)
    return (
        f" (2015-07-10 23:{int(minute) % 60:02d}:{second:09.6f})" + candump_console(rng, t).split(")", 1)[1]
    )


def asc_classic(rng: random.Random, t: float) -> str:
    can_id, extended = _id(rng)
    size = _size(rng, fd=False)
    data = _payload(rng, size).hex(" ")
    data = data if rng.random() < 0.2 else data.upper()
    number = f"{can_id:X}{'x' if extended else ''}"
    tail = rng.choice(["", "", f"  Length = {rng.randrange(300000)} BitCount = 120 ID = {can_id}", " ", "\r"])
    way = rng.choice(["Rx", "Rx", "Tx", "TxRq"])
    stamp = rng.choice([f"{t:11.6f}", f"{t:11.6f}", f"{t:.3f}", f"{t:.9f}", f"{t:.1f}"])
    return f"{stamp} {rng.randrange(1, 3)}  {number:15s} {way:4s} d {size} {data}{tail}"


def asc_fd(rng: random.Random, t: float) -> str:
    can_id, extended = _id(rng)
    size = _size(rng, fd=True)
    code = {12: "9", 16: "a", 64: "f"}.get(size, f"{size}")
    number = f"{can_id:x}{'x' if extended else ''}"
    name = rng.choice(["", "", "Engine_Data"])
    data = _payload(rng, size).hex(" ")
    return (
        f"{t:11.6f} CANFD {rng.randrange(1, 3):3d} Rx   {number:>8s}  {name:>12s} 1 0 {code} {size:2d} {data}"
        f"        0    0     1000        0        0"
    )


def asc_events(rng: random.Random, t: float) -> str:
    return rng.choice(
        [
            f"{t:11.6f} 1  ErrorFrame",
            f"{t:11.6f} 1  100             Rx   r 8",
            f"{t:11.6f} 1  Statistic: D 1 R 0 XD 0 XR 0 E 0 O 0 B 0.01%",
            f"{t:11.6f} SV: 3 0 1 ::Speed = 1",
            "// a comment",
            "",
            asc_classic(rng, t),
        ]
    )


def trc(version: str) -> Callable[[random.Random, float], str]:
    """Lines of one of TRC's versions."""

    def line(rng: random.Random, t: float) -> str:
        can_id, extended = _id(rng)
        fd = version in ("2.0", "2.1") and rng.random() < 0.2
        size = _size(rng, fd=fd)
        number = int(t * 1000) + 1
        text = f"{can_id:08X}" if extended else f"{can_id:04X}"
        data = _payload(rng, size).hex(" ").upper()
        bus, way, ms = rng.randrange(1, 3), rng.choice(["Rx", "Tx"]), t * 1000
        kind = "FD" if fd else rng.choice(["DT", "DT", "DT", "RR", "ST"])
        code = {12: 9, 16: 10, 64: 15}.get(size, size)
        return {
            "1.0": f"{number:6d}) {ms:9.0f}  {text}  {size}  {data} ",
            "1.1": f"{number:6d}) {ms:11.1f}  {way}     {text:>8s}  {size}  {data} ",
            "1.2": f"{number:6d}) {ms:13.3f} {bus}  {way}     {text:>8s}  {size}  {data} ",
            "1.3": f"{number:6d}) {ms:13.3f} {bus}  {way}    {text:>8s} -  {size}    {data} ",
            "2.0": f"{number:7d} {ms:13.3f} {kind} {text:>8s} {way} {size:<2d} {data} ",
            "2.1": f"{number:7d} {ms:13.3f} {kind} {bus} {text:>8s} {way} -  {code:<2d}   {data} ",
        }[version]

    return line


def damaged(rng: random.Random, line: str) -> str:
    """A line with one to three characters changed, taken out, put in, or cut off behind."""
    for _ in range(rng.choice([1, 1, 2, 3])):
        at = rng.randrange(len(line) + 1)
        kind = rng.random()
        if kind < 0.5:
            line = line[:at] + rng.choice(_STRANGE) + line[at + 1 :]
        elif kind < 0.7:
            line = line[:at] + line[at + 1 :]
        elif kind < 0.9:
            line = line[:at] + rng.choice(_STRANGE) + line[at:]
        else:
            line = line[:at]
    return line


def random_log(
    kinds: list[Callable[[random.Random, float], str]], seed: int, lines: int, share: float = 0.15
) -> bytes:
    """A log of lines of these kinds, of which a share is damaged; some end with carriage return and line feed."""
    rng = random.Random(seed)
    t = rng.choice([0.0, 8.0, 95.0, 9_990.0, 3_590.0])
    out = []
    for _ in range(lines):
        t += rng.choice([0.0005, 0.001, 0.3, 0.0123456])
        line = rng.choice(kinds)(rng, t)
        if rng.random() < share:
            line = damaged(rng, line)
        out.append(line + ("\r\n" if rng.random() < 0.1 else "\n"))
    text = "".join(out)
    return (text if rng.random() < 0.5 else text[: -rng.randrange(1, 40)]).encode("latin-1")
