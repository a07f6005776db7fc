"""Eight values that lie together in an array, computed at once.

The compiler joins the passes of a loop into vectors, but not statements that do the same with neighbours in memory.
Where a loop goes over points, and each of them takes a few neighbouring numbers from a table, a vector has to be asked
for. It has the bits of the single numbers.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["LANES", "mix_of_sixteen"]

LANES = 8
"""Values of a vector, in single precision."""


@intrinsic
def mix_of_sixteen(  # type: ignore[no-untyped-def]
    typing, found, to, table, first, step, width, up0, up1, up2, up3, across0, across1, across2, across3
):
    """Set ``LANES`` values of ``found`` from ``to`` to weighted sums over 4 x 4 places of a table, along either axis.

    ``found`` and ``table`` are contiguous, in single precision; ``to``, ``first`` (of the first place), ``step``
    (between places across) and ``width`` (between places up) are unsigned, in numbers of elements.
    """
    of_values = (up0, up1, up2, up3, across0, across1, across2, across3)
    signature = types.void(found, to, table, first, step, width, *of_values)
    return signature, _mix


def _mix(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    """Write the instructions of :func:`mix_of_sixteen`: ((up0 v + up1 v) + up2 v) + up3 v, then two pairs across."""
    vector = ir.VectorType(ir.FloatType(), LANES)

    def lanes_at(number: int, element: Any) -> Any:
        data = context.make_array(signature.args[number])(context, builder, given[number]).data
        return builder.bitcast(builder.gep(data, [element]), vector.as_pointer())

    def in_all(weight: Any) -> Any:
        first = ir.Constant(ir.IntType(32), 0)
        one = builder.insert_element(ir.Constant(vector, ir.Undefined), weight, first)
        return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES))

    _, to, _, line, step, width, *weights = given
    up, across = [in_all(weight) for weight in weights[:4]], [in_all(weight) for weight in weights[4:]]
    sums: list[Any] = []
    for row in range(4):
        place = line
        for column in range(4):
            # Neighbours need not begin at a multiple of the size of a vector.
            value = builder.fmul(up[row], builder.load(lanes_at(2, place), align=4))
            if row:
                sums[column] = builder.fadd(sums[column], value)
            else:
                sums.append(value)
            place = builder.add(place, step)
        line = builder.add(line, width)
    near, second, third, far = (builder.fmul(weight, each) for weight, each in zip(across, sums, strict=True))
    whole = builder.fadd(builder.fadd(near, second), builder.fadd(third, far))
    builder.store(whole, lanes_at(0, to), align=4)
    return context.get_dummy_value()
