"""Raw streams over something that is no file of the system's: all but what is read at a place."""

from __future__ import annotations

import io
from abc import abstractmethod


class PlacedStream(io.RawIOBase):
    """A stream that can be read and knows its place, as `open(path, "rb", buffering=0)` gives, but for the file descriptor."""

    def __init__(self) -> None:
        super().__init__()
        self._at = 0

    @abstractmethod
    def length(self) -> int:
        """How many bytes there are. Raises OSError."""

    def readable(self) -> bool:
        """Yes."""
        return True

    def seekable(self) -> bool:
        """Yes."""
        return True

    def tell(self) -> int:
        """The place of the next byte."""
        return self._at

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Go to a place; nothing is read. Raises ValueError for one before the beginning."""
        base = {io.SEEK_SET: lambda: 0, io.SEEK_CUR: self.tell, io.SEEK_END: self.length}[whence]()
        if base + offset < 0:
            raise ValueError(f"negative seek position {base + offset}")
        self._at = base + offset
        return self._at
