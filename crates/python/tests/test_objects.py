"""Objects of PyVista, VTK and meshio: stand-ins that look like them, and the real ones where installed."""

from types import SimpleNamespace

import numpy as np
import pytest

import tetrascope


def same(a, b):
    return (np.asarray(a) == np.asarray(b)).all()


@pytest.fixture(scope="module")
def expected(mesh, look):
    points, cells, scalars = mesh
    return tetrascope.render(points, cells, None, scalars, **look)


def padded(cells):
    return np.column_stack([np.full(len(cells), 4), cells]).reshape(-1)


def like_pyvista(mesh, **data):
    points, cells, _ = mesh
    return SimpleNamespace(
        points=points,
        cells=padded(cells),
        celltypes=np.full(len(cells), 10, np.uint8),
        point_data=data,
        cell_data={"number": np.arange(len(cells))},
        active_scalars_name=None,
    )


def like_meshio(mesh, **data):
    points, cells, _ = mesh
    half = len(cells) // 2
    return SimpleNamespace(
        points=points,
        cells=[
            SimpleNamespace(type="tetra", data=cells[:half]),
            SimpleNamespace(type="triangle", data=cells[:2, :3]),
            SimpleNamespace(type="tetra", data=cells[half:]),
        ],
        cells_dict={},
        point_data=data,
        cell_data={"part": [np.zeros(half), np.zeros(2), np.ones(len(cells) - half)]},
    )


@pytest.mark.parametrize("like", [like_pyvista, like_meshio])
def test_objects_that_look_like_meshes(mesh, look, expected, like):
    scalars = mesh[2]
    given = like(mesh, constant=np.ones_like(scalars), s=scalars, v=np.column_stack([scalars] * 3))
    # The first field that is not the same everywhere.
    assert same(tetrascope.render(given, **look), expected)
    assert same(tetrascope.render(given, field="s", **look), expected)
    assert same(tetrascope.render(given, field="point:s", **look), expected)
    assert same(tetrascope.render(given, field="v-y", **look), expected)
    assert same(tetrascope.render(given, scalars=scalars, **look), expected)
    with pytest.raises(tetrascope.TetrascopeError, match="no field 'ss'; valid: constant, s, v"):
        tetrascope.render(given, field="ss")


def test_cell_data_of_blocks(mesh, look):
    points, cells, _ = mesh
    found = tetrascope.render(like_meshio(mesh), **look)
    part = np.arange(len(cells)) >= len(cells) // 2
    assert same(found, tetrascope.render(points, cells, None, part, **look))


def test_objects_that_look_like_grids(look):
    samples = np.random.default_rng(3).random((4, 5, 6)).astype(np.float32)
    given = SimpleNamespace(
        dimensions=samples.shape,
        spacing=(0.3, 0.2, 0.1),
        origin=(0.1, 0.0, 0.2),
        point_data={"s": samples.reshape(-1, order="F")},
        cell_data={"c": samples[1:, 1:, 1:].reshape(-1, order="F")},
        active_scalars_name="s",
    )
    place = dict(spacing=(0.3, 0.2, 0.1), origin=(0.1, 0.0, 0.2))
    assert same(tetrascope.render(given, **look), tetrascope.render(samples, **place, **look))
    middle = dict(spacing=(0.3, 0.2, 0.1), origin=(0.25, 0.1, 0.25), interpolation="nearest")
    cells = tetrascope.render(samples[1:, 1:, 1:], **middle, **look)
    assert same(tetrascope.render(given, field="c", **look), cells)


def test_what_is_no_volume_is_refused():
    for given in (object(), 3, {"points": 1}, None, SimpleNamespace(points=1)):
        with pytest.raises(tetrascope.TetrascopeError):
            tetrascope.render(given)


