"""What J1939 itself calls a message and its signals, whatever a database calls them."""

from __future__ import annotations

from parsers.can.definitions import MessageDef, SignalDef


def standard_of(message: MessageDef, builtin: MessageDef | None) -> MessageDef | None:
    """The built-in definition of a message's parameter group, where the message is that group's; else None.

    builtin: what cogest knows under the message's number. It is the same group where the database says that it is of
    J1939, or where a signal of it is one of the group's: on a plain bus an identifier may have such a number by chance.
    """
    if builtin is None or message is builtin:
        return None
    same = message.j1939 or any(standard_signal(signal, builtin) for signal in message.signals)
    return builtin if same else None


def standard_signal(signal: SignalDef, group: MessageDef) -> SignalDef | None:
    """The group's signal that a database's signal is: that of its parameter number, else of its place and scale, else of
    its name; None where it is none of them."""
    tests = (_same_number, _same_place, _same_name)
    return next((each for test in tests for each in group.signals if test(signal, each)), None)


def _same_number(one: SignalDef, other: SignalDef) -> bool:
    return one.spn is not None and one.spn == other.spn


def _same_place(one: SignalDef, other: SignalDef) -> bool:
    # of parts of one and the same bits the other numbers speak: a scale may be rounded in a database
    near = abs(one.scale - other.scale) <= 1e-3 * abs(other.scale)
    level = abs(one.offset - other.offset) <= 1e-3 * max(abs(other.offset), abs(other.scale))
    plain = not (one.is_float or one.signed or one.gates)
    return plain and one.field == other.field and near and level


def _same_name(one: SignalDef, other: SignalDef) -> bool:
    return _letters(one.name) == _letters(other.name)


def _letters(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter.isalnum())
