"""Single precision, so that ideal flights are those of the training environment to the bit.

An operation on two float32 values carried out in double precision and then rounded
once gives what float32 hardware gives: 53 bits are enough for + - * / and the square
root of 24-bit numbers.
"""

import struct

_F32 = struct.Struct("<f")

TICKS_PER_U = 1024


def f32(value: float) -> float:
    """`value` rounded to the nearest float32."""
    return _F32.unpack(_F32.pack(value))[0]


def ticks(u: float) -> int:
    """Map units (or u/step) in ticks of 1/1024, halves away from zero; `u` is a float32.

    The half is added in float32 too, as the on-board code does.
    """
    scaled = u * TICKS_PER_U  # a power of two: exact
    return int(f32(scaled - 0.5 if scaled < 0.0 else scaled + 0.5))
