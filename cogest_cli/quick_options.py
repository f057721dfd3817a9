"""Options whose values need no library to be understood.

typer (from the version on that brings pydantic) hands every value to pydantic, whose import takes a tenth of a short
command's time, though a text is a text already and a parser of our own makes a path. Here such values are taken as they
are, and only what is left goes to typer. Where typer is built differently nothing is changed.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from typer.core import TyperCommand, TyperGroup


class QuickCommand(TyperCommand):
    """A command that asks typer only for those values that are not plain."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Its parameters, --help among them."""
        return _quick(super().get_params(ctx))

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """The words that are left. Raises UsageError for an option given twice that takes one value: the first would be lost."""
        seen: set[str] = set()
        single = _single(self.get_params(ctx))
        for word in args:
            if word == "--":
                break
            name = word.partition("=")[0]
            option = single.get(name)
            if option in seen:
                ctx.fail(f"{name} was given twice: it takes one value")
            if option is not None:
                seen.add(option)
        return super().parse_args(ctx, args)


def _single(params: list[Any]) -> dict[str, str]:
    """The spellings of options that take one value -> the option's name."""
    found: dict[str, str] = {}
    for param in params:
        plain = not (getattr(param, "multiple", True) or getattr(param, "is_flag", False))
        if plain and param.param_type_name == "option":
            found |= dict.fromkeys(param.opts, str(param.name))
    return found


class QuickGroup(TyperGroup):
    """The program before its commands, with options of its own."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Its parameters, --help among them."""
        return _quick(super().get_params(ctx))


def _quick(params: list[Any]) -> list[Any]:
    for param in params:
        usual, told = getattr(param, "get_runtime_param", None), getattr(param, "type_descriptor", None)
        if callable(usual) and told is not None and "get_runtime_param" not in vars(param):
            quick = _Quick(usual, told)
            # an attribute of the object goes before the class's method
            param.get_runtime_param = lambda quick=quick: quick
    return params


_MORE = ("exists", "writable", "resolve_path", "path_type", "allow_dash")
"""What a path option may ask for beside being a path."""


class _Quick:
    """In the place of typer's runtime parameter, which `usual` gives. told: what typer knows of the parameter."""

    def __init__(self, usual: Callable[[], Any], told: Any) -> None:
        info = told.parameter_info
        self._usual, self._annotation = usual, told.annotation
        self._parser: Callable[[str], Any] | None = getattr(info, "parser", None)
        asked = any(getattr(info, name, None) for name in _MORE)
        limited = not all(getattr(info, name, True) for name in ("file_okay", "dir_okay"))
        self._plain_path = told.annotation is Path and not asked and not limited

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """The value as the command wants it. Raises typer's errors for what cannot be understood."""
        if value is None:
            return () if param.multiple or param.nargs == -1 else None
        if self._parser is None:
            if type(value) is self._annotation:
                return value
            if self._plain_path and _open_to_us(value):
                return Path(value)
        else:
            with contextlib.suppress(ValueError):
                if isinstance(value, str):
                    return self._parser(value)
                if isinstance(value, (list, tuple)) and all(isinstance(each, str) for each in value):
                    return [self._parser(each) for each in value]
        # typer understands more, or says what is wrong
        return self._usual().coerce(value, param=param, ctx=ctx)


def _open_to_us(place: Any) -> bool:
    """Whether nothing is there, or something that may be read, as typer asks of a path."""
    return isinstance(place, (str, Path)) and (not os.path.lexists(place) or os.access(place, os.R_OK))
