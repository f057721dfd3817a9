"""What the readers of text ask of a path, for a file that is read otherwise than its bytes stand."""

from __future__ import annotations

import io
from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class TextPath:
    """A path whose file reads otherwise. All else is the path's own."""

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.path, name)

    @abstractmethod
    def raw(self) -> io.RawIOBase:
        """The file as it reads."""

    def open(self, mode: str = "rb", buffering: int = -1) -> io.RawIOBase | io.BufferedReader:
        """As `Path.open`, for reading alone."""
        raw = self.raw()
        return raw if buffering == 0 else io.BufferedReader(raw)
