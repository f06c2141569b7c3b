"""Curved cells in arrays are cut into straight ones, as those of files are."""

import numpy as np
import pytest

import tetrascope

TETRAHEDRON = 24
EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]


def bent(bend=0.3):
    """Points (10, 3) of a quadratic tetrahedron whose edges are bent, its cell, and values at its nodes."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    middles = np.array([(corners[a] + corners[b]) / 2 for a, b in EDGES])
    middles += bend * (middles - 0.25)
    points = np.concatenate([corners, middles])
    return points, np.arange(10)[None], points[:, 0] ** 2 + points[:, 1]


def written(path, points, cell, scalars):
    """The same as a legacy VTK file."""
    with open(path, "w") as file:
        print("# vtk DataFile Version 3.0\nbent\nASCII\nDATASET UNSTRUCTURED_GRID", file=file)
        print(f"POINTS {len(points)} double", *map(repr, points.ravel().tolist()), file=file)
        print(f"CELLS 1 {cell.size + 1}\n{cell.size}", *cell.ravel(), file=file)
        print(f"CELL_TYPES 1\n{TETRAHEDRON}\nPOINT_DATA {len(points)}\nSCALARS scalars double 1", file=file)
        print("LOOKUP_TABLE default", *map(repr, scalars.tolist()), file=file)
    return path


@pytest.mark.parametrize("curved", [None, 1e-2])
def test_arrays_and_files_are_cut_alike(tmp_path, look, curved):
    given = bent()
    of_arrays = tetrascope.Volume(given[0], given[1], TETRAHEDRON, given[2], curved=curved)
    of_file = tetrascope.Volume(written(tmp_path / "bent.vtk", *given), curved=curved)
    assert of_arrays.n_cells == of_file.n_cells > 1
    assert of_arrays.notes == of_file.notes
    assert "cut into" in of_arrays.notes[0]
    pictures = [np.asarray(tetrascope.render(v, **look)) for v in (of_arrays, of_file)]
    assert (pictures[0] == pictures[1]).all() and pictures[0].any()


def test_other_scalars_are_those_of_the_points_that_were_given(look):
    points, cells, scalars = bent()
    volume = tetrascope.Volume(points, cells, TETRAHEDRON, scalars)
    assert volume.n_points == len(points)
    other = points[:, 2] * points[:, 0]
    expected = tetrascope.Volume(points, cells, TETRAHEDRON, other)
    renderer = tetrascope.Renderer(volume, **look)
    renderer.set_scalars(other)
    assert (np.asarray(renderer.render()) == tetrascope.render(expected, **look)).all()
    # One value for the one cell that was given.
    renderer.set_scalars([0.5], association="cell")
    constant = tetrascope.Volume(points, cells, TETRAHEDRON, [0.5], association="cell")
    assert (np.asarray(renderer.render()) == tetrascope.render(constant, **look)).all()
    with pytest.raises(tetrascope.TetrascopeError, match="scalars for 10 points and 1 cells"):
        renderer.set_scalars(np.zeros(volume.n_cells + 5))


def test_finer_parts_share_geometry_only_where_it_is_the_same():
    points, cells, scalars = bent()
    volume = tetrascope.Volume(points, cells, TETRAHEDRON, scalars, curved=1e-2)
    same = volume.with_scalars(2 * scalars)
    assert volume._native.shares_geometry(same._native)
    # A linear field on straight edges needs no parts.
    straight = bent(0.0)
    volume = tetrascope.Volume(straight[0], straight[1], TETRAHEDRON, straight[0][:, 0])
    assert volume.n_cells == 1
    assert volume.with_scalars(straight[2]).n_cells > 1


def test_a_wrong_tolerance_and_wrong_nodes_are_refused():
    points, cells, scalars = bent()
    for curved in (0.0, -1.0, float("nan")):
        with pytest.raises(tetrascope.TetrascopeError):
            tetrascope.Volume(points, cells, TETRAHEDRON, scalars, curved=curved)
    with pytest.raises(tetrascope.TetrascopeError, match="point 10"):
        tetrascope.Volume(points, cells + 1, TETRAHEDRON, scalars)
    with pytest.raises(tetrascope.TetrascopeError, match="curved"):
        tetrascope.Volume(np.zeros((3, 3, 3)), curved=1e-3)
