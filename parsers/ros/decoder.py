"""Messages of one ROS type, decoded in bulk: `make_decoder` for the definition texts that logs hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.ros.contract import Decoded, FieldInfo, MessageDecoder
from parsers.ros.grammar import Encoding, full_name, parse_types, standard_types
from parsers.ros.kernels import decode_all
from parsers.ros.layout import Layout, compile_layout, specialise


@dataclass(frozen=True)
class LayoutDecoder:
    """A `MessageDecoder` over a compiled layout."""

    layout: Layout
    encoding: Encoding

    @property
    def fields(self) -> Sequence[FieldInfo]:
        """All fields that can be asked for, and texts (which cannot)."""
        return self.layout.fields

    @property
    def has_header(self) -> bool:
        """Whether messages carry their own stamp."""
        return self.layout.has_header

    def decode(self, data: ByteArray, offset: IntArray, length: IntArray, wanted: Sequence[str]) -> Decoded:
        """Decode payload i = data[offset[i] : offset[i] + length[i]] for all i; only the wanted field paths.

        Paths that are texts or unknown come back as NaN. Payloads that do not fit the type are NaN and counted.
        """
        ops, table = specialise(self.layout, wanted, self.encoding)
        # a view that cannot be written: memory-mapped, read and joined bytes then all use one compiled kernel
        view = np.ascontiguousarray(data, dtype=np.uint8).view()
        view.flags.writeable = False
        offset = np.ascontiguousarray(offset, dtype=np.int64)
        length = np.ascontiguousarray(length, dtype=np.int64)
        columns, stamp_ns, whole = self._run(view, offset, length, ops, table, len(wanted), 4)
        if self.layout.has_wstring and not whole.all():
            # Fast CDR wrote four bytes for a wide character before version 2, and two since
            other = self._run(view, offset, length, ops, table, len(wanted), 2)
            if other[2].sum() > whole.sum():
                columns, stamp_ns, whole = other
        broken = ~whole
        if broken.any():
            columns[:, broken] = np.nan
            stamp_ns[broken] = 0
        return Decoded(
            columns=dict(zip(wanted, columns, strict=True)),
            stamp_ns=stamp_ns if self.layout.has_header else None,
            bad=int(broken.sum()),
        )

    def _run(
        self,
        data: ByteArray,
        offset: IntArray,
        length: IntArray,
        ops: IntArray,
        table: IntArray,
        k: int,
        wide: int,
    ) -> tuple[FloatArray, IntArray, np.ndarray[tuple[int], np.dtype[np.bool_]]]:
        n = len(offset)
        columns = np.full((k, n), np.nan)
        stamp_ns = np.zeros(n, dtype=np.int64)
        whole = np.zeros(n, dtype=np.bool_)
        cdr = self.encoding == "cdr"
        decode_all(data, offset, length, cdr, wide, self.layout.depth, ops, table, columns, stamp_ns, whole)
        return columns, stamp_ns, whole


def make_decoder(
    type_name: str, definition: str, encoding: Encoding, definition_format: str = "msg"
) -> MessageDecoder:
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


def make_standard_decoder(type_name: str, encoding: Encoding) -> MessageDecoder | None:
    """A decoder for a type of the ROS distributions, for logs without definitions. None for unknown types."""
    types = standard_types(full_name(type_name), encoding)
    return None if types is None else LayoutDecoder(compile_layout(type_name, types, encoding), encoding)
