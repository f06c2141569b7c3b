"""Pictures against closed forms and against the ground truth."""

import numpy as np
import pytest

import tetrascope
from conftest import cube_of_tetrahedra

# A view along z in parallel, in which the unit cube fills the picture's middle half.
ALONG_Z = {
    "position": (0.5, 0.5, 5.0),
    "focal_point": (0.5, 0.5, 0.5),
    "view_up": (0, 1, 0),
    "parallel_scale": 1.0,
    "size": 32,
}
COLOR = np.array([1.0, 0.5, 0.25])

# f32's rounding of sums and an exponential of numbers up to 1, with room for vector units.
ROUNDING = 4e-6


def names():
    return [found["name"] for found in tetrascope.algorithms() if not found["needs_gpu"]]


@pytest.mark.parametrize("algorithm", names())
def test_a_uniform_cube_is_as_opaque_as_the_exponential_says(algorithm):
    points, cells = cube_of_tetrahedra(2)
    function = [(0.0, COLOR, 0.7)]
    picture = tetrascope.render(
        points, cells, None, np.ones(len(points)),
        transfer_function=function, algorithm=algorithm, **ALONG_Z,
    )
    # A ray crosses the cube on a length of 1: α = 1 − e^(−0.7), and color c α.
    alpha = 1 - np.exp(-0.7)
    inside = np.asarray(picture)[9:23, 9:23]
    assert np.abs(inside - [*(COLOR * alpha), alpha]).max() < ROUNDING
    assert (np.asarray(picture)[:7] == 0).all() and (np.asarray(picture)[:, :7] == 0).all()


@pytest.mark.parametrize("algorithm", names())
def test_a_linear_extinction_adds_up_to_its_mean(algorithm):
    points, cells = cube_of_tetrahedra(3)
    # σ = z on a length of 1 from 0 to 1: τ = 1/2, whatever the view's side.
    function = [(0.0, (1, 1, 1), 0.0), (1.0, (1, 1, 1), 1.0)]
    picture = tetrascope.render(
        points, cells, None, points[:, 2],
        transfer_function=function, optical_model="absorption", background="white",
        algorithm=algorithm, **ALONG_Z,
    )
    light = np.asarray(picture)[9:23, 9:23, 0]
    assert np.abs(light - np.exp(-0.5)).max() < ROUNDING


def test_a_grid_is_the_same_cube():
    function = [(0.0, COLOR, 0.0), (3.0, COLOR, 3.0)]
    # Samples x + y + z at spacing 1/4: σ is linear, and its mean along z is x + y + 1/2.
    axis = np.linspace(0, 1, 5)
    samples = axis[:, None, None] + axis[None, :, None] + axis[None, None, :]
    picture = tetrascope.render(
        samples, spacing=0.25, transfer_function=function, **ALONG_Z
    )
    x = (np.arange(32) + 0.5) / 32 * 2 - 0.5
    right, up = x[None, 9:23], x[::-1][9:23, None]
    alpha = 1 - np.exp(-(right + up + 0.5))
    assert np.abs(np.asarray(picture)[9:23, 9:23, 3] - alpha).max() < 1e-5


def test_cell_values_are_constant_in_cells():
    points, cells = cube_of_tetrahedra(2)
    middle = points[cells].mean(axis=1)
    values = np.where(middle[:, 0] < 0.5, 0.0, 1.0)
    function = [(0.0, COLOR, 0.0), (1.0, COLOR, 2.0)]
    picture = np.asarray(
        tetrascope.render(points, cells, None, values, transfer_function=function, **ALONG_Z)
    )
    assert (picture[9:23, 9:15] == 0).all()
    assert np.abs(picture[9:23, 17:23, 3] - (1 - np.exp(-2.0))).max() < ROUNDING


@pytest.mark.parametrize("model", ["emission-absorption", "emission", "absorption", "maximum-intensity"])
def test_the_default_algorithm_is_exact(mesh, look, model):
    points, cells, scalars = mesh
    pictures = [
        np.asarray(
            tetrascope.render(points, cells, None, scalars, optical_model=model, algorithm=name, **look)
        )
        for name in ("raycast-cpu", "reference")
    ]
    # The renderer's own promise against the truth: rounding of f32 alone.
    assert np.abs(pictures[0] - pictures[1]).max() < 1e-4
    assert pictures[1][..., :3].max() > 0.05 or model == "absorption"


def test_isosurfaces_have_depths(mesh, look):
    points, cells, _ = mesh
    # A plane z = 0.3, seen from above.
    picture = tetrascope.render(
        points, cells, None, points[:, 2], isovalues=[0.3], transfer_function=[(0, COLOR, 1)],
        **ALONG_Z,
    )
    assert picture.depths.shape == (32, 32)
    assert np.abs(picture.depths[9:23, 9:23] - 4.7).max() < 1e-5
    assert np.isinf(picture.depths[0]).all()


def test_every_algorithm_draws_what_the_truth_draws(mesh, look, device):
    points, cells, scalars = mesh
    table = tetrascope.compare(points, cells, None, scalars, repeat=1, **look)
    drawn = {row["name"]: row for row in table}
    assert {"reference", "raycast-cpu", "projection", "raycast-peel", "resample"} <= set(drawn)
    # Exact ones are within rounding of f32 on the device; the others resample.
    for name in ("raycast-cpu", "projection", "raycast-peel"):
        assert drawn[name]["rmse"] < 1e-4, table
    assert drawn["reference"]["rmse"] == 0.0
    assert all(row["rmse"] < 0.1 for row in table), table
    assert [row["name"] for row in table.skipped] == ["slicing"]
