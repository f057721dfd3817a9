"""JSON messages of one topic, decoded in bulk."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import polars as pl

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.errors import LogError
from parsers.field_notes import MAX_FIELDS, join_stamp, stamp_fields
from parsers.json_kernel import read_documents
from parsers.json_stamps import NumberStamp, may_have_stamp, number_stamp
from parsers.json_tree import (
    FlatTree,
    JsonNode,
    add_sample,
    add_schema,
    flatten,
    has_open_places,
    read_sample,
)
from parsers.mcap_records import gather
from parsers.ros.contract import Cells, Decoded, FieldInfo

SAMPLES = 96
"""So many messages are looked at for the fields that a schema does not name."""

_NUMBER = re.compile(r"[-+]?\d+[.,]\d+([eE][-+]?\d+)?")
"""A number that is a measurement: whole ones may be names."""

_SLOW_BYTES = 4
"""The shortest number whose value only its text tells is "1e23"."""


@dataclass(frozen=True)
class _Tables:
    """The tables of `read_documents`."""

    nodes: IntArray
    items: IntArray
    keys: IntArray
    names: ByteArray


def _spellings(key: str) -> list[bytes]:
    """How a key may stand in a message: as it is, and with everything beyond ASCII escaped."""
    plain = json.dumps(key, ensure_ascii=False)[1:-1].encode("utf-8", "surrogatepass")
    escaped = json.dumps(key)[1:-1].encode()
    return [plain] if plain == escaped else [plain, escaped]


def _known(node: JsonNode) -> bool:
    """Whether anything but null is known of a place; else what comes there later counts as new."""
    return bool(node.number or node.text or node.keys or node.items)


def _compile(tree: FlatTree, column_of: Mapping[str, int], stamp: tuple[str, str] | None) -> _Tables:
    number_of = {id(node): number for number, (_, node) in enumerate(tree.nodes)}
    stamp_of = {path: k for k, path in enumerate(stamp or ())}
    nodes: list[list[int]] = []
    items: list[int] = []
    keys: list[list[int]] = []
    names = bytearray()
    for path, node in tree.nodes:
        first_key, first_item = len(keys), len(items)
        for key, inner in node.keys.items():
            if not _known(inner):
                continue
            for spelling in _spellings(key):
                keys.append([len(names), len(spelling), number_of[id(inner)]])
                names += spelling
        items += [number_of[id(inner)] for inner in node.items]
        column = column_of.get(path, -1) if node.number else -1
        stamp_at = stamp_of.get(path, -1) if node.number else -1
        nodes.append([first_key, len(keys), first_item, len(node.items), column, stamp_at, bool(node.keys)])
    return _Tables(
        np.array(nodes, dtype=np.int64).reshape(len(nodes), 7),
        np.array(items, dtype=np.int64),
        np.array(keys, dtype=np.int64).reshape(len(keys), 3),
        np.frombuffer(bytes(names), dtype=np.uint8),
    )


def _read_texts(data: ByteArray, slow: IntArray) -> FloatArray:
    """The values of number texts: rows (place, length, …) of `slow`; shape (n,)."""
    # one text a line; the byte behind a number is no part of it and becomes the line's end
    lengths = slow[:, 1] + 1
    text = np.full(int(lengths.sum()), 10, dtype=np.uint8)
    starts = np.cumsum(lengths) - lengths
    gather(data, slow[:, 0].copy(), slow[:, 1].copy(), starts, text)
    frame = pl.read_csv(text.tobytes(), has_header=False, schema={"value": pl.Float64})
    return frame["value"].to_numpy().astype(np.float64)


@dataclass(frozen=True)
class JsonDecoded(Decoded):
    """new_keys: how many keys with a value came up that no field is known for, and the first of them."""

    new_keys: int = 0
    first_new_key: str = ""


@dataclass
class NewKeys:
    """The keys of one topic that came up only after its fields were listed, batch by batch."""

    count: int = 0
    first: str = ""

    def add(self, decoded: Decoded) -> None:
        """Take in what a batch found; batches in the order of the log."""
        if isinstance(decoded, JsonDecoded) and decoded.new_keys:
            self.count += decoded.new_keys
            self.first = self.first or decoded.first_new_key

    @property
    def notes(self) -> tuple[str, ...]:
        """The sentence for the user, where there is something to say."""
        if not self.count:
            return ()
        return (
            f"a key that neither the schema nor the messages that were looked at have came up and was not read "
            f"({self.count} times, the first is {self.first!r})",
        )


@dataclass(frozen=True)
class JsonDecoder:
    """A `MessageDecoder` for JSON messages. notes: what of the messages cannot be given."""

    tree: FlatTree
    notes: tuple[str, ...] = ()
    _paths: frozenset[str] = frozenset()
    _stamp: tuple[str, str] | None = None
    _number_stamp: NumberStamp | None = None
    _programs: dict[tuple[str, ...], _Tables] = field(default_factory=dict, compare=False, repr=False)

    @property
    def fields(self) -> Sequence[FieldInfo]:
        """All places with numbers or text, lists by element."""
        return self.tree.fields

    @property
    def has_header(self) -> bool:
        """Whether messages carry their own stamp."""
        return self._stamp is not None or self._number_stamp is not None

    def decode(
        self,
        data: ByteArray,
        offset: IntArray,
        length: IntArray,
        wanted: Sequence[str],
        cells: Cells = np.empty,
    ) -> JsonDecoded:
        """Decode payload i = data[offset[i] : offset[i] + length[i]] for all i; only the wanted field paths.

        true is 1.0, false 0.0; null, text and absent are NaN.
        """
        own = () if self._number_stamp is None else (self._number_stamp.path,)
        paths = dict.fromkeys(p for p in (*wanted, *own) if p in self._paths)
        column_of = {path: row for row, path in enumerate(paths)}
        tables = self._program(tuple(wanted), column_of)
        view = np.ascontiguousarray(data, dtype=np.uint8).view()
        view.flags.writeable = False
        out = cells(len(column_of) * offset.size).reshape(len(column_of), offset.size)
        stamps = np.empty((offset.size, 2), dtype=np.int64)
        room = min(int(np.maximum(length, 0).sum()), view.size) // _SLOW_BYTES + 1
        slow = np.empty((min(room, 2 * out.size + 16), 3), dtype=np.int64)
        unknown = np.zeros(3, dtype=np.int64)
        bad, used = read_documents(
            view,
            np.ascontiguousarray(offset, dtype=np.int64),
            np.ascontiguousarray(length, dtype=np.int64),
            *(tables.nodes, tables.items, tables.keys, tables.names, out, stamps, slow, unknown),
        )
        if used:
            slow = slow[:used]
            flat = out.reshape(-1)
            # a later value of the same key, read at once, holds
            open_cells = np.isnan(flat[slow[:, 2]])
            flat[slow[open_cells, 2]] = _read_texts(view, slow)[open_cells]
        new = view[unknown[1] : unknown[1] + unknown[2]].tobytes().decode("utf-8", "replace")[:60]
        return JsonDecoded(
            columns={
                path: out[column_of[path]] if path in column_of else np.full(offset.size, np.nan)
                for path in wanted
            },
            stamp_ns=self._stamp_ns(stamps, out, column_of),
            bad=int(bad),
            new_keys=int(unknown[0]),
            first_new_key=new,
        )

    def _program(self, wanted: tuple[str, ...], column_of: Mapping[str, int]) -> _Tables:
        """The tables for these paths; kept, since batch after batch asks for the same ones."""
        found = self._programs.get(wanted)
        if found is None:
            found = self._programs[wanted] = _compile(self.tree, column_of, self._stamp)
        return found

    def _stamp_ns(self, stamps: IntArray, out: FloatArray, column_of: Mapping[str, int]) -> IntArray | None:
        if self._number_stamp is not None:
            return self._number_stamp.stamps(out[column_of[self._number_stamp.path]])
        if self._stamp is None:
            return None
        return np.where(stamps[:, 1] < 0, 0, join_stamp(stamps[:, 0], stamps[:, 1]))


def numbers_as_texts(decoder: JsonDecoder) -> list[str]:
    """The fields whose messages hold nothing but numbers in quotes ("12.5"), which are texts to JSON."""
    texts = {path: node.texts for path, node in decoder.tree.nodes if node.texts and not node.number}
    return [path for path, held in texts.items() if all(_NUMBER.fullmatch(text) for text in held)]


def needs_samples(definition: bytes) -> bool:
    """Whether messages must be looked at to know the fields: no JSON schema, or one that leaves places open."""
    root = JsonNode()
    return not add_schema(root, definition) or has_open_places(root) or may_have_stamp(root.keys)


def make_json_decoder(definition: bytes, samples: Sequence[bytes] = ()) -> JsonDecoder:
    """A decoder for the messages of one topic.

    definition: the JSON schema, or b"". samples: some messages, for the fields that the schema does not name.
    Fields: nested objects as "a.b", the first 8 elements of lists as "[0]". The stamp is a first-level header.stamp,
    timestamp or stamp with sec and nanosec (nsec), or as one number since 1970. Raises LogError where there is no field.
    """
    root = JsonNode()
    add_schema(root, definition)
    messages = [read_sample(payload) for payload in samples[:SAMPLES]]
    for message in messages:
        add_sample(root, message)
    tree = flatten(root)
    if not tree.fields:
        raise LogError("neither the JSON schema nor the first messages have a field that could be a channel")
    notes = [f"two places share the name {path!r}; only the first is read" for path in tree.clashes[:3]]
    if tree.full:
        notes.append(f"the messages have more than {MAX_FIELDS} fields; only the first are listed")
    paths = frozenset(info.path for info in tree.fields if info.kind == "number")
    stamp = stamp_fields(paths)
    alone = number_stamp(messages) if stamp is None else None
    alone = alone if alone is not None and alone.path in paths else None
    return JsonDecoder(tree, tuple(notes), paths, stamp, alone)
