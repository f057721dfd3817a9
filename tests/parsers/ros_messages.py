"""ROS payloads for the tests, decoded from one buffer."""

from __future__ import annotations

import numpy as np

from parsers.ros.contract import Decoded, MessageDecoder


def run(decoder: MessageDecoder, payloads: list[bytes], wanted: list[str]) -> Decoded:
    """Decode payloads that lie in one buffer with odd gaps between them."""
    parts, offset, at = [], [], 0
    for i, payload in enumerate(payloads):
        gap = b"\xff" * (i % 3)
        parts += [gap, payload]
        offset.append(at + len(gap))
        at += len(gap) + len(payload)
    data = np.frombuffer(b"".join(parts), dtype=np.uint8)
    return decoder.decode(
        data, np.array(offset, dtype=np.int64), np.array([len(p) for p in payloads]), wanted
    )
