"""What a reader over another reader's messages has of them as they are: the clock of their stamps."""

from __future__ import annotations

from dataclasses import dataclass

from parsers.importer import LogReader


@dataclass(frozen=True)
class OverMessages:
    """Stamps are those of the messages. inner: reads the messages."""

    inner: LogReader

    @property
    def clock(self) -> str:
        """The messages' clock."""
        return self.inner.clock

    @property
    def absolute(self) -> bool:
        """As the messages have it."""
        return self.inner.absolute

    @property
    def start_utc_ns(self) -> int | None:
        """As the messages have it."""
        return self.inner.start_utc_ns
