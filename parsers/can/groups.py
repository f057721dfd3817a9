"""The signals of a stream, grouped by the frames that they are in, and what they are called."""

from __future__ import annotations

from dataclasses import dataclass

from parsers.can.definitions import Gate, SignalDef
from parsers.can.frames import EXTENDED
from parsers.can.matching import Stream
from parsers.can.standard import standard_signal
from parsers.channels import ChannelInfo


@dataclass(frozen=True)
class Group:
    """Signals of a stream that are in the same frames: channel name -> definition."""

    name: str
    stream: Stream
    gates: tuple[Gate, ...]
    signals: dict[str, SignalDef]


def groups_of(stream: Stream) -> list[Group]:
    """One group for the signals in every frame, and one for each multiplexer value or set of values."""
    groups: dict[tuple[Gate, ...], Group] = {}
    base = stream.message.name + stream.suffix
    for signal in stream.message.signals:
        group = groups.get(signal.gates)
        if group is None:
            name = "/".join([base, *(_gate_text(gate) for gate in reversed(signal.gates))])
            group = groups[signal.gates] = Group(name, stream, signal.gates, {})
        group.signals[f"{stream.message.name}.{signal.name}{stream.suffix}"] = signal
    return list(groups.values())


def _gate_text(gate: Gate) -> str:
    """A multiplexer and its values as text, neighbours drawn together: "Mode=0-3,7"."""
    runs: list[list[int]] = []
    for value in gate.values:
        if runs and value == runs[-1][1] + 1:
            runs[-1][1] = value
        else:
            runs.append([value, value])
    return f"{gate.multiplexer}=" + ",".join(f"{a}" if a == b else f"{a}-{b}" for a, b in runs)


def channel_of(group: Group, name: str, signal: SignalDef) -> ChannelInfo:
    """What the log's list of channels says of a signal."""
    stream = group.stream
    # the id in the log, which for J1939 may differ from the database's
    can_id = stream.keys[0] & 0xFFFF_FFFF
    tags = {
        "message": stream.message.name,
        "signal": signal.name,
        "id": str(can_id & ~EXTENDED),
        "bus": str(stream.bus),
    }
    if can_id & EXTENDED:
        tags["extended"] = "1"
    if stream.pgn is not None and stream.sender is not None:
        tags["pgn"] = str(stream.pgn)
        tags["source_address"] = str(stream.sender)
    spn = signal.spn
    if stream.standard is not None:
        # databases call a parameter group and its signals as they like; profiles know them by J1939's names
        tags["message"] = stream.standard.name
        own = standard_signal(signal, stream.standard)
        if own is not None:
            tags["signal"], spn = own.name, spn or own.spn
    if spn is not None:
        tags["spn"] = str(spn)
    if stream.builtin:
        tags["builtin"] = "1"
    return ChannelInfo(
        name=name,
        group=group.name,
        unit=signal.unit,
        family="can",
        count=None if group.gates else stream.frames,
        comment=signal.comment,
        tags=tags,
    )
