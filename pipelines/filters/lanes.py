"""Elementary functions, random numbers and bits for kernels whose loops are to become vector instructions.

A compiler puts a loop over particles into vectors only if nothing in it is a call, a jump or a table: the functions here are
sums and products alone. A loop runs over LANES neighbours, whose numbers of one kind stand side by side.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from parsers.jit import Primitive, vector_kernel

LANES = 64
"""Particles side by side: eight vectors or more, and a tile of them with all its columns stays in the nearest cache."""

MAGIC = 6755399441055744.0
"""1.5 x 2^52: a double that it is added to keeps its nearest whole number in its last bits."""

MAGIC_BITS = int(np.float64(MAGIC).view(np.int64))
ROOT_HALF_BITS = int(np.float64(np.sqrt(0.5)).view(np.int64))
BIAS, MANTISSA = 1023, 52

HIGH_HALF = np.uint64(0xFFFFFFFF00000000)

PER_LN2 = 1.4426950408889634
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""ln 2 in two parts: a whole number times the first is exact."""

LOWEST = -708.0
"""exp of less is below the normal numbers."""

EXP = tuple(1.0 / factor for factor in np.cumprod(np.arange(1.0, 13.0))[::-1])
LOG = tuple(1.0 / odd for odd in range(21, 2, -2))
SIN = tuple(float(sign / factor) for sign, factor in ((1, 6227020800), (-1, 39916800), (1, 362880), (-1, 5040), (1, 120), (-1, 6)))  # fmt: skip
COS = tuple(float(sign / factor) for sign, factor in ((-1, 87178291200), (1, 479001600), (-1, 3628800), (1, 40320), (-1, 720), (1, 24), (-1, 2)))  # fmt: skip
"""The series' coefficients, last first."""

RandomState = NDArray[np.uint64]
"""(4 x LANES,) of one generator a lane (Blackman and Vigna, xoshiro256+, 2018)."""


def _same_bits(name: str, to: str) -> Any:
    """An instruction that reads a double's 64 bits as a whole number (to: int64 or uint64), or a whole number's as a double."""

    def make() -> Any:
        from llvmlite import ir
        from numba.core import types
        from numba.extending import intrinsic

        whole = types.uint64 if to == "uint64" else types.int64
        source, target = (whole, types.float64) if to == "float64" else (types.float64, whole)

        def same(_typing: Any, value: Any) -> Any:
            taken = value if to == "float64" and isinstance(value, types.Integer) else source
            kind = ir.DoubleType() if to == "float64" else ir.IntType(64)

            def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
                return builder.bitcast(arguments[0], kind)

            return target(taken), generate

        return intrinsic(same)

    return Primitive(name, make)


_BITS = cast("Callable[[float], int]", _same_bits("bits of a double", "int64"))
_DOUBLE = cast("Callable[[int | np.uint64], float]", _same_bits("double of bits", "float64"))


@vector_kernel
def exp(x: float) -> float:
    """e^x to a unit in the last place, for x up to 709; below LOWEST that of LOWEST (3e-308)."""
    x = max(x, LOWEST)
    shifted = x * PER_LN2 + MAGIC
    whole = shifted - MAGIC
    left = x - whole * LN2_HIGH
    left -= whole * LN2_LOW
    total = EXP[0]
    total = total * left + EXP[1]
    total = total * left + EXP[2]
    total = total * left + EXP[3]
    total = total * left + EXP[4]
    total = total * left + EXP[5]
    total = total * left + EXP[6]
    total = total * left + EXP[7]
    total = total * left + EXP[8]
    total = total * left + EXP[9]
    total = total * left + EXP[10]
    total = total * left + EXP[11]
    total = total * left + 1.0
    return float(total * _DOUBLE((_BITS(shifted) + BIAS) << MANTISSA))


@vector_kernel
def log(x: float) -> float:
    """ln x to a unit in the last place, for positive normal numbers; of others any number."""
    bits = _BITS(x)
    power = (bits - ROOT_HALF_BITS) >> MANTISSA
    rest = _DOUBLE(bits - (power << MANTISSA))
    whole = _DOUBLE(power + MAGIC_BITS) - MAGIC
    s = (rest - 1.0) / (rest + 1.0)
    z = s * s
    total = LOG[0]
    total = total * z + LOG[1]
    total = total * z + LOG[2]
    total = total * z + LOG[3]
    total = total * z + LOG[4]
    total = total * z + LOG[5]
    total = total * z + LOG[6]
    total = total * z + LOG[7]
    total = total * z + LOG[8]
    total = total * z + LOG[9]
    return whole * LN2_HIGH + (whole * LN2_LOW + 2.0 * s * (1.0 + z * total))


@vector_kernel
def floor(x: float) -> int:
    """The whole number below x, for 0 to 2^31; of a whole number itself or the one before it."""
    return _BITS(x - 0.5 + MAGIC) - MAGIC_BITS


@vector_kernel
def random_bits(state: RandomState, lane: int) -> np.uint64:
    """The lane's next 64 bits; the first are the best."""
    one, two = state[LANES + lane], state[2 * LANES + lane]
    zero, three = state[lane], state[3 * LANES + lane]
    found: np.uint64 = zero + three
    two ^= zero
    three ^= one
    state[LANES + lane] = one ^ two
    state[lane] = zero ^ three
    state[2 * LANES + lane] = two ^ (one << np.uint64(17))
    state[3 * LANES + lane] = (three << np.uint64(45)) | (three >> np.uint64(19))
    return found


@vector_kernel
def above_one(bits: np.uint64) -> float:
    """A double in [1, 2) of random bits."""
    return _DOUBLE((bits >> np.uint64(12)) | np.uint64(0x3FF0000000000000))


@vector_kernel
def two_normals(state: RandomState, lane: int) -> tuple[float, float]:
    """Two independent standard normal draws of the lane (Box and Muller, 1958), up to 6.6: of 32 random bits each."""
    bits = random_bits(state, lane)
    radius = np.sqrt(-2.0 * log(2.0 - above_one(bits & HIGH_HALF)))
    quarters = 4.0 * above_one(bits << np.uint64(32)) - 6.0
    shifted = quarters + MAGIC
    angle = (quarters - (shifted - MAGIC)) * (0.5 * np.pi)
    z = angle * angle
    sine = SIN[0]
    sine = sine * z + SIN[1]
    sine = sine * z + SIN[2]
    sine = sine * z + SIN[3]
    sine = sine * z + SIN[4]
    sine = sine * z + SIN[5]
    sine = angle + angle * z * sine
    cosine = COS[0]
    cosine = cosine * z + COS[1]
    cosine = cosine * z + COS[2]
    cosine = cosine * z + COS[3]
    cosine = cosine * z + COS[4]
    cosine = cosine * z + COS[5]
    cosine = cosine * z + COS[6]
    cosine = 1.0 + z * cosine
    turn = _BITS(shifted)
    odd = (turn & 1) == 1
    first, second = (cosine if odd else sine), (sine if odd else cosine)
    first = -first if (turn & 2) == 2 else first
    second = -second if ((turn + 1) & 2) == 2 else second
    return radius * first, radius * second


def random_state(rng: np.random.Generator) -> RandomState:
    """(4 x LANES,) drawn from rng."""
    return rng.integers(0, 2**64, 4 * LANES, dtype=np.uint64)
