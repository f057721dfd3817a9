"""What a text says that stands where a unit is expected: a unit, known or of what cogest has no use for, or nothing."""

from __future__ import annotations

import re

from parsers.units import quantities_of

# Units that no signal of cogest has; known here only so that they are seen as units and not as part of a name.
_OTHER_UNIT_WORDS = """
    °c degc celsius c k °f degf v mv volt volts a ma amp amps w kw hp ps hz khz % %rh pct percent db l l/h l/min gal/h ml km/l mpg
    dbm nm/s w/m2 wh kwh ah j kj n/m n/mm nm/rad ohm t tesla ut µt gauss mg/l g/s kg/h kg/s lambda afr bit bits count
    counts raw bool boolean on/off enum state hh:mm:ss hh:mm:ss.sss yyyy-mm-dd utc unix unixtime iso8601 m2 m3 1/m
    1/km rad/s2 rad/s^2 deg/s2 deg/s^2 °/s2 °/s^2 m/s3 m/s^3 norm normalized normalised lsb digit digits inc increments
    pulse pulses pulses/s tick ticks adc mv/v v/v a.u. ppm ‰ promille
"""
_OTHER_UNITS = frozenset(_OTHER_UNIT_WORDS.split())
_NOTHING_WORDS = """
    - -- – 1 # ? none null nil n/a na unit units unitless ratio dimensionless nounit unknown undefined raw
"""
_NOTHING = frozenset(["", "no unit", *_NOTHING_WORDS.split()])
_LETTERS = re.compile(r"[^\W\d_]+(?:[ _-]+[^\W\d_]+)*")


def plain_unit(text: str | None) -> str | None:
    """A unit without brackets and blanks; None where there is none."""
    plain = (text or "").strip().strip("[](){}<>").strip()
    if plain.count("(") > plain.count(")"):  # "bar(g)"
        plain += ")"
    return plain or None


def is_unit(text: str) -> bool:
    """Whether a text stands for a unit, known or of a quantity that cogest has no use for."""
    plain = plain_unit(text)
    return plain is not None and (bool(quantities_of(plain)) or plain.lower() in _OTHER_UNITS)


def says_unit(text: str | None) -> bool:
    """Whether a unit's text says anything ("-", "1" and "none" do not)."""
    return (plain_unit(text) or "").lower() not in _NOTHING


def is_remark(text: str) -> bool:
    """Whether a text that is no known unit can be a remark about a name, as "GPS" or "front left": words alone."""
    return not is_unit(text) and _LETTERS.fullmatch(text.strip()) is not None
