"""Conversion rules (CC blocks) from raw to physical values, for whole columns."""

from __future__ import annotations

import numpy as np

from parsers.can.labels import is_invalid
from parsers.channels import FloatArray
from parsers.mf4.algebra import FormulaError, evaluate
from parsers.mf4.model import Conversion

IDENTITY, LINEAR, RATIONAL, ALGEBRAIC, INTERPOLATED, TABLE, RANGES, TEXTS, RANGE_TEXTS = range(9)
_NEEDS = {LINEAR: 2, RATIONAL: 6, INTERPOLATED: 2, TABLE: 2, RANGES: 4}


def _default(rule: Conversion) -> str | Conversion | None:
    """What a text table gives for values that it does not list."""
    listed = rule.values.size if rule.kind == TEXTS else rule.values.size // 2
    return rule.refs[listed] if len(rule.refs) > listed else None


def names_values(rule: Conversion | None) -> bool:
    """Whether a rule is a table of texts."""
    return rule is not None and rule.kind in (TEXTS, RANGE_TEXTS)


def only_names(rule: Conversion | None) -> bool:
    """Whether a rule is a table of texts that converts nothing: the numbers beside it are the raw ones."""
    if rule is None or not names_values(rule):
        return False
    return not any(isinstance(ref, Conversion) for ref in rule.refs)


def gives_text(rule: Conversion | None) -> bool:
    """Whether a rule makes texts of most values: such a channel is no number.

    A table that names a few values and hands on the others (or says nothing of them) leaves numbers.
    """
    if rule is None or rule.kind <= RANGES:
        return False
    if not names_values(rule):
        return True
    other = _default(rule)
    return isinstance(other, str) or (isinstance(other, Conversion) and gives_text(other))


def fault(rule: Conversion | None) -> str | None:
    """Why a rule cannot be used, or None."""
    if rule is None:
        return None
    if rule.values.size < _NEEDS.get(rule.kind, 0):
        return f"conversion {rule.kind} with {rule.values.size} values"
    if rule.kind == ALGEBRAIC:
        try:
            evaluate(rule.formula, np.ones(1))
        except FormulaError as error:
            return f"formula {rule.formula!r}: {error}"
    return None


def _table(rule: Conversion, raw: FloatArray) -> FloatArray:
    """Pairs of key and value: straight lines between them, or the nearest key's value (the lower one at a tie)."""
    keys, values = rule.values[0::2], rule.values[1::2]
    keys = keys[: values.size]
    order = np.argsort(keys, kind="stable")
    keys, values = keys[order], values[order]
    if rule.kind == INTERPOLATED:
        return np.asarray(np.interp(raw, keys, values), np.float64)
    right = np.clip(np.searchsorted(keys, raw), 0, keys.size - 1)
    left = np.maximum(right - 1, 0)
    nearer = np.where(raw - keys[left] <= keys[right] - raw, left, right)
    return np.asarray(np.where(np.isnan(raw), np.nan, values[nearer]), np.float64)


def _ranges(rule: Conversion, raw: FloatArray, whole_numbers: bool) -> FloatArray:
    """Triplets of low, high, value, then the value for everything else; the first range that fits counts."""
    count = (rule.values.size - 1) // 3
    triplets = rule.values[: 3 * count].reshape(count, 3)
    out = np.full(raw.shape, rule.values[3 * count])
    for low, high, value in triplets[::-1]:
        inside = (raw >= low) & ((raw <= high) if whole_numbers else (raw < high))
        out[inside] = value
    return out


def _texts(rule: Conversion, raw: FloatArray, whole_numbers: bool) -> FloatArray:
    """A table that names some values: the others are numbers, converted by the default rule or as they are without one.

    A value with a name is NaN, as is only one whose name says that there is none where the table converts nothing: codes of an
    enumeration stay.
    """
    other = _default(rule)
    out = convert(other, raw, whole_numbers=whole_numbers) if isinstance(other, Conversion) else raw.copy()
    codes = only_names(rule)
    step = 1 if rule.kind == TEXTS else 2
    keys = rule.values[: rule.values.size // step * step].reshape(-1, step)
    free = np.ones(raw.shape, np.bool_)
    for index in range(min(keys.shape[0], len(rule.refs))):
        low, high = keys[index, 0], keys[index, -1]
        inside = (raw >= low) & ((raw <= high) if whole_numbers or step == 1 else (raw < high)) & free
        free &= ~inside
        target = rule.refs[index]
        if isinstance(target, Conversion):
            out[inside] = convert(target, raw[inside], whole_numbers=whole_numbers)
        elif isinstance(target, str) and (not codes or is_invalid(target)):
            out[inside] = np.nan
    return out


def convert(rule: Conversion | None, raw: FloatArray, *, whole_numbers: bool = False) -> FloatArray:
    """Physical values, shape as raw, of a rule without `fault`. whole_numbers: the raw values are integers."""
    if rule is None or rule.kind == IDENTITY or rule.kind > RANGE_TEXTS:
        return raw
    # raw values may be any bytes: NaN, infinite, beyond reach
    with np.errstate(all="ignore"):
        return _converted(rule, raw, whole_numbers)


def _converted(rule: Conversion, raw: FloatArray, whole_numbers: bool) -> FloatArray:
    if rule.kind == LINEAR:
        return np.asarray(raw * rule.values[1] + rule.values[0], np.float64)
    if rule.kind == RATIONAL:
        a, b, c, d, e, f = rule.values[:6]
        return np.asarray(((a * raw + b) * raw + c) / ((d * raw + e) * raw + f), np.float64)
    if rule.kind == ALGEBRAIC:
        return evaluate(rule.formula, raw)
    if rule.kind in (INTERPOLATED, TABLE):
        return _table(rule, raw)
    if rule.kind == RANGES:
        return _ranges(rule, raw, whole_numbers)
    return _texts(rule, raw, whole_numbers)
