"""Which channel becomes which canonical signal: user's mapping file, built-in profiles, column names."""

from parsers.mapping.bindings import Binding, bind, needed_channels
from parsers.mapping.map_file import MapEntry, MapFile, read_map
from parsers.mapping.propose import missing_channels, propose, propose_all, propose_and_say
from parsers.mapping.reasons import reasons_beside, unmapped_reason
from parsers.mapping.starter import starter_map
from parsers.mapping.wheel_radius import WheelRadius

__all__ = [
    "Binding",
    "MapEntry",
    "MapFile",
    "WheelRadius",
    "bind",
    "missing_channels",
    "needed_channels",
    "propose",
    "propose_all",
    "propose_and_say",
    "read_map",
    "reasons_beside",
    "starter_map",
    "unmapped_reason",
]
