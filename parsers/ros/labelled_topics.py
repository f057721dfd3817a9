"""MultiArrays whose dimension's label lists what stands at its places: "fl,fr,rl,rr" of a std_msgs/Float64MultiArray.

The label comes with every message, so it is read with every message: a value under another label than the first ones is none.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ChannelInfo, Chunk
from parsers.importer import ImportLog, LogReader
from parsers.ros.frame_topics import Reopen
from parsers.ros.joint_topics import SAMPLE_CHUNKS, SAMPLE_ROWS, bytes_of
from parsers.ros.layout import LABEL_LETTERS, label_path
from parsers.ros.over import OverMessages

_LABEL = "layout.dim[0].label"
_MARKS = re.compile(r"[,;/|]+")
OTHER_LABEL = "value of a list under another label than its first ones"


@dataclass(frozen=True)
class _Labelled:
    """A list whose label names its places. group: of the topic. path: of the message's part that is the MultiArray, with a dot behind it,
    or "". label: as bytes. names: what it says, place by place."""

    group: str
    path: str
    label: bytes
    names: tuple[str, ...]

    def letters(self) -> list[str]:
        """The channels that hold the label, letter by letter."""
        return _letters(self.group, self.path)

    def places(self) -> dict[str, str]:
        """Channel -> the name of its place."""
        return {f"{self.group}.{self.path}data[{k}]": name for k, name in enumerate(self.names)}


def _letters(group: str, path: str) -> list[str]:
    return [f"{group}.{label_path(path + _LABEL, j)}" for j in range(LABEL_LETTERS)]


def with_labels(reader: LogReader, reopen: Reopen, log: ImportLog) -> LogReader:
    """The reader, with the places of labelled lists named. A log without such lists is returned as it is.

    Raises LogError where the messages cannot be read.
    """
    lists = {
        (each.group, each.tags["field"].removesuffix(_LABEL))
        for each in reader.channels
        if each.family == "ros" and each.kind == "text" and each.tags.get("field", "").endswith(_LABEL)
    }
    if not lists:
        return reader
    found = _sampled(reopen(ImportLog()), sorted(lists))
    return LabelledReader(reader, tuple(found), log) if found else reader


def _sampled(reader: LogReader, lists: Sequence[tuple[str, str]]) -> list[_Labelled]:
    """The lists of which all of the first messages have one label that names places."""
    wanted = frozenset(name for group, path in lists for name in _letters(group, path))
    labels: dict[tuple[str, str], set[bytes]] = {each: set() for each in lists}
    seen = dict.fromkeys(lists, 0)
    for number, chunk in enumerate(reader.read(wanted)):
        for group, path in lists:
            letters = bytes_of(chunk, _letters(group, path)) if chunk.group == group else None
            if letters is not None:
                labels[group, path] |= {_text(row) for row in np.unique(letters[:SAMPLE_ROWS], axis=0)}
                seen[group, path] += 1
        if number >= SAMPLE_CHUNKS or all(count >= 3 for count in seen.values()):
            break
    found = []
    for (group, path), texts in labels.items():
        label = next(iter(texts)) if len(texts) == 1 else b""
        names = _names(label)
        if len(names) > 1:
            found.append(_Labelled(group, path, label, names))
    return found


def _text(letters: NDArray[np.uint8]) -> bytes:
    return letters.tobytes().partition(b"\0")[0]


def _names(label: bytes) -> tuple[str, ...]:
    """What a label says of each place; none where it may be cut off, or names two places alike."""
    text = label.decode("utf-8", "replace")
    pieces = _MARKS.split(text) if _MARKS.search(text) else text.split()
    names = tuple(piece.strip() for piece in pieces)
    whole = len(label) < LABEL_LETTERS and text.isprintable() and all(names)
    return names if whole and len({*names}) == len(names) else ()


@dataclass(frozen=True)
class LabelledReader(OverMessages):
    """A `LogReader` over another, with the places of labelled lists named."""

    lists: tuple[_Labelled, ...]
    log: ImportLog

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """The log's own; places have their name as a tag."""
        names: Mapping[str, str] = {
            channel: name for each in self.lists for channel, name in each.places().items()
        }
        return tuple(
            replace(info, tags=MappingProxyType({**info.tags, "element": names[info.name]}))
            if info.name in names
            else info
            for info in self.inner.channels
        )

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted channels, a named place's without the values of messages that have another label."""
        own = [each for each in self.lists if wanted & each.places().keys()]
        letters = frozenset(name for each in own for name in each.letters())
        for chunk in self.inner.read(wanted | letters):
            lists = [each for each in own if each.group == chunk.group]
            if not lists:
                yield chunk
                continue
            columns = {name: values for name, values in chunk.columns.items() if name not in letters}
            for each in lists:
                other = _others(chunk, each)
                if other.any():
                    named = {name: columns[name] for name in each.places() if name in columns}
                    held = np.any([np.isfinite(values) for values in named.values()], axis=0)
                    self.log.reject(OTHER_LABEL, int(np.count_nonzero(other & held)))
                    columns |= {name: np.where(other, np.nan, values) for name, values in named.items()}
            yield replace(chunk, columns=columns)


def _others(chunk: Chunk, labelled: _Labelled) -> NDArray[np.bool_]:
    """The messages that have another label, (n,)."""
    letters = bytes_of(chunk, labelled.letters())
    if letters is None:
        return np.zeros(len(chunk.time_ns), np.bool_)
    own = np.zeros(LABEL_LETTERS, np.uint8)
    own[: len(labelled.label)] = np.frombuffer(labelled.label, np.uint8)
    other: NDArray[np.bool_] = np.any(letters != own, axis=1)
    return other
