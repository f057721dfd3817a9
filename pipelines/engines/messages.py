"""Messages between a worker and its supervisor: a length of 8 bytes (big-endian), then so many bytes of ASCII JSON.

JSON with escapes carries any text whole, also file names that are not UTF-8 (as lone surrogates).
"""

from __future__ import annotations

import json
import struct
from typing import Any, BinaryIO

Message = dict[str, Any]

_LENGTH = struct.Struct(">Q")
_LONGEST = 1 << 32
"""Bytes. A longer one is no message: something else wrote into the pipe."""


def write_message(stream: BinaryIO, message: Message) -> None:
    """Write one whole message. Raises OSError where the other side is gone."""
    text = json.dumps(message).encode("ascii")
    stream.write(_LENGTH.pack(len(text)) + text)
    stream.flush()


def read_message(stream: BinaryIO) -> Message | None:
    """The next message; None where the stream ended, inside a message or not, or holds something else."""
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack(head)
    if length > _LONGEST:
        return None
    text = stream.read(length)
    if len(text) < length:
        return None
    message: Message = json.loads(text)
    return message
