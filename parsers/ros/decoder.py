"""Messages of one ROS type, decoded in bulk: `make_decoder` for the definition texts that logs hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.ros.contract import MISFIT, Cells, Decoded, FieldInfo
from parsers.ros.fields import Encoding, full_name
from parsers.ros.grammar import parse_types, standard_types
from parsers.ros.kernels import Program, Rows
from parsers.ros.layout import Layout, compile_layout
from parsers.ros.program import make_program, make_rows, make_shapes
from parsers.ros.replay import decode_rows

_UNREAD = {
    **dict.fromkeys((2, 3), "PL_CDR (parameter list)"),
    **dict.fromkeys((8, 9), "XCDR2 with delimiters (DELIMITED_CDR2)"),
    **dict.fromkeys((10, 11), "XCDR2 of mutable types (PL_CDR2)"),
}
"""Encapsulations that carry more than a type's fields (OMG DDS-XTYPES 1.3, table 60)."""


@dataclass(frozen=True)
class LayoutDecoder:
    """A `MessageDecoder` over a compiled layout. programs: those made so far, by the wanted field paths."""

    layout: Layout
    encoding: Encoding
    programs: dict[tuple[str, ...], Program] = field(default_factory=dict, compare=False, repr=False)

    @property
    def fields(self) -> Sequence[FieldInfo]:
        """All fields that can be asked for, and texts (which cannot)."""
        return self.layout.fields

    @property
    def has_header(self) -> bool:
        """Whether messages carry their own stamp."""
        return self.layout.has_header

    def decode(
        self,
        data: ByteArray,
        offset: IntArray,
        length: IntArray,
        wanted: Sequence[str],
        cells: Cells = np.empty,
    ) -> Decoded:
        """Decode payload i = data[offset[i] : offset[i] + length[i]] for all i; only the wanted field paths.

        Paths that are texts or unknown come back as NaN. Payloads that do not fit the type are NaN and counted.
        """
        # a view that cannot be written: memory-mapped, read and joined bytes then all use one compiled kernel
        view = np.ascontiguousarray(data, dtype=np.uint8).view()
        view.flags.writeable = False
        offset = np.ascontiguousarray(offset, dtype=np.int64)
        length = np.ascontiguousarray(length, dtype=np.int64)
        program = self.program(wanted)
        rows, bad = self._run(view, offset, length, program, cells)
        if self.layout.has_wstring and bad:
            # Fast CDR wrote four bytes for a wide character before version 2, and two since
            other = self._run(view, offset, length, program._replace(wide=2), cells)
            if other[1] < bad:
                rows, bad = other
        columns = rows.cells.reshape(len(wanted), len(offset))
        return Decoded(
            columns=dict(zip(wanted, columns, strict=True)),
            stamp_ns=rows.stamp if self.layout.has_header else None,
            bad=bad,
            why_bad=_why_bad(view, offset, length, bad) if bad and self.encoding == "cdr" else MISFIT,
        )

    def program(self, wanted: Sequence[str]) -> Program:
        """The program for these field paths; kept, since batch after batch asks for the same ones."""
        key = tuple(wanted)
        found = self.programs.get(key)
        if found is None:
            found = self.programs[key] = make_program([(self.layout, key)], self.encoding)
        return found

    def _run(
        self, data: ByteArray, offset: IntArray, length: IntArray, program: Program, cells: Cells
    ) -> tuple[Rows, int]:
        n = len(offset)
        rows = make_rows(program, np.array([n], dtype=np.int64), cells)
        shapes = make_shapes(program, self.layout.depth)
        return rows, decode_rows(data, offset, length, 0, 0, n, program, shapes, rows)


def _why_bad(data: ByteArray, offset: IntArray, length: IntArray, bad: int) -> str:
    """What payloads that could not be read are: of an encoding that is not read, where all of them say so."""
    inside = (offset >= 0) & (length >= 4) & (offset <= len(data) - length)
    first = data[offset[inside]].astype(np.int64) << 8 | data[offset[inside] + 1]
    unread = first[np.isin(first, list(_UNREAD))]
    if len(unread) < bad:
        return MISFIT
    return f"message in the encoding {_UNREAD[int(unread[0])]}, which is not read (cogest reads plain CDR and plain CDR2)"


def make_decoder(
    type_name: str, definition: str, encoding: Encoding, definition_format: str = "msg"
) -> LayoutDecoder:
    """A decoder for one message type.

    type_name: "sensor_msgs/Imu" or "sensor_msgs/msg/Imu". definition: the text as bags and MCAP schemas hold it, with
    the types that it uses after it ("====…" and "MSG: pkg/Type" or "IDL: pkg/msg/Type" before each); blank text
    means the standard type of that name, if there is one. encoding: "ros1", or "cdr" (ROS 2). definition_format:
    "msg" ("ros1msg", "ros2msg") or "idl" ("ros2idl", "omgidl").

    Fields: fixed arrays by element ("orientation_covariance[0]"), the first 8 elements of a sequence of numbers, the
    first 4 of a sequence of messages ("transforms[0].transform.rotation.w"), NaN where a message has fewer; times
    and durations as seconds. Sequences of bytes are blobs and are not listed. The stamp is that of a first-level
    `header`, or a first-level time named `stamp`.

    Raises LogError where the definition cannot be used.
    """
    types = parse_types(type_name, definition, encoding, definition_format)
    return LayoutDecoder(compile_layout(type_name, types, encoding), encoding)


def make_standard_decoder(type_name: str, encoding: Encoding) -> LayoutDecoder | None:
    """A decoder for a type of the ROS distributions, for logs without definitions. None for unknown types."""
    types = standard_types(full_name(type_name), encoding)
    return None if types is None else LayoutDecoder(compile_layout(type_name, types, encoding), encoding)
