"""Regular grids in arrays."""

import numpy as np
import pytest

import tetrascope

LOOK = dict(range=(0, 100), unit_distance=1.0, size=24, camera="+z")


def field(dtype=np.float32, shape=(5, 6, 7)):
    x, y, z = np.meshgrid(*map(np.arange, shape), indexing="ij")
    return (3 * x + 5 * y + 7 * z).astype(dtype)


def pixels(samples, **given):
    return np.asarray(tetrascope.render(samples, **(LOOK | given)))


def test_axes_are_x_y_z():
    samples = np.zeros((4, 6, 8), np.float32)
    samples[3] = 100  # the greatest x
    volume = tetrascope.Volume(samples, spacing=(1, 2, 3), origin=(10, 20, 30))
    assert volume.bounds == (10, 13, 20, 30, 30, 51)
    assert volume.dims == (4, 6, 8) and volume.kind == "grid"
    alpha = pixels(samples)[..., 3]  # seen from +z, y up: x to the right
    columns = np.flatnonzero(alpha.sum(axis=0))
    filled = np.flatnonzero(pixels(np.full_like(samples, 50))[..., 3].sum(axis=0))
    assert columns[0] > filled.mean() and columns[-1] == filled[-1]


def test_orders_of_memory_agree():
    samples = field()
    expected = pixels(samples)
    for other in (
        np.asfortranarray(samples),
        samples.tolist(),
        samples.astype(">f4"),
        np.repeat(samples, 2, axis=1)[:, ::2],
        np.ma.masked_array(samples),
    ):
        assert (pixels(other) == expected).all()


@pytest.mark.parametrize("dtype", ["u1", "u2", "i2", "i1", "i4", "u4", "i8", "u8", "f2", "f4", "f8"])
def test_types_that_hold_the_numbers_agree(dtype):
    volume = tetrascope.Volume(field(dtype))
    assert volume.range == (0, 12 + 25 + 42) and volume.notes == []
    # Integers and floats of one value are one sample.
    assert np.abs(pixels(field(dtype)) - pixels(field())).max() < 1e-6


def test_rounding_is_said():
    samples = 1e6 + field("f8") * 1e-3
    notes = tetrascope.Volume(samples).notes
    assert len(notes) == 1 and "rounded to 32-bit floats" in notes[0]


def test_directions_turn_the_axes():
    samples = field()
    turned = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # x becomes y, y becomes −x
    a = pixels(samples, direction=turned, camera="+z")
    b = pixels(np.swapaxes(samples, 0, 1)[::-1].copy(), origin=(-5, 0, 0), camera="+z")
    assert np.abs(a - b).max() < 1e-5


def test_nearest_samples_fill_cells():
    samples = np.full((2, 2, 2), 50.0)
    assert tetrascope.Volume(samples).bounds[1] == 1
    volume = tetrascope.Volume(samples, interpolation="nearest")
    assert volume.bounds == (-0.5, 1.5, -0.5, 1.5, -0.5, 1.5)


def test_nan_is_a_hole():
    samples = np.full((6, 6, 6), 50.0)
    whole = pixels(samples)[..., 3].sum()
    samples[3:] = np.nan
    assert 0.2 * whole < pixels(samples)[..., 3].sum() < 0.8 * whole


@pytest.mark.parametrize(
    "given, words",
    [
        (dict(spacing=0), "spacing"),
        (dict(spacing=(1, -1, 1)), "spacing"),
        (dict(spacing=(1, 2)), "spacing must be 3 numbers"),
        (dict(origin=np.nan), "origin must be 3 numbers"),
        (dict(origin=(0, np.inf, 0)), "not finite"),
        (dict(direction=np.ones((3, 3))), "orthogonal"),
        (dict(direction=np.eye(4)), "direction must be a matrix of 3×3"),
        (dict(interpolation="cubic"), "no interpolation 'cubic'; valid: linear, nearest"),
    ],
)
def test_wrong_places_are_refused(given, words):
    with pytest.raises(tetrascope.TetrascopeError, match=words):
        tetrascope.Volume(field(), **given)


@pytest.mark.parametrize("shape", [(0, 3, 3), (1, 3, 3), (3, 3), (2, 2, 2, 2), ()])
def test_wrong_shapes_are_refused(shape):
    with pytest.raises(tetrascope.TetrascopeError):
        tetrascope.Volume(np.zeros(shape))
