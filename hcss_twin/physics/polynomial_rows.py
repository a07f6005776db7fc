"""Polynomials in the plane of an image, row by row: sums of values at nodes with weights of rows and of columns.

The order of the sums is fixed, so that a pixel has the same bits in every window.
"""

from __future__ import annotations

from hcss_twin.core.kernels import inner


@inner()
def weigh_row(found, row, columns, values):  # type: ignore[no-untyped-def]
    """Set R polynomials in the pixels of a row (x, R), from values at nodes (Y, X, R).

    ``row`` (Y,) and ``columns`` (x, X) are the weights of the nodes.
    """
    for r in range(values.shape[2]):
        for x in range(columns.shape[0]):
            found[x, r] = 0.0
        for k in range(values.shape[1]):
            along = 0.0
            for n in range(values.shape[0]):
                along += row[n] * values[n, k, r]
            for x in range(columns.shape[0]):
                found[x, r] += columns[x, k] * along
