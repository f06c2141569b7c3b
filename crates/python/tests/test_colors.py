"""Color maps, opacities and backgrounds."""

import numpy as np
import pytest

import tetrascope


def linear(srgb):
    srgb = np.asarray(srgb, float)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def function(mesh, **look):
    points, cells, scalars = mesh
    given = {"range": (0, 1), "unit_distance": 0.5, "size": 8} | look
    return tetrascope.Renderer(points, cells, None, scalars, **given).transfer_function


def at(function, scalar):
    knots = function.knots
    scalars = [knot[0] for knot in knots]
    colors = np.array([knot[1] for knot in knots])
    color = [np.interp(scalar, scalars, colors[:, i]) for i in range(3)]
    return np.array(color), float(np.interp(scalar, scalars, [knot[2] for knot in knots]))


def test_a_table_is_drawn_as_its_colors(mesh):
    table = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    found = function(mesh, cmap=table)
    for scalar, color in ((0.0, table[0]), (0.5, table[1]), (1.0, table[2])):
        assert np.abs(at(found, scalar)[0] - color).max() < 1e-12
    bytes_ = (255 * table).astype(np.uint8)
    assert function(mesh, cmap=bytes_) == found
    # Opacity is what it is with any other color map.
    plain = function(mesh, cmap="viridis")
    for scalar in np.linspace(0, 1, 23):
        assert at(found, scalar)[1] == pytest.approx(at(plain, scalar)[1], rel=1e-9)


def test_a_long_table_is_thinned_where_nobody_sees_it(mesh):
    share = np.linspace(0, 1, 256)
    table = np.column_stack([share, share**2, np.sqrt(share)])
    found = function(mesh, cmap=table)
    assert len(found.knots) < 150
    for i in range(0, 256, 5):
        srgb = at(found, share[i])[0]
        srgb = np.where(srgb <= 0.0031308, 12.92 * srgb, 1.055 * srgb ** (1 / 2.4) - 0.055)
        # Half a level of 256, which is what may be left out.
        assert np.abs(srgb - table[i]).max() <= 0.5 / 255 + 1e-9


def test_matplotlib_maps_by_name_and_object(mesh):
    matplotlib = pytest.importorskip("matplotlib")
    named = function(mesh, cmap="coolwarm")
    assert named == function(mesh, cmap=matplotlib.colormaps["coolwarm"])
    srgb = np.asarray(matplotlib.colormaps["coolwarm"](0.5))[:3]
    # The middle is between two of 256 entries, which differ by some levels.
    assert np.abs(at(named, 0.5)[0] - linear(srgb)).max() < 0.02
    # Its viridis is ours.
    theirs, ours = function(mesh, cmap=matplotlib.colormaps["viridis"]), function(mesh)
    for scalar in np.linspace(0, 1, 50):
        assert np.abs(at(theirs, scalar)[0] - at(ours, scalar)[0]).max() < 0.01


def test_unknown_maps_name_those_that_exist(mesh):
    with pytest.raises(tetrascope.TetrascopeError, match="no color map 'virids'.*did you mean 'viridis'"):
        function(mesh, cmap="virids")


def test_opacities_are_extinctions_over_the_unit_distance(mesh):
    found = function(mesh, opacity=0.5)
    assert at(found, 0.3)[1] == pytest.approx(np.log(2) / 0.5)
    found = function(mesh, opacity=[0.0, 0.9, 0.1])
    for scalar, alpha in ((0.0, 0.0), (0.5, 0.9), (0.75, 0.5), (1.0, 0.1)):
        # The curve between knots is straight: 2 % at most, as of color maps.
        assert at(found, scalar)[1] == pytest.approx(-np.log1p(-alpha) / 0.5, rel=0.02, abs=1e-9)
    pairs = function(mesh, opacity=[(0.0, 0.0), (0.5, 0.9), (1.0, 0.1)])
    assert pairs == found
    assert function(mesh, opacity=np.array([0, 255], np.uint8)) == function(mesh, opacity="linear")
    assert function(mesh, clim=(0, 1), range=None, opacity_unit_distance=0.5, unit_distance=None) == function(mesh)


def test_opacities_in_a_table(mesh):
    table = np.array([[1, 1, 1, 0.0], [1, 1, 1, 0.8]])
    assert function(mesh, cmap=table).knots[0][2] == 0.0
    assert at(function(mesh, cmap=table), 1.0)[1] == pytest.approx(-np.log(0.2) / 0.5)


@pytest.mark.parametrize(
    "look",
    [
        dict(opacity=[0.0, 1.5]),
        dict(opacity=-0.1),
        dict(opacity=[]),
        dict(opacity=[np.nan]),
        dict(opacity="sigmoid"),
        dict(opacity=[[0, 1, 2]]),
        dict(opacity=[(1, 0), (0, 1)]),
        dict(cmap=[[2, 0, 0]]),
        dict(cmap=[[np.nan, 0, 0]]),
        dict(cmap=np.zeros((0, 3))),
        dict(cmap=np.zeros((2, 5))),
        dict(cmap=7),
        dict(unit_distance=0),
        dict(unit_distance=-1, opacity=0.5),
        dict(range=(1, 0)),
        dict(range=(0, 1, 2)),
        dict(range=(0, 1), clim=(0, 1)),
        dict(transfer_function=[]),
        dict(transfer_function=[(0, (1, 1), 1)]),
        dict(transfer_function=[(0, (1, 1, 1), -1)]),
        dict(transfer_function=[(0, (1, 1, 1), 1)], cmap="magma"),
        dict(optical_model="emission-absorbtion"),
        dict(clip=[((0, 0, 0), (0, 0, 0))]),
        dict(clip=[1, 2, 3]),
        dict(isovalues=[np.inf]),
        dict(depth_cue=2),
        dict(ambient=-1),
    ],
)
def test_wrong_looks_are_refused_in_words(mesh, look):
    with pytest.raises(tetrascope.TetrascopeError) as caught:
        function(mesh, **look)
    assert "--" not in str(caught.value) and len(str(caught.value)) > 8


def test_backgrounds(mesh, look):
    points, cells, scalars = mesh
    corner = lambda background: np.asarray(  # noqa: E731
        tetrascope.render(points, cells, None, scalars, background=background, **look)
    )[0, 0]
    assert corner("white").tolist() == [1, 1, 1, 1]
    assert corner((0.25, 0.5, 1.0)).tolist() == [0.25, 0.5, 1, 1]
    assert corner((1, 1, 1, 0.5)).tolist() == [0.5, 0.5, 0.5, 0.5]
    assert np.abs(corner("#80ff00") - [linear(0x80 / 255), 1, 0, 1]).max() < 1e-6
    with pytest.raises(tetrascope.TetrascopeError, match="no color 'whit'.*did you mean 'white'"):
        corner("whit")


def test_clipping_keeps_the_side_of_the_normal(mesh, look):
    points, cells, scalars = mesh
    half = tetrascope.render(points, cells, None, scalars, clip=((0.5, 0, 0), (1, 0, 0)), **look)
    box = tetrascope.render(points, cells, None, scalars, clip=(0.5, 9, -9, 9, -9, 9), **look)
    assert np.abs(np.asarray(half) - np.asarray(box)).max() < 1e-5
    empty = {"point": (2, 0, 0), "normal": (1, 0, 0)}
    with pytest.warns(tetrascope.TetrascopeWarning, match="the picture is empty"):
        nothing = tetrascope.render(points, cells, None, scalars, clip=empty, **look)
    assert (np.asarray(nothing) == 0).all()
