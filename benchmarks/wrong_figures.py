"""Vehicle files in which one kind of figures is wrong, as often and by as much as the verdict's doubts hold for possible.

Calibration asks whether intervals hold as often as they say over what the verdict takes for possible. It takes it for possible
that a stated figure is off by five of its own spreads (`pipelines.joint.doubts`): so a study draws such files too.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pipelines.joint.doubts.stated_figures import OFTEN_WRONG
from pipelines.joint.doubts.weighed import WIDER, WRONG_FILE
from pipelines.joint.file_check import STATED
from pipelines.vehicles.vehicle import Vehicle


def drawn_wrong(seed: int) -> str:
    """The kind of figures that is wrong in the file of this seed, a key of `STATED`; nothing in most."""
    chances = {title: OFTEN_WRONG.get(title, WRONG_FILE) for title in STATED}
    titles = ["", *chances]
    share = [1 - sum(chances.values()), *chances.values()]
    return str(np.random.default_rng([seed, 24]).choice(titles, p=share))


def with_wrong(file: Vehicle, title: str, seed: int) -> Vehicle:
    """The file with these figures off by `WIDER` times their stated spreads, which stay as they are.

    A pair is off alike or each by itself, with the same chance. What the file does not state stays unstated.
    """
    rng = np.random.default_rng([seed, 25])
    keys = list(STATED[title]) if title else []
    alike = bool(rng.random() < 0.5)
    draws = np.full(len(keys), rng.standard_normal()) if alike else rng.standard_normal(len(keys))
    found = dict(file.quantities)
    more = math.sqrt(WIDER**2 - 1)
    for key, draw in zip(keys, draws.tolist(), strict=True):
        stated = found.get(key)
        if stated is not None:
            found[key] = replace(stated, value=stated.value + more * stated.std * draw)
    return replace(file, quantities=found)
