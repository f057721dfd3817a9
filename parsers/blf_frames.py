"""The frames of a Vector BLF file, container by container, and what the log book says about them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from parsers import blf_objects as places
from parsers.blf_containers import BlfHeader
from parsers.blf_groups import blocks
from parsers.blf_objects import NO_TIME
from parsers.blf_walk import Block, block_of
from parsers.blf_walker import ObjectWalker
from parsers.can.frames import CanFrames
from parsers.importer import ImportLog


@dataclass(frozen=True)
class BlfFrames:
    """A BLF file as a source of frames. See `parsers.can.frames.FrameSource`."""

    path: Path
    header: BlfHeader
    log: ImportLog
    progress: Callable[[int, int], None]

    @property
    def clock(self) -> str:
        """The recorder's own."""
        return "object time stamps of the BLF file"

    @property
    def absolute(self) -> bool:
        """Whether the file says when it began."""
        return self.header.start_ns is not None

    @property
    def start_utc_ns(self) -> int | None:
        """None: absolute stamps say it themselves, and of others the file does not know it."""
        return None

    def frames(self, *, counting: bool) -> Iterator[CanFrames]:
        """All data frames in the file's order, in batches of about half a MiB of inflated objects."""
        walker = ObjectWalker(self.header.start_ns or 0)
        total = self.path.stat().st_size
        trouble: list[Block] = []
        messages = 0
        for block, ahead in blocks(self.path, self.header):
            for batch in walker.walk(block, ahead):
                messages += batch.time_ns.size
                yield batch
            if block.kind == "damaged":
                walker.lose(block.size)
            if block.kind in ("damaged", "cut"):
                # without its content
                trouble.append(block_of(block.kind, block.position, block.size))
            if counting:
                self.progress(min(block.position + block.size, total), total)
        if counting:
            self.progress(total, total)
            self._write_down(walker, trouble, messages, total)

    def _write_down(self, walker: ObjectWalker, trouble: list[Block], messages: int, total: int) -> None:
        """Count into the log book what was read and what was lost."""
        log, state = self.log, walker.state
        log.messages += messages
        log.reject("CAN remote frame", int(state[places.REMOTE]))
        log.reject("CAN error frame", int(state[places.ERRORS]))
        log.reject("frame with an impossible time stamp", int(state[places.BAD_TIME]))
        log.reject("damaged object in the BLF file", int(state[places.BAD]))
        if others := int(state[places.OTHERS]):
            log.note(f"{others} objects of the BLF file are no CAN frames and were passed over")
        damaged = [block for block in trouble if block.kind == "damaged"]
        if damaged or state[places.BAD]:
            log.reject("damaged container in the BLF file", len(damaged))
            first = f", first at byte {damaged[0].position}" if damaged else ""
            log.worsen(
                "malformed",
                f"the BLF file is damaged: {len(damaged)} containers{first}, {int(state[places.BAD])} objects and "
                f"{int(state[places.LOST])} bytes could not be read; {messages} frames are whole",
            )
        for before, after in walker.gaps[: int(state[places.GAPS])].tolist():
            if before != NO_TIME and after > before:
                log.lost_spans_ns.append((before, after))
        cut = [block for block in trouble if block.kind == "cut"]
        missing = max(0, self.header.file_size - total)
        if cut or missing or (walker.tail.strip(b"\0") and not state[places.SEARCHING]):
            what = (
                f"the header says {self.header.file_size} bytes, found {total}"
                if missing
                else f"it ends at byte {total}"
            )
            log.worsen("truncated", f"the BLF file breaks off ({what}); {messages} frames are whole")
        elif self.header.objects == 0 and messages:
            log.note(
                "the BLF file was never finalised by its recorder (no object count); all its containers were read"
            )
