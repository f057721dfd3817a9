"""What an MF4 file says about itself: data groups, channel groups, channels and conversions."""

from __future__ import annotations

from dataclasses import dataclass, field

from parsers.channels import FloatArray

# channel types (cn_type)
FIXED, VLSD, MASTER, VIRTUAL_MASTER, SYNC, MLSD, VIRTUAL, VLSC = range(8)
# channel group flags (cg_flags)
CG_VLSD, CG_BUS, CG_PLAIN_BUS, CG_REMOTE_MASTER = 1, 2, 4, 8
CN_BUS = 0x400
"""Flag of a channel (cn_flags): a piece of a bus event."""
# flags of an unfinished file (id_unfin_flags)
UNFINISHED_CYCLES, UNFINISHED_LENGTH, UNFINISHED_LIST, UNFINISHED_OFFSETS = 0x01, 0x04, 0x10, 0x40


@dataclass(frozen=True)
class Conversion:
    """A conversion rule (CC block).

    kind: cc_type. values: its numbers. refs: a text, another conversion, or None, as referred to. formula: of kind 3.
    """

    kind: int
    values: FloatArray
    refs: tuple[str | Conversion | None, ...] = ()
    unit: str = ""
    formula: str = ""


@dataclass(frozen=True)
class Channel:
    """One channel (CN block); offsets are from the record's first byte behind the record id.

    kind: cn_type. sync: 1 time. data_type: cn_data_type. data_link: of a VLSD channel. whole: False for arrays and
    structures, whose parts (if any) are channels of their own.
    """

    name: str
    kind: int
    sync: int
    data_type: int
    bit_offset: int
    byte_offset: int
    bit_count: int
    flags: int
    invalid_bit: int
    data_link: int
    unit: str
    comment: str
    conversion: Conversion | None
    whole: bool = True

    @property
    def byte_count(self) -> int:
        """Bytes of the record that the channel's bits touch."""
        return (self.bit_offset + self.bit_count + 7) // 8


@dataclass(frozen=True)
class Group:
    """A channel group (CG block): records of one kind.

    number: 1 for the file's first. cycles: records, as the file says. size: bytes of a record without its id,
    invalidation bytes included; invalid_at: where those begin. master_link: of a remote master. source: name and path of the
    acquisition source, read only for frames that do not name their bus.
    """

    number: int
    at: int
    record_id: int
    cycles: int
    flags: int
    size: int
    invalid_at: int
    name: str
    channels: tuple[Channel, ...]
    master_link: int = 0
    source: tuple[str, str] = ("", "")


@dataclass(frozen=True)
class DataGroup:
    """A data group (DG block): groups whose records share one data stream. id_size: bytes of the record id."""

    data_link: int
    id_size: int
    groups: tuple[Group, ...]


@dataclass(frozen=True)
class Measurement:
    """A whole file. start_ns: since 1970 (0 unknown). local: the start is local time. unfinished: id_unfin_flags.

    places: where blocks begin, in order: a data block without a length ends before the next. dates: group -> whether its stamps are
    dates themselves, of the groups that were read; filled in by those who read.
    """

    version: int
    start_ns: int
    local: bool
    unfinished: int
    data_groups: tuple[DataGroup, ...]
    attachments: tuple[str, ...]
    places: tuple[int, ...] = ()
    dates: dict[int, bool] = field(default_factory=dict)
