"""Names and sizes of cells."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._arrays import Array
from ._errors import error, unknown

# meshio's names, and VTK's numbers. Corners come first in all of them, in VTK's order.
NAMES = {
    "vertex": 1,
    "line": 3,
    "triangle": 5,
    "quad": 9,
    "tetra": 10,
    "voxel": 11,
    "hexahedron": 12,
    "wedge": 13,
    "pyramid": 14,
    "line3": 21,
    "triangle6": 22,
    "quad8": 23,
    "quad9": 28,
    "tetra10": 24,
    "hexahedron20": 25,
    "wedge15": 26,
    "pyramid13": 27,
    "hexahedron27": 29,
    "wedge18": 32,
    "hexahedron24": 33,
}

# The volume cells that a number of points means.
BY_POINTS = {4: 10, 5: 14, 6: 13, 8: 12}


def number(kind: Any) -> int:
    """VTK's number of a type of cells, given as that, or as meshio calls it."""
    if isinstance(kind, str):
        if kind not in NAMES:
            raise unknown("cell type", kind, NAMES)
        return NAMES[kind]
    try:
        found = int(kind)
    except (TypeError, ValueError):
        raise error(f"a cell type is a number of VTK's or a name, not {kind!r:.40}") from None
    if not 0 <= found <= 255:
        raise error(f"the cell type {found} is not one of VTK's")
    return found


def together(blocks: list[tuple[int, Array]]) -> tuple[Array, Array, Array]:
    """Types, offsets and connectivity of blocks, each of one type with a row for each cell."""
    types = [np.full(len(block), kind, np.uint8) for kind, block in blocks]
    sizes = [np.full(len(block), block.shape[1], np.int64) for _, block in blocks]
    offsets = np.zeros(sum(map(len, types)) + 1, np.int64)
    np.cumsum(np.concatenate(sizes), out=offsets[1:])
    connectivity = [block.reshape(-1).astype(np.int64, copy=False) for _, block in blocks]
    return np.concatenate(types), offsets, np.concatenate(connectivity)


def hexahedra(dims: tuple[int, int, int]) -> Array:
    """The hexahedra between points that are numbered x fastest, a row for each."""
    i, j, k = (np.arange(max(n - 1, 0), dtype=np.int64) for n in dims)
    nx, ny = dims[0], dims[1]
    first = (i[None, None, :] + nx * (j[None, :, None] + ny * k[:, None, None])).reshape(-1, 1)
    corners = np.array([0, 1, 1 + nx, nx], dtype=np.int64)
    rows: Array = first + np.concatenate([corners, corners + nx * ny])
    return rows
