"""Vector instructions for Numba: one row of 32 path lengths against all its neighbours' rows.

Numba leaves the minimum over neighbours in memory and turns it over lane by lane; here all lanes stay in
registers (two of AVX-512, four of AVX2, eight of SSE or NEON: LLVM splits them as the machine has it).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 32


@intrinsic
def _pull(typingctx, block, t, start, neighbour, length):  # type: ignore[no-untyped-def]
    """Lower row t of the block (n, 32) by ``block[neighbour[e]] + length[e]``, e over its edges; whether a lane fell.

    The block is C-contiguous, of unsigned integers or floats; `start`, `neighbour` (int32) and `length` (the
    block's dtype) are the graph's rows. Indices are trusted.
    """
    whole = isinstance(block.dtype, types.Integer)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        element = context.get_value_type(block.dtype)
        vector = ir.VectorType(element, LANES)
        index = ir.IntType(64)

        def data(position: int) -> Any:
            return context.make_array(signature.args[position])(context, builder, args[position]).data

        def row(at: Any) -> Any:
            pointer = builder.gep(rows, [builder.mul(at, index(LANES))])
            return builder.bitcast(pointer, vector.as_pointer())

        def read(pointer: Any, at: Any) -> Any:
            return builder.load(builder.gep(pointer, [at]))

        def less(a: Any, b: Any) -> Any:
            return builder.icmp_unsigned("<", a, b) if whole else builder.fcmp_ordered("<", a, b)

        rows, starts, neighbours, lengths = data(0), data(2), data(3), data(4)
        size = context.get_abi_sizeof(element)
        vertex = builder.sext(args[1], index) if args[1].type.width < 64 else args[1]
        first = builder.sext(read(starts, vertex), index)
        last = builder.sext(read(starts, builder.add(vertex, index(1))), index)
        before = builder.load(row(vertex), align=size)
        best = cgutils.alloca_once_value(builder, before)
        with cgutils.for_range_slice(builder, first, last, index(1), index) as (e, _):
            other = builder.sext(read(neighbours, e), index)
            one = builder.insert_element(ir.Constant(vector, ir.Undefined), read(lengths, e), ir.IntType(32)(0))
            step = builder.shuffle_vector(
                one, ir.Constant(vector, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
            )
            there = builder.load(row(other), align=size)
            reach = builder.add(there, step) if whole else builder.fadd(there, step)
            here = builder.load(best)
            builder.store(builder.select(less(reach, here), reach, here), best)
        after = builder.load(best)
        builder.store(after, row(vertex), align=size)
        fell = builder.bitcast(less(after, before), ir.IntType(LANES))
        return builder.icmp_unsigned("!=", fell, ir.IntType(LANES)(0))

    return types.boolean(block, t, start, neighbour, length), codegen


# To a type checker, an intrinsic still has the typing context for a first argument.
pull: Any = _pull


def aligned_block(n: int, dtype: np.dtype) -> np.ndarray:
    """Uninitialised block (n, 32) whose rows do not straddle cache lines."""
    size = n * LANES * dtype.itemsize
    raw = np.empty(size + 64, np.uint8)
    skip = -raw.ctypes.data % 64
    return raw[skip : skip + size].view(dtype).reshape(n, LANES)
