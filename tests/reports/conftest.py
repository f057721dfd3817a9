"""Reports rendered once for all the tests of this folder."""

from __future__ import annotations

import pytest
from sample_results import bare, hostile, rich

from reports.blocks import Document
from reports.document import build_document
from reports.html import html_of


@pytest.fixture(scope="session")
def rich_document() -> Document:
    return build_document(rich())


@pytest.fixture(scope="session")
def bare_document() -> Document:
    return build_document(bare())


@pytest.fixture(scope="session")
def hostile_document() -> Document:
    return build_document(hostile())


@pytest.fixture(scope="session")
def rich_html(rich_document: Document) -> str:
    return html_of(rich_document)


@pytest.fixture(scope="session")
def hostile_html(hostile_document: Document) -> str:
    return html_of(hostile_document)