def test_pyvista(mesh, look, expected):
    pyvista = pytest.importorskip("pyvista")
    points, cells, scalars = mesh
    grid = pyvista.UnstructuredGrid(padded(cells), np.full(len(cells), 10), points)
    grid["s"] = scalars
    grid.cell_data["number"] = np.arange(len(cells))
    assert same(tetrascope.render(grid, **look), expected)
    assert same(tetrascope.render(grid, field="s", **look), expected)
    numbers = tetrascope.render(points, cells, None, np.arange(len(cells)), **look)
    assert same(tetrascope.render(grid, field="number", **look), numbers)

    samples = np.random.default_rng(5).random((4, 5, 6))
    image = pyvista.ImageData(dimensions=samples.shape, spacing=(0.3, 0.2, 0.1), origin=(1, 2, 3))
    image["s"] = samples.reshape(-1, order="F")
    image.cell_data["c"] = np.arange(3 * 4 * 5)
    place = dict(spacing=(0.3, 0.2, 0.1), origin=(1, 2, 3))
    look = {**look, "focal_point": (1.4, 2.4, 3.2)}
    assert same(tetrascope.render(image, field="s", **look), tetrascope.render(samples, **place, **look))
    volume = tetrascope.Volume(image, field="c")
    assert np.allclose(volume.bounds, image.bounds) and volume.n_cells == image.n_cells

    x, y, z = np.meshgrid(*[np.linspace(0, 1, n) for n in (3, 4, 5)], indexing="ij")
    for block in (pyvista.StructuredGrid(x, y, z), pyvista.RectilinearGrid(x[:, 0, 0], y[0, :, 0], z[0, 0])):
        block["s"] = block.points @ [1.0, 2.0, 3.0]
        other = tetrascope.Volume(block.cast_to_unstructured_grid(), field="s")
        volume = tetrascope.Volume(block, field="s")
        assert volume.bounds == other.bounds and volume.n_cells == other.n_cells
        assert same(tetrascope.render(volume, size=9), tetrascope.render(other, size=9))

    camera = pyvista.Camera()
    camera.position, camera.focal_point, camera.up = look["position"], (0.5, 0.5, 0.5), (0, 0, 1)
    rest = {k: v for k, v in look.items() if k not in ("position", "focal_point", "view_up")}
    assert same(tetrascope.render(grid, camera=camera, **rest), expected)
    triple = [look["position"], (0.5, 0.5, 0.5), (0, 0, 1)]
    assert same(tetrascope.render(grid, camera=triple, **rest), expected)
    with pytest.raises(tetrascope.TetrascopeError, match="several data sets"):
        tetrascope.render(pyvista.MultiBlock([grid]))
    with pytest.raises(tetrascope.TetrascopeError, match="no volume cells"):
        tetrascope.render(pyvista.Sphere())


def test_vtk(mesh, look, expected, tmp_path):
    vtk = pytest.importorskip("vtkmodules.all")
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    points, cells, scalars = mesh
    grid = vtk.vtkUnstructuredGrid()
    places = vtk.vtkPoints()
    places.SetData(support.numpy_to_vtk(points, deep=True))
    grid.SetPoints(places)
    connectivity = vtk.vtkCellArray()
    connectivity.SetData(4, support.numpy_to_vtkIdTypeArray(cells.astype(np.int64).ravel(), deep=True))
    grid.SetCells(10, connectivity)
    array = support.numpy_to_vtk(scalars, deep=True)
    array.SetName("s")
    grid.GetPointData().SetScalars(array)
    assert same(tetrascope.render(grid, **look), expected)
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(tmp_path / "mesh.vtu"))
    writer.SetInputData(grid)
    writer.Write()
    assert same(tetrascope.render(tmp_path / "mesh.vtu", **look), expected)
    assert tetrascope.info(tmp_path / "mesh.vtu")["fields"][0]["name"] == "s"


def test_resampling_agrees_with_vtk(mesh, device):
    vtk = pytest.importorskip("vtkmodules.all")
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    pyvista = pytest.importorskip("pyvista")
    points, cells, scalars = mesh
    found = tetrascope.resample(points, cells, None, scalars, dims=(9, 10, 11))
    grid = pyvista.UnstructuredGrid(padded(cells), np.full(len(cells), 10), points)
    grid["s"] = scalars
    image = vtk.vtkImageData()
    image.SetDimensions(9, 10, 11)
    image.SetOrigin(*found.origin)
    image.SetSpacing(*found.spacing)
    probe = vtk.vtkProbeFilter()
    probe.SetInputData(image)
    probe.SetSourceData(grid)
    probe.Update()
    theirs = support.vtk_to_numpy(probe.GetOutput().GetPointData().GetArray("s"))
    assert found.inside.all()
    # Both interpolate linearly; ours in f32 on values up to 1.
    assert np.abs(found.values.reshape(-1, order="F") - theirs).max() < 1e-5


def test_meshio(mesh, look, expected, tmp_path):
    meshio = pytest.importorskip("meshio")
    points, cells, scalars = mesh
    given = meshio.Mesh(points, [("tetra", cells)], point_data={"s": scalars})
    assert same(tetrascope.render(given, **look), expected)
    given.write(tmp_path / "mesh.vtu")
    assert same(tetrascope.render(str(tmp_path / "mesh.vtu"), field="s", **look), expected)
