"""Payloads of JSON for the tests of the decoder."""

from __future__ import annotations

from collections.abc import Sequence

from parsers.json_decode import JsonDecoded, JsonDecoder
from tests.parsers.payload_bytes import laid_out


def decode(
    decoder: JsonDecoder, payloads: Sequence[bytes], wanted: Sequence[str] | None = None
) -> JsonDecoded:
    if wanted is None:
        wanted = [info.path for info in decoder.fields if info.kind == "number"]
    return decoder.decode(*laid_out(payloads), wanted)
