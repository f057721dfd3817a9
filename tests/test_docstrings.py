"""Every module, public class and public function of the product says what it is."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def silent(node: ast.Module | ast.ClassDef, before: str) -> Iterator[str]:
    """Dotted names of what has no docstring; what stands inside functions is nobody else's business."""
    for child in node.body:
        if isinstance(child, ast.FunctionDef | ast.ClassDef) and not child.name.startswith("_"):
            name = f"{before}.{child.name}"
            if not ast.get_docstring(child):
                yield name
            if isinstance(child, ast.ClassDef):
                yield from silent(child, name)


@pytest.mark.parametrize("layer", ["parsers", "pipelines", "reports", "cogest_cli"])
def test_everything_public_says_what_it_is(layer: str) -> None:
    found = []
    for path in sorted((ROOT / layer).rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        if tree.body and not ast.get_docstring(tree):
            found.append(name)
        found += silent(tree, name)
    assert not found


def test_what_has_no_docstring_is_found() -> None:
    source = "class A:\n    def b(self): ...\n    def _c(self): ...\ndef d():\n    'Does.'\n"
    assert list(silent(ast.parse(source), "m")) == ["m.A", "m.A.b"]
