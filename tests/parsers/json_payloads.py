"""Payloads of JSON for the tests of the decoder."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parsers.json_decode import JsonDecoded, JsonDecoder


def decode(
    decoder: JsonDecoder, payloads: Sequence[bytes], wanted: Sequence[str] | None = None
) -> JsonDecoded:
    if wanted is None:
        wanted = [info.path for info in decoder.fields if info.kind == "number"]
    length = np.array([len(p) for p in payloads], dtype=np.int64)
    offset = np.cumsum(length) - length
    return decoder.decode(np.frombuffer(b"".join(payloads), dtype=np.uint8), offset, length, wanted)
