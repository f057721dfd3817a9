"""The values of a group's wanted channels: plain ones by a compiled kernel, the others column by column."""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray
from parsers.mf4 import column_kernel as k
from parsers.mf4 import conversions, values
from parsers.mf4.batch import Batch
from parsers.mf4.clock import find_rule
from parsers.mf4.model import MASTER, Channel, Group
from parsers.mf4.words import word_of

_KINDS = {values.UINT_LE: k.UNSIGNED, values.INT_LE: k.SIGNED, values.FLOAT_LE: k.FLOAT_64}


INVALID = "invalid by the log's own invalidation bit"
TEXT = "a text of the channel's value table"
NO_NUMBER = "no number by the channel's conversion"


@dataclass(frozen=True)
class Columns:
    """Name -> values, shape (records,): NaN where there is none. left_out: channel, reason, and of which records."""

    values: dict[str, FloatArray]
    left_out: list[tuple[str, str, NDArray[np.bool_]]]


@dataclass(frozen=True)
class ColumnReader:
    """Reads some channels of a group. plain: the kernel's, with its rules and linear; others: the rest of them."""

    group: Group
    channels: dict[str, Channel]
    plain: tuple[str, ...]
    rules: IntArray
    linear: FloatArray

    def read(self, batch: Batch) -> Columns:
        """The values; NaN where the records say that they are not valid, or that they are no numbers."""
        quick = np.empty((len(self.plain), batch.count), np.float64)
        if quick.size:
            words = np.zeros(k.BLOCK, np.int64)
            singles = words.view(np.float32)[0 if sys.byteorder == "little" else 1 :]
            k.read_columns(
                batch.data, batch.stride, batch.skip, self.rules, self.linear, words, singles, quick
            )
        done = dict(zip(self.plain, quick, strict=True))
        marked = any(map(values.has_invalid_bit, self.channels.values()))
        bits = batch.invalid_rows() if marked else np.zeros((batch.count, 0), np.uint8)
        out = Columns({}, [])
        for name, channel in self.channels.items():
            column, none = (done[name], None) if name in done else _slow(batch, channel)
            bad = values.invalid(bits, channel)
            if bad is not None:
                out.left_out.append((name, INVALID, bad))
                column = np.where(bad, np.nan, column)
            if none is not None:
                why = TEXT if conversions.names_values(channel.conversion) else NO_NUMBER
                out.left_out.append((name, why, none if bad is None else none & ~bad))
            out.values[name] = column
        return out


def _slow(batch: Batch, channel: Channel) -> tuple[FloatArray, NDArray[np.bool_] | None]:
    """The values, and where the conversion makes none of a raw value; None where it can always."""
    raw = values.raw_values(batch.rows, channel, batch.first)
    whole = raw.dtype.kind != "f"
    numbers = raw.astype(np.float64)
    column = conversions.convert(channel.conversion, numbers, whole_numbers=whole)
    if find_rule(channel) is not None:
        return column, None
    return column, np.isnan(column) & ~np.isnan(numbers)


def column_reader(channels: dict[str, Channel], group: Group, *, compiled: bool = True) -> ColumnReader:
    """The reader of channels that have no fault. compiled: False to take the slower way anyway."""
    plain, rules, linear = [], [], []
    for name, channel in channels.items():
        word, rule = word_of(channel, group, *_KINDS), find_rule(channel)
        if word is None or rule is None or channel.kind == MASTER or not compiled:
            continue
        kind = _KINDS[word.kind]
        if kind == k.FLOAT_64 and word.bits == 32:
            kind = k.FLOAT_32
        scaled = (rule.factor, rule.offset) != (1.0, 0.0)
        plain.append(name)
        rules.append((word.at, word.shift, word.mask, kind, 64 - word.bits, int(scaled)))
        linear.append((rule.factor, rule.offset))
    return ColumnReader(
        group,
        channels,
        tuple(plain),
        np.array(rules, np.int64).reshape(-1, k.RULES),
        np.array(linear, np.float64).reshape(-1, 2),
    )
