"""What the tests share."""

import os
import pathlib

import numpy as np
import pytest

import tetrascope

REPOSITORY = pathlib.Path(os.environ.get("TETRASCOPE_REPOSITORY", pathlib.Path(__file__).parents[3]))


def cube_of_tetrahedra(n=2):
    """Points (m, 3) of the unit cube and tetrahedra (k, 4): six in each of n³ cubes, around one diagonal."""
    axis = np.linspace(0.0, 1.0, n + 1)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    i, j, k = np.meshgrid(*[np.arange(n)] * 3, indexing="ij")
    first = (i + (n + 1) * (j + (n + 1) * k)).ravel()
    steps = np.array([1, n + 1, (n + 1) ** 2])
    orders = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]
    corners = [[0, *np.cumsum(steps[list(order)])] for order in orders]
    cells = (first[:, None, None] + np.array(corners)[None]).reshape(-1, 4)
    return points, cells


@pytest.fixture(scope="session")
def mesh():
    """Points, cells with a row each, and a smooth scalar at points from 0 to 1."""
    points, cells = cube_of_tetrahedra(4)
    scalars = 0.5 + 0.5 * np.sin(5 * points[:, 0]) * np.cos(4 * points[:, 1] + points[:, 2])
    return points, cells, scalars


@pytest.fixture(scope="session")
def look():
    """A view and a look that leave nothing to be chosen."""
    return {
        "position": (3.0, 2.2, 1.9),
        "focal_point": (0.5, 0.5, 0.5),
        "view_up": (0, 0, 1),
        "range": (0, 1),
        "unit_distance": 0.4,
        "size": (40, 30),
    }


@pytest.fixture(scope="session")
def device():
    """Skips where there is no graphics adapter; with CI set there must be one."""
    if tetrascope.info()["adapters"]:
        return
    assert "CI" not in os.environ, "CI is set, but there is no graphics adapter"
    pytest.skip("no graphics adapter")
