"""The helper modules beside the tests: their asserts say what they compared, as those of the tests do."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.register_assert_rewrite(
    *(
        path.stem
        for path in Path(__file__).parent.glob("*.py")
        if not path.stem.startswith(("test_", "conftest"))
    )
)
