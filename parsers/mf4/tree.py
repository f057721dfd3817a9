"""Read the tree of an MF4 file's descriptions. Damaged branches are left out and said; loops in the lists end."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.mf4.blocks import ID_SIZE, Block, BlockFile
from parsers.mf4.model import CG_REMOTE_MASTER, Channel, Conversion, DataGroup, Group, Measurement

_HD = struct.Struct("<QhhBBB")
_CG = struct.Struct("<QQHHIII")
_CN = struct.Struct("<BBBBIIII")
_CC = struct.Struct("<BBHHHdd")
MAX_DEPTH = 8
"""Levels of structures in structures, and of conversions in conversions."""
MAX_RECORD = 16 << 20


@dataclass
class TreeReader:
    """Reads descriptions once; texts and conversions that many channels share are kept by their place."""

    file: BlockFile
    log: ImportLog
    visited: set[int] = field(default_factory=set)
    texts: dict[int, str] = field(default_factory=dict)
    conversions: dict[int, Conversion | None] = field(default_factory=dict)
    groups: int = 0

    def damaged(self, what: str, error: LogError) -> None:
        """Say that a branch of the tree was left out."""
        at = int((error.place or "byte 0").split()[-1])
        if at >= self.file.size or "the file ends at" in error.problem:
            self.log.worsen(
                "truncated",
                f"the file breaks off at byte {self.file.size}, before the end of {what} at byte {at}",
            )
            return
        self.log.worsen("malformed", f"{what} is damaged and was left out ({error.place}: {error.problem})")

    def chain(self, at: int, kind: str, what: str) -> Iterator[Block]:
        """A linked list of blocks; ends at damage or at a block met before."""
        while at:
            if at in self.visited:
                self.log.worsen(
                    "malformed", f"a list of {what}s runs in a circle at byte {at} and was cut there"
                )
                return
            self.visited.add(at)
            try:
                block = self.file.block(at, kind)
            except LogError as error:
                self.damaged(f"a {what}", error)
                return
            yield block
            at = block.link(0)

    def text(self, at: int) -> str:
        """A text by its place."""
        if at not in self.texts:
            self.texts[at] = self.file.text(at)
        return self.texts[at]

    def conversion(self, at: int, depth: int = 0) -> Conversion | None:
        """A conversion by its place, None for none. Raises LogError where it is damaged."""
        if not at:
            return None
        if at in self.conversions:
            return self.conversions[at]
        block = self.file.block(at, "CC")
        if len(block.data) < _CC.size:
            raise self.file.fail("a conversion is too short", at)
        kind, _, _, refs, values, _, _ = _CC.unpack_from(block.data)
        if len(block.data) < _CC.size + 8 * values or len(block.links) < 4 + refs:
            raise self.file.fail(
                f"a conversion with {values} values and {refs} references does not fit its block", at
            )
        numbers = np.frombuffer(block.data, "<f8", values, _CC.size).astype(np.float64)
        targets = tuple(self._reference(link, depth) for link in block.links[4 : 4 + refs])
        formula = targets[0] if kind == 3 and targets and isinstance(targets[0], str) else ""
        made = Conversion(kind, numbers, targets, self.text(block.link(1)), formula)
        self.conversions[at] = made
        return made

    def _reference(self, at: int, depth: int) -> str | Conversion | None:
        if not at:
            return None
        if self.file.head(at).kind != "CC":
            return self.text(at)
        if depth >= MAX_DEPTH:
            raise self.file.fail("conversions refer to conversions without end", at)
        return self.conversion(at, depth + 1)

    def channels(self, at: int, parent: str = "", depth: int = 0) -> Iterator[Channel]:
        """The channels of a list, parts of structures behind their structure as "structure.part"."""
        for block in self.chain(at, "CN", "channel"):
            name = self.text(block.link(2))
            full = name if not parent or name.startswith(f"{parent}.") else f"{parent}.{name}"
            try:
                channel = self._channel(block, full)
                inner = self.file.head(block.link(1)).kind if block.link(1) else ""
            except LogError as error:
                self.damaged(f"channel {full!r}", error)
                continue
            yield replace(channel, whole=not inner)
            if inner == "CN" and depth < MAX_DEPTH:
                yield from self.channels(block.link(1), full, depth + 1)

    def _channel(self, block: Block, name: str) -> Channel:
        if len(block.data) < _CN.size:
            raise self.file.fail("a channel is too short", block.at)
        kind, sync, data_type, bit, byte, bits, flags, invalid = _CN.unpack_from(block.data)
        conversion = self.conversion(block.link(4))
        unit = self.text(block.link(6)) or (conversion.unit if conversion else "")
        comment = self.text(block.link(7))
        return Channel(
            name,
            kind,
            sync,
            data_type,
            bit,
            byte,
            bits,
            flags,
            invalid,
            block.link(5),
            unit,
            comment,
            conversion,
        )

    def group(self, block: Block) -> Group:
        """A channel group with its channels. Raises LogError where its numbers cannot be."""
        self.groups += 1
        if len(block.data) < _CG.size:
            raise self.file.fail("a channel group is too short", block.at)
        record_id, cycles, flags, _, _, size, invalid = _CG.unpack_from(block.data)
        if flags & 1:
            size = invalid = 0
        if size + invalid > MAX_RECORD:
            raise self.file.fail(f"records of {size + invalid} bytes", block.at)
        channels = tuple(self.channels(block.link(1)))
        remote = block.link(6) if flags & CG_REMOTE_MASTER else 0
        name = self.text(block.link(2))
        # sources cost a few reads each: only where frames do not name their bus
        frames = any("CAN_DataFrame" in channel.name for channel in channels)
        silent = frames and not any("BusChannel" in channel.name for channel in channels)
        source = self.source(block.link(3)) if silent else ("", "")
        return Group(
            self.groups,
            block.at,
            record_id,
            cycles,
            flags,
            size + invalid,
            size,
            name,
            channels,
            remote,
            source,
        )

    def source(self, at: int) -> tuple[str, str]:
        """Name and path of a source (SI block); empty where there is none or it is damaged."""
        if not at:
            return "", ""
        try:
            block = self.file.block(at, "SI")
        except LogError:
            return "", ""
        return self.text(block.link(0)), self.text(block.link(1))

    def data_groups(self, at: int) -> Iterator[DataGroup]:
        """All data groups."""
        for block in self.chain(at, "DG", "data group"):
            groups = []
            for inner in self.chain(block.link(1), "CG", "channel group"):
                try:
                    groups.append(self.group(inner))
                except LogError as error:
                    self.damaged("a channel group", error)
            id_size = block.data[0] if block.data else 0
            if id_size not in (0, 1, 2, 4, 8):
                self.damaged("a data group", self.file.fail(f"record ids of {id_size} bytes", block.at))
                continue
            yield DataGroup(block.link(2), id_size, tuple(groups))


def _identification(file: BlockFile) -> tuple[int, int]:
    """Version and unfinished flags. Raises LogError where the file is no MDF 4."""
    if file.size < ID_SIZE:
        raise file.fail(f"an MF4 file begins with {ID_SIZE} bytes of identification, found {file.size}", 0)
    head = file.read(0, ID_SIZE)
    version = int.from_bytes(head[28:30], "little")
    if not 400 <= version < 500:
        found = head[8:16].split(b"\0")[0].decode("latin-1").strip()
        if found.startswith("4") and 200 <= version < 400:
            found = f"{version / 100:.2f}"
        elif found.startswith("4"):
            raise LogError(
                f"the file says that it is of MDF version {found}, and its version number is {version}: its beginning is damaged",
                path=file.path,
                place="byte 28",
                hint="copy the file again",
            )
        raise LogError(
            f"MDF version {found or version} found, version 4 expected",
            path=file.path,
            place="byte 8",
            hint="convert the file to MDF 4 (MF4) with your recorder's software",
        )
    return version, int.from_bytes(head[60:62], "little") if head[:8] == b"UnFinMF " else 0


def read_measurement(file: BlockFile, log: ImportLog) -> Measurement:
    """Read all descriptions. Raises LogError where the file's first blocks cannot be read."""
    version, unfinished = _identification(file)
    header = file.block(ID_SIZE, "HD")
    if len(header.data) < _HD.size:
        raise file.fail("the header is too short", ID_SIZE)
    start, _, _, flags, _, _ = _HD.unpack_from(header.data)
    if start >= 1 << 62:
        log.note(f"the file's start time ({start} ns) is impossible and was left out")
        start = 0
    reader = TreeReader(file, log)
    attachments = []
    for block in reader.chain(header.link(3), "AT", "attachment"):
        attachments.append(reader.text(block.link(1)))
    groups = tuple(reader.data_groups(header.link(0)))
    links = {group.data_link for group in groups}
    links |= {c.data_link for group in groups for inner in group.groups for c in inner.channels}
    places = tuple(sorted({place for place in links if 0 < place < file.size} | set(file.seen)))
    return Measurement(version, start, bool(flags & 1), unfinished, groups, tuple(attachments), places)
