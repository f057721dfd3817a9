"""Text files as bytes: which encoding, and blocks of whole lines whose memory is bounded by the block."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from parsers.code_pages import NATIONAL, code_page
from parsers.errors import LogError

SAMPLE_BYTES = 256 * 1024
"""How much of a text log is looked at to find out how it is written."""

BLOCK_BYTES = 8 * 1024 * 1024
MOST_LINE_BYTES = 4 * 1024 * 1024
"""A line without an end within this is no text."""
_CONTROL = re.compile(rb"[\x00-\x08\x0b\x0e-\x19\x1c-\x1f]")
_LINES_BEFORE_DAMAGE = 3
"""So many lines of text must stand before other bytes for these to be damage, and the file a text all the same."""


@dataclass(frozen=True)
class Encoding:
    """How a file's bytes become text. codec: Python's name. mark: bytes of the byte order mark. old_lines: CR only.
    damaged: bytes that are no text follow after some lines of text."""

    codec: str
    mark: int = 0
    old_lines: bool = False
    damaged: bool = False

    @property
    def wide(self) -> bool:
        """Whether the bytes must be transcoded before lines can be found."""
        return self.codec.startswith("utf-16")


@dataclass(frozen=True)
class TextBlock:
    """Whole lines as UTF-8 or a one-byte encoding. done: bytes of the file read so far. lost_lines: lines left out
    because they have no end within 4 MiB. ends_open: the last line of the file has no newline."""

    data: bytes
    done: int
    lost_lines: int = 0
    ends_open: bool = False


def find_encoding(head: bytes) -> Encoding | None:
    """The encoding of a text file by its first bytes; None where these are no text."""
    if head.startswith(codecs.BOM_UTF8):
        codec, mark = "utf-8", 3
    elif head.startswith(codecs.BOM_UTF16_LE):
        codec, mark = "utf-16-le", 2
    elif head.startswith(codecs.BOM_UTF16_BE):
        codec, mark = "utf-16-be", 2
    elif len(head) >= 8 and not any(head[1:200:2]) and head[:200:2].count(0) == 0:
        codec, mark = "utf-16-le", 0
    elif len(head) >= 8 and not any(head[:200:2]) and head[1:200:2].count(0) == 0:
        codec, mark = "utf-16-be", 0
    else:
        codec, mark = ("utf-8" if _is_utf8(head) else code_page(head)), 0
    body = head[mark:]
    if codec.startswith("utf-16"):
        body = body[: len(body) // 2 * 2].decode(codec, "replace").encode("utf-8", "replace")
    odd = _CONTROL.search(body)
    if odd is not None:
        body = body[: odd.start()]
        if body.count(b"\n") < _LINES_BEFORE_DAMAGE:
            return None
    if not body.strip():
        return None
    return Encoding(codec, mark, old_lines=b"\r" in body and b"\n" not in body, damaged=odd is not None)


def _is_utf8(head: bytes) -> bool:
    """Whether bytes are UTF-8, but for a character that the end cuts through."""
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return False
    return True


def decode(data: bytes, encoding: Encoding) -> str:
    """The text of a line or block as `text_blocks` yields it."""
    if encoding.codec in NATIONAL:
        return data.decode(encoding.codec, "replace")
    if encoding.codec == "cp1252":
        try:
            return data.decode("cp1252")
        except UnicodeDecodeError:
            return data.decode("latin-1")
    return data.decode("utf-8", "replace")


def read_sample(path: Path, encoding: Encoding) -> bytes:
    """The first lines of a file, as `text_blocks` yields them; the last line may be cut. Raises LogError."""
    try:
        with path.open("rb") as file:
            raw = file.read(SAMPLE_BYTES)
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
    return _plain(raw[encoding.mark :], encoding, None)


def _plain(
    raw: bytes, encoding: Encoding, decoder: codecs.IncrementalDecoder | None, final: bool = False
) -> bytes:
    if encoding.wide:
        decoder = decoder or codecs.getincrementaldecoder(encoding.codec)("replace")
        raw = decoder.decode(raw, final).encode("utf-8", "replace")
    return raw.replace(b"\r", b"\n") if encoding.old_lines else raw


def text_blocks(
    path: Path, encoding: Encoding, skip: int, block_bytes: int = BLOCK_BYTES
) -> Iterator[TextBlock]:
    """The file from byte `skip` of its plain text (after the byte order mark) on, in blocks of whole lines.

    Raises LogError where the file cannot be read.
    """
    decoder = codecs.getincrementaldecoder(encoding.codec)("replace") if encoding.wide else None
    rest = b""
    lost = 0
    dropping = False
    try:
        with path.open("rb") as file:
            file.seek(encoding.mark if encoding.wide else encoding.mark + skip)
            to_skip = skip if encoding.wide else 0
            while True:
                raw = file.read(block_bytes)
                data = _plain(raw, encoding, decoder, final=not raw)
                if to_skip:
                    to_skip, data = max(0, to_skip - len(data)), data[to_skip:]
                if dropping:
                    at = data.find(b"\n")
                    dropping, data = at < 0, data[at + 1 :] if at >= 0 else b""
                data = rest + data
                if not raw:
                    if data or lost:
                        yield TextBlock(data, file.tell(), lost, ends_open=bool(data) and data[-1] != 10)
                    return
                cut = data.rfind(b"\n") + 1
                rest = data[cut:]
                if len(rest) > MOST_LINE_BYTES:
                    rest, lost, dropping = b"", lost + 1, True
                if cut:
                    yield TextBlock(data[:cut], file.tell(), lost)
                    lost = 0
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
