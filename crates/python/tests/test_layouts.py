"""One mesh in every layout is one picture, to the last bit."""

import numpy as np
import pytest

import tetrascope


@pytest.fixture(scope="module")
def expected(mesh, look):
    points, cells, scalars = mesh
    return np.asarray(tetrascope.render(points, cells, None, scalars, **look))


def padded(cells):
    return np.column_stack([np.full(len(cells), 4), cells]).reshape(-1)


LAYOUTS = {
    "rows": lambda p, c, s: dict(cells=c),
    "rows and types": lambda p, c, s: dict(cells=c, celltypes=np.full(len(c), 10, np.uint8)),
    "rows and one type": lambda p, c, s: dict(cells=c, celltypes=10),
    "rows and a name": lambda p, c, s: dict(cells=c, celltypes="tetra"),
    "padded": lambda p, c, s: dict(cells=padded(c), celltypes=np.full(len(c), 10, np.uint8)),
    "padded, one type": lambda p, c, s: dict(cells=padded(c), celltypes=10),
    "padded, other integers": lambda p, c, s: dict(
        cells=padded(c).astype(np.uint16), celltypes=np.full(len(c), 10, np.int64)
    ),
    "offsets": lambda p, c, s: dict(
        connectivity=c.reshape(-1), offsets=np.arange(0, 4 * len(c) + 1, 4), celltypes=[10] * len(c)
    ),
    "narrow offsets": lambda p, c, s: dict(
        cells=c.reshape(-1).astype(np.int32),
        offsets=np.arange(0, 4 * len(c) + 1, 4, dtype=np.int32),
        celltypes=np.full(len(c), 10, np.uint8),
    ),
    "dictionary of numbers": lambda p, c, s: dict(cells={10: c}),
    "dictionary of names": lambda p, c, s: dict(cells={"tetra": c.tolist()}),
    "dictionary of two blocks": lambda p, c, s: dict(cells={10: c, 5: c[:3, :3]}),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_agree(mesh, look, expected, layout):
    points, cells, scalars = mesh
    picture = tetrascope.render(points, scalars=scalars, **LAYOUTS[layout](*mesh), **look)
    assert (np.asarray(picture) == expected).all()


class Sub(np.ndarray):
    pass


def read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def misaligned(array):
    data = np.zeros(array.nbytes + 1, np.uint8)
    view = data[1:].view(array.dtype) if False else np.frombuffer(data.data, array.dtype, array.size, 1)
    data[1:] = np.frombuffer(array.tobytes(), np.uint8)
    return view.reshape(array.shape)


FORMS = {
    "as it is": lambda a: a,
    "Fortran order": lambda a: np.asfortranarray(a),
    "every second": lambda a: np.repeat(a, 2, axis=0)[::2],
    "backwards": lambda a: a[::-1].copy()[::-1],
    "big-endian": lambda a: a.astype(a.dtype.newbyteorder(">")),
    "read-only": read_only,
    "subclass": lambda a: a.view(Sub),
    "list": lambda a: a.tolist(),
    "misaligned": misaligned,
    "masked, nothing hidden": lambda a: np.ma.masked_array(a) if a.dtype.kind == "f" else a,
}


@pytest.mark.parametrize("form", FORMS)
def test_forms_of_arrays_agree(mesh, look, expected, form):
    points, cells, scalars = (FORMS[form](array) for array in mesh)
    picture = tetrascope.render(points, cells, None, scalars, **look)
    assert (np.asarray(picture) == expected).all()


def test_narrow_floats_are_what_they_say(mesh, look):
    points, cells, scalars = mesh
    narrow = [points.astype(np.float32), scalars.astype(np.float32)]
    wide = [array.astype(np.float64) for array in narrow]
    a = tetrascope.render(narrow[0], cells.astype(np.int32), None, narrow[1], **look)
    b = tetrascope.render(wide[0], cells, None, wide[1], **look)
    assert (np.asarray(a) == np.asarray(b)).all()


def test_masked_values_are_holes(mesh, look):
    points, cells, scalars = mesh
    mask = points[:, 0] > 0.6
    hidden = tetrascope.render(points, cells, None, np.ma.masked_array(scalars, mask), **look)
    holes = tetrascope.render(points, cells, None, np.where(mask, np.nan, scalars), **look)
    assert (np.asarray(hidden) == np.asarray(holes)).all()
    whole = tetrascope.render(points, cells, None, scalars, **look)
    assert np.asarray(hidden)[..., 3].sum() < 0.9 * np.asarray(whole)[..., 3].sum()


def test_later_changes_of_arrays_change_nothing(mesh, look, expected):
    points, cells, scalars = (array.copy() for array in mesh)
    renderer = tetrascope.Renderer(points, cells, None, scalars, **look)
    points[:], cells[:], scalars[:] = 0, 0, 0
    assert (np.asarray(renderer.render()) == expected).all()


def test_cells_of_other_kinds_are_split():
    points = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    hexahedron = [[0, 1, 3, 2, 4, 5, 7, 6]]
    voxel = [list(range(8))]
    wedges = [[0, 1, 2, 4, 5, 6], [1, 3, 2, 5, 7, 6]]
    scalars = points @ [1.0, 2.0, 4.0]
    look = dict(transfer_function=[(0, (1, 1, 1), 0), (7, (1, 1, 1), 2)], size=24)
    pictures = [
        np.asarray(tetrascope.render(points, cells, kind, scalars, **look))
        for cells, kind in [(hexahedron, None), (voxel, "voxel"), (wedges, None), ({12: hexahedron}, None)]
    ]
    # The field is linear, so how cells are cut changes roundings alone.
    for picture in pictures:
        assert np.abs(picture - pictures[0]).max() < 1e-5
    assert pictures[0][..., 3].max() > 0.5


def test_vectors_are_drawn_by_their_magnitude(mesh, look):
    points, cells, _ = mesh
    a = tetrascope.render(points, cells, None, points, **look)
    b = tetrascope.render(points, cells, None, np.linalg.norm(points, axis=1), **look)
    assert (np.asarray(a) == np.asarray(b)).all()
