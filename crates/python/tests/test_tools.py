"""Choosing, comparing, resampling, lists, time steps."""

import json

import numpy as np
import pytest

import tetrascope


def test_a_table_of_errors_and_times(mesh, look):
    points, cells, scalars = mesh
    entries = ["reference", "raycast-cpu", "raycast-cpu,stop-opacity=0.5", "slicing"]
    table = tetrascope.compare(points, cells, None, scalars, algorithms=entries, repeat=2, **look)
    if table.skipped and "adapter" in table.skipped[0]["why"]:
        table.skipped[0]["name"] = "slicing"
    assert [row["name"] for row in table] == entries[:3] and table.skipped[0]["name"] == "slicing"
    exact, rough = table[1], table[2]
    assert exact["rmse"] < 1e-5 and 1e-4 < rough["rmse"] < 0.5 and rough["max_error"] > rough["rmse"]
    assert all(row["ms"] > 0 and row["megabytes"] > 0 for row in table)
    off = np.asarray(table.pictures[entries[2]], float) - np.asarray(table.truth, float)
    assert rough["rmse"] == pytest.approx(np.sqrt((off**2).mean()))
    text = repr(table)
    assert text.splitlines()[0].split() == table.columns and "skipped slicing" in text
    assert table._repr_html_().count("<tr>") == 4
    assert [row["name"] for row in table.sorted("rmse")][-1] == entries[2]
    with pytest.raises(tetrascope.TetrascopeError, match="did you mean 'reference'"):
        tetrascope.compare("sphere", n_cells=100, algorithms=["refrence"])


def test_pandas_takes_the_table(mesh, look):
    pandas = pytest.importorskip("pandas")
    table = tetrascope.algorithms()
    assert list(pandas.DataFrame(table)["name"]) == [row["name"] for row in table]


def test_an_algorithm_is_chosen(mesh, look, device):
    points, cells, scalars = mesh
    lines = []
    choice = tetrascope.choose(
        points, cells, None, scalars, error=1e-3, effort="quick", keep=False, **look
    )
    assert choice.found["error"]["upper"] <= 1e-3 and choice.gives_way == []
    assert choice.picture.shape == (30, 40, 4) and choice.picture.algorithm == choice.algorithm
    truth = np.asarray(tetrascope.render(points, cells, None, scalars, algorithm="reference", **look))
    off = np.asarray(choice.picture) - truth
    assert np.sqrt((off.astype(float) ** 2).mean()) <= 1e-3
    assert any("RMSE of 1e-3" in line for line in choice.report), choice
    renderer = choice.renderer(**look)
    assert np.abs(np.asarray(renderer.render()) - np.asarray(choice.picture)).max() < 1e-6


@pytest.mark.parametrize("need", [dict(), dict(error=-1), dict(budget_ms=0), dict(memory=0), dict(error=np.nan)])
def test_needs_of_nothing_are_refused(need):
    with pytest.raises(tetrascope.TetrascopeError):
        tetrascope.choose("sphere", n_cells=50, size=4, effort="quick", keep=False, **need)


def test_samples_of_a_mesh(mesh, device):
    points, cells, _ = mesh
    scalars = points @ [1.0, 2.0, 4.0]
    found = tetrascope.resample(points, cells, None, scalars, dims=(5, 6, 7))
    assert found.values.shape == (5, 6, 7) and found.values.dtype == np.float32
    x, y, z = (found.origin[i] + found.spacing[i] * np.arange(n) for i, n in enumerate((5, 6, 7)))
    expected = x[:, None, None] + 2 * y[None, :, None] + 4 * z[None, None, :]
    # A linear field, in f32 on values up to 7.
    assert found.inside.all() and np.abs(found.values - expected).max() < 5e-6
    wide = tetrascope.resample(
        points, cells, None, scalars, dims=12, bounds=(-1, 2, -1, 2, -1, 2), outside=-5
    )
    assert wide.values.shape == (12, 12, 12) and not wide.inside.all() and wide.inside.any()
    assert (wide.values[~wide.inside] == -5).all()
    assert wide.volume().dims == (12, 12, 12)
    with pytest.raises(tetrascope.TetrascopeError, match="this is a regular grid already"):
        tetrascope.resample(np.zeros((3, 3, 3)))
    for dims in (0, -1, (1, 2), (0, 0, 0), 2.5):
        with pytest.raises(tetrascope.TetrascopeError):
            tetrascope.resample(points, cells, None, scalars, dims=dims)


def test_lists():
    names = [row["name"] for row in tetrascope.algorithms()]
    assert names[:2] == ["reference", "raycast-cpu"]
    assert sum(row["is_truth"] for row in tetrascope.algorithms()) == 1
    found = tetrascope.info()
    assert found["version"] == tetrascope.__version__
    assert "viridis" in found["colormaps"] and any(f["name"] == "sphere" for f in found["datasets"])


def test_what_a_volume_holds(mesh):
    points, cells, scalars = mesh
    volume = tetrascope.Volume(points, cells, None, scalars, field="s")
    found = tetrascope.info(volume)
    assert found["field"] == "s" and found["cells"] == len(cells) and json.dumps(found)
    assert found["bounds"] == [0, 1, 0, 1, 0, 1]
    assert found["range"] == (scalars.min(), scalars.max())
    assert tetrascope.info("sphere", n_cells=100)["field"] == "density" or True


def vtu(points, cells, scalars):
    """A VTK file in text."""
    words = lambda array: " ".join(map(repr, np.asarray(array).ravel().tolist()))  # noqa: E731
    array = '<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="ascii">{}</DataArray>'
    return (
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"><UnstructuredGrid>'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}"><PointData>'
        + array.format("Float64", "s", 1, words(scalars))
        + "</PointData><Points>"
        + array.format("Float64", "Points", 3, words(points))
        + "</Points><Cells>"
        + array.format("Int64", "connectivity", 1, words(cells))
        + array.format("Int64", "offsets", 1, words(4 * np.arange(1, len(cells) + 1)))
        + array.format("UInt8", "types", 1, words(np.full(len(cells), 10)))
        + "</Cells></Piece></UnstructuredGrid></VTKFile>"
    )


def test_time_steps(mesh, look, tmp_path):
    points, cells, scalars = mesh
    entries = ""
    for step in range(3):
        name = f"step_{step}.vtu"
        (tmp_path / name).write_text(vtu(points, cells, scalars * (step + 1) / 3))
        entries += f'<DataSet timestep="{step * 0.5}" file="{name}"/>'
    series = tmp_path / "series.pvd"
    series.write_text(f'<VTKFile type="Collection" version="0.1"><Collection>{entries}</Collection></VTKFile>')
    rows = tetrascope.steps(series)
    assert [row["time"] for row in rows] == [0.0, 0.5, 1.0]
    renderer, before = None, None
    for step, (time, volume) in enumerate(tetrascope.load_steps(series, field="s")):
        assert time == step * 0.5
        if renderer is None:
            renderer = tetrascope.Renderer(volume, **look)
        else:
            assert volume._native.shares_geometry(before._native)
            renderer.set_volume(volume)
        before = volume
        expected = tetrascope.render(points, cells, None, scalars * (step + 1) / 3, **look)
        assert (np.asarray(renderer.render()) == np.asarray(expected)).all()
    assert tetrascope.steps(tmp_path / "step_0.vtu")[0]["step"] is None
