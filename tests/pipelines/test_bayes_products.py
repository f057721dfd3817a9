"""Products in pieces equal products."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.bayes.products import gram, product


@pytest.mark.parametrize(("n", "k", "m"), [(1, 1, 1), (37, 5, 3), (4000, 30, 40), (3, 700, 800), (0, 4, 4)])
def test_pieces_make_the_whole(n: int, k: int, m: int) -> None:
    rng = np.random.default_rng(0)
    rows, matrix = rng.standard_normal((n, k)), rng.standard_normal((k, m))
    np.testing.assert_allclose(product(rows, matrix), rows @ matrix, atol=1e-10)
    np.testing.assert_allclose(product(np.asfortranarray(rows), matrix), rows @ matrix, atol=1e-10)
    np.testing.assert_allclose(gram(rows), rows.T @ rows, atol=1e-9)
