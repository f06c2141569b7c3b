"""Errors are exceptions in the library's words."""

import os
import subprocess
import sys

import numpy as np
import pytest

import tetrascope


def refused(words, *arguments, **options):
    with pytest.raises(tetrascope.TetrascopeError, match=words) as caught:
        tetrascope.Volume(*arguments, **options)
    text = str(caught.value)
    assert "--" not in text and "tetrascope " not in text and "\n" not in text, text
    return caught.value


def test_classes():
    assert issubclass(tetrascope.TetrascopeError, ValueError)
    assert issubclass(tetrascope.DeviceError, (tetrascope.TetrascopeError, RuntimeError))


def test_meshes(mesh):
    points, cells, scalars = mesh
    count, most = len(points), len(cells)
    wrong = cells.copy()
    wrong[3, 1] = count
    refused(f"cell 3 uses point {count}, but there are {count} points", points, wrong, 10, scalars)
    wrong[3, 1] = -3
    error = refused("cell 3 uses point -3", points, wrong, 10, scalars)
    assert error.help == "points are counted from 0"
    wrong[3, 1] = 1 << 40
    refused("cell 3 uses point 1099511627776", points, wrong, 10, scalars)
    hexahedra = np.zeros((2, 8), int)
    hexahedra[1, 7] = -1
    refused("point number 15 is -1", points, hexahedra, None, scalars)
    refused(f"7 scalars for {count} points and {most} cells", points, cells, 10, scalars[:7])
    refused("'s' has 7 values", points, cells, 10, scalars[:7], association="point", field="s")
    refused("three coordinates each", points[:, :2], cells, 10, scalars)
    refused("three coordinates each", points.T, cells, 10, scalars)
    refused("cells must be integers", points, cells.astype(float), 10, scalars)
    refused("points must be real numbers, not of type complex128", points * 1j, cells, 10, scalars)
    refused("scalars must be real numbers", points, cells, 10, ["a"] * count)
    refused("points cannot be made an array", [[0, 1], [2]], cells, 10, scalars)
    refused("a mesh needs scalars", points, cells)
    refused("need celltypes", points, cells[:, :3], None, scalars)
    refused("no cell type 'tettra'; .*did you mean 'tetra'", points, {"tettra": cells}, None, scalars)
    refused("only 2 × triangle|no volume cells", points, cells[:2, :3], 5, scalars)
    refused("the mesh has no cells|needs cells", points, {}, None, scalars)


def test_padded_lists(mesh):
    points, cells, scalars = mesh
    padded = np.column_stack([np.full(len(cells), 4), cells]).reshape(-1)
    types = np.full(len(cells), 10)
    refused(f"{len(cells)} cells have {len(cells) - 1} types", points, padded, types[1:], scalars)
    broken = padded.copy()
    broken[0] = 10**9
    refused("cell 0 says that 1000000000 points follow", points, broken, types, scalars)
    broken[0] = -4
    refused("cell 0 says that -4 points follow", points, broken, types, scalars)
    refused("celltypes hold 300", points, padded, types + 290, scalars)
    refused("offset 1 is -4", points, cells.ravel(), types, scalars, offsets=-4 * np.arange(len(cells) + 1))
    refused("needs? .* offsets|offsets", points, cells.ravel(), types, scalars, offsets=[0, 4])


def test_parameters_that_do_not_exist(mesh):
    points, cells, scalars = mesh
    with pytest.raises(TypeError, match="no parameter 'camra'; did you mean 'camera'?"):
        tetrascope.render(points, cells, None, scalars, camra="+x")
    with pytest.raises(TypeError, match="no parameter 'colour'"):
        tetrascope.render("sphere", colour=1)


def test_parameters_that_do_not_go_together(mesh):
    points, cells, scalars = mesh
    refused("`spacing` do not go with a mesh", points, cells, None, scalars, spacing=1)
    refused("`step` do not go with arrays", points, cells, None, scalars, step=1)
    refused("`scalars` do not go with a file", "sphere", scalars=scalars)
    with pytest.raises(tetrascope.TetrascopeError, match="camera excludes position"):
        tetrascope.render(points, cells, None, scalars, camera="+x", position=(1, 2, 3))
    with pytest.raises(tetrascope.TetrascopeError, match="no camera '\\+w'"):
        tetrascope.render(points, cells, None, scalars, camera="+w")
    with pytest.raises(tetrascope.TetrascopeError, match="the camera has no position"):
        tetrascope.render(points, cells, None, scalars, view_angle=20)


def test_files(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        tetrascope.render(tmp_path / "none.vtu")
    assert caught.value.filename.endswith("none.vtu")
    with pytest.raises(tetrascope.TetrascopeError, match="DICOM series"):
        tetrascope.render(tmp_path)
    (tmp_path / "text.vtu").write_text("not a mesh")
    refused("text.vtu", tmp_path / "text.vtu")
    refused("'spheer' is neither a file nor a data set; did you mean 'sphere'", "spheer")
    refused("without a character", "")
    refused("no field 'x'; there are", "sphere", field="x")


def test_times_of_files_without(tmp_path):
    refused("step", "sphere", step=1)
    refused("must be a whole number", "sphere", n_cells=2.5)
    refused("must be from 0", "sphere", seed=-1)


FORK = """
import multiprocessing, tetrascope
def draw(_=None):
    try:
        return tetrascope.render("sphere", n_cells=100, size=4).shape
    except tetrascope.TetrascopeError as error:
        return str(error)
if __name__ == "__main__":
    draw()
    with multiprocessing.get_context("fork").Pool(1) as pool:
        print(pool.map(draw, [0])[0])
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        print(pool.map(draw, [0])[0])
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_is_an_error_and_not_a_hang(tmp_path):
    script = tmp_path / "fork.py"
    script.write_text(FORK)
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=300)
    forked, spawned = run.stdout.splitlines()
    assert "forked" in forked and "'spawn' or 'forkserver'" in forked, run.stderr
    assert spawned == "(4, 4, 4)"
