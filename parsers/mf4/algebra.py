"""Formulas of algebraic conversions ("2 * sin(X) + 1"): parsed by hand, never evaluated as code."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from parsers.channels import FloatArray

MAX_LENGTH = 2000
MAX_DEPTH = 50
_TOKEN = re.compile(
    r"\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*)|(\*\*|[-+*/^()]))"
)
_FUNCTIONS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "exp": np.exp,
    "log": np.log,
    "ln": np.log,
    "log10": np.log10,
    "sqrt": np.sqrt,
    "abs": np.abs,
}


class FormulaError(ValueError):
    """A formula that is not understood."""


def _tokens(text: str) -> list[str]:
    if len(text) > MAX_LENGTH:
        raise FormulaError(f"longer than {MAX_LENGTH} characters")
    found, at, text = [], 0, text.strip()
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise FormulaError(f"{text[at]!r} is not understood")
        found.append(match.group().strip())
        at = match.end()
    return found


class _Formula:
    """A recursive descent over the tokens; computes while it parses."""

    def __init__(self, tokens: list[str], x: FloatArray) -> None:
        self.tokens, self.x, self.at, self.depth = tokens, x, 0, 0

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self) -> str:
        token = self.peek()
        self.at += 1
        return token

    def sum(self) -> FloatArray:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise FormulaError("too many brackets")
        value = self.product()
        while self.peek() in ("+", "-"):
            sign = 1.0 if self.take() == "+" else -1.0
            value = value + sign * self.product()
        self.depth -= 1
        return value

    def product(self) -> FloatArray:
        value = self.signed()
        while self.peek() in ("*", "/"):
            value = value * self.signed() if self.take() == "*" else value / self.signed()
        return value

    def signed(self) -> FloatArray:
        sign = 1.0
        while self.peek() in ("+", "-"):
            sign *= 1.0 if self.take() == "+" else -1.0
        return sign * self.power()

    def power(self) -> FloatArray:
        bases = [self.atom()]
        while self.peek() in ("^", "**"):
            self.take()
            minus = self.peek() == "-"
            if minus:
                self.take()
            exponent = self.atom()
            bases.append(-exponent if minus else exponent)
        value = bases.pop()
        while bases:
            value = np.power(bases.pop(), value)
        return value

    def atom(self) -> FloatArray:
        token = self.take()
        if token == "(":
            value = self.sum()
            if self.take() != ")":
                raise FormulaError("a bracket is not closed")
            return value
        if token.lower() in _FUNCTIONS and self.peek() == "(":
            return _FUNCTIONS[token.lower()](self.atom())
        if token.upper() in ("X", "X1"):
            return self.x
        if token.lower() == "pi":
            return np.full(self.x.shape, np.pi)
        try:
            return np.full(self.x.shape, float(token))
        except ValueError:
            raise FormulaError(f"{token!r} is not understood") from None


def evaluate(text: str, x: FloatArray) -> FloatArray:
    """The formula's values for X = x. Raises FormulaError where it is not understood."""
    formula = _Formula(_tokens(text), x)
    with np.errstate(all="ignore"):
        value = formula.sum()
    if formula.peek():
        raise FormulaError(f"{formula.peek()!r} is not understood")
    return value
