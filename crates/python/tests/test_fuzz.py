"""No input ends the process or raises what nobody expects.

Each case takes a call that works and spoils some of it: shapes, types, strides, orders, values. A
call may draw or refuse; it may not panic (which arrives as RuntimeError), and what it draws is a
picture.
"""

import warnings

import numpy as np
import pytest

import tetrascope

from conftest import cube_of_tetrahedra

CASES = 800
EXPECTED = (tetrascope.TetrascopeError, TypeError, OSError, MemoryError)


class Sub(np.ndarray):
    pass


def integers(rng, array):
    """Indices that are wrong, here and there."""
    array = np.array(array)
    if array.size:
        at = rng.integers(array.size, size=rng.integers(1, 4))
        values = [-1, -(2**31), 2**31 - 1, 2**31, 2**40, 2**62, -(2**63), 2**63 - 1, 0, 4, 5, 8]
        array = array.astype(np.int64)
        array.reshape(-1)[at] = rng.choice(np.array(values, dtype=np.int64), size=len(at))
    return array


def floats(rng, array):
    """Numbers that are none, or huge, or tiny, here and there."""
    array = np.array(array, dtype=float)
    if array.size:
        at = rng.integers(array.size, size=rng.integers(1, 6))
        values = [np.nan, np.inf, -np.inf, 1e300, -1e300, 1e39, 5e-324, 1e-300, 0.0, -0.0, 1e30]
        array.reshape(-1)[at] = rng.choice(values, size=len(at))
    return array


def form(rng, array):
    """Another shape, type or place in memory."""
    array = np.array(array)
    kind = rng.integers(16)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        if array.dtype.kind not in "iuf":
            kind = 7
        if kind == 0:
            return np.asfortranarray(array)
        if kind == 1:
            return array.astype(array.dtype.newbyteorder(">"))
        if kind == 2:
            return np.repeat(array, 2, axis=0)[::2] if array.ndim else array
        if kind == 3:
            return array.astype(rng.choice(["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f2", "f4", "f8", "?"]))
        if kind == 4:
            return array.astype(rng.choice(["c8", "O", "U8", "S4", "M8[s]", "m8[s]", "g"]))
        if kind == 5:
            return array.view(Sub)
        if kind == 6:
            array.flags.writeable = False
            return array
        if kind == 7:
            return array.tolist()
        if kind == 8:
            return array.T
        if kind == 9:
            return array[: rng.integers(len(array) + 1)] if array.ndim else array
        if kind == 10:
            return array[..., None]
        if kind == 11:
            return array.reshape(-1)
        if kind == 12:
            return np.zeros((0,) * int(rng.integers(1, 4)), array.dtype)
        if kind == 13:
            return rng.choice(np.array([None, 7, -1.5, "text", b"b", {}, [], [[1], [2, 3]], np.nan, object()], object))
        if kind == 14:
            mask = rng.random(array.shape) < 0.2
            return np.ma.masked_array(array, mask)
        return np.broadcast_to(array[:1], array.shape) if array.ndim else array


def spoil(rng, given):
    """One to three parameters of a call spoiled, in place."""
    for name in rng.choice(list(given), size=min(len(given), rng.integers(1, 4)), replace=False):
        value = given[name]
        if rng.random() < 0.4:
            given[name] = form(rng, value)
        elif np.asarray(value).dtype.kind in "iu":
            given[name] = integers(rng, value)
        elif np.asarray(value).dtype.kind == "f":
            given[name] = floats(rng, value)
        else:
            given[name] = form(rng, value)


def of_mesh(rng):
    points, cells = cube_of_tetrahedra(1)
    scalars = points @ [1.0, 2.0, 3.0]
    given = dict(volume=points, scalars=scalars if rng.random() < 0.7 else np.arange(6.0))
    layout = rng.integers(4)
    if layout == 0:
        given |= dict(cells=cells)
    elif layout == 1:
        padded = np.column_stack([np.full(6, 4), cells]).reshape(-1)
        given |= dict(cells=padded, celltypes=np.full(6, 10, np.uint8))
    elif layout == 2:
        given |= dict(cells=cells.reshape(-1), offsets=np.arange(0, 25, 4), celltypes=np.full(6, 10))
    else:
        hexahedra = np.concatenate([[8], [0, 1, 3, 2, 4, 5, 7, 6], [4], cells[0]])
        given |= dict(cells=hexahedra, celltypes=np.array([12, 10]), scalars=scalars)
    return given


def of_grid(rng):
    return dict(
        volume=rng.random((3, 4, 2)),
        spacing=np.array([1.0, 2.0, 3.0]),
        origin=np.zeros(3),
        direction=np.eye(3),
    )


LOOKS = dict(
    position=np.array([5.0, 4.0, 3.0]),
    focal_point=np.array([0.5, 0.5, 0.5]),
    view_up=np.array([0.0, 0.0, 1.0]),
    view_angle=np.array(30.0),
    size=np.array([4, 3]),
    background=np.array([0.0, 0.0, 0.0, 1.0]),
    range=np.array([0.0, 6.0]),
    unit_distance=np.array(1.0),
    opacity=np.array([0.0, 0.5, 1.0]),
    cmap=np.array([[0.0, 0.5, 1.0], [1.0, 0.5, 0.0]]),
    clip=np.array([0.0, 1.0, 0.0, 1.0, 0.0, 1.0]),
    depth_cue=np.array(0.5),
)


def call(rng, given):
    given = dict(given)
    volume = given.pop("volume")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            picture = tetrascope.render(volume, **given)
        except EXPECTED as refusal:
            assert not isinstance(refusal, tetrascope.DeviceError)
            assert str(refusal), refusal
            return False
    assert isinstance(picture, tetrascope.Picture) and picture.dtype == np.float32
    return True


@pytest.mark.parametrize("make", [of_mesh, of_grid])
def test_spoiled_volumes(make):
    rng = np.random.default_rng(18)
    drawn = 0
    for _ in range(CASES):
        given = make(rng)
        spoil(rng, given)
        drawn += call(rng, given | dict(size=3))
    # Some are harmless and some are not, or nothing was tested.
    assert CASES // 20 < drawn < CASES * 19 // 20, drawn


def test_spoiled_looks():
    rng = np.random.default_rng(81)
    volume = tetrascope.Volume(**{k if k != "volume" else "source": v for k, v in of_mesh(rng).items()})
    drawn = 0
    for _ in range(CASES):
        names = rng.choice(list(LOOKS), size=rng.integers(1, len(LOOKS)), replace=False)
        given = {name: LOOKS[name] for name in names}
        spoil(rng, given)
        # What is left whole stays small.
        size = given.get("size", 3)
        if np.asarray(size).dtype.kind in "iuf" and np.size(size) and (np.asarray(size) > 64).any():
            given["size"] = 3
        drawn += call(rng, dict(volume=volume) | given)
    assert CASES // 20 < drawn < CASES * 19 // 20, drawn


def test_spoiled_scalars_and_calls_of_a_renderer():
    rng = np.random.default_rng(8)
    points, cells = cube_of_tetrahedra(1)
    renderer = tetrascope.Renderer(points, cells, None, points[:, 0], size=3)
    for _ in range(CASES):
        given = dict(scalars=points[:, 1], camera=np.array([[5.0, 4, 3], [0, 0, 0], [0, 0, 1]]))
        spoil(rng, given)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for do in (
                lambda: renderer.set_scalars(given["scalars"]),
                lambda: renderer.render(given["camera"]),
                lambda: tetrascope.to_srgb8(form(rng, np.zeros((2, 2, 4)))),
                lambda: renderer.set_transfer_function(
                    [(s, (1, 1, 1), 1) for s in floats(rng, [0, 1, 2])]
                ),
            ):
                try:
                    do()
                except EXPECTED as refusal:
                    assert str(refusal)
            renderer.set_scalars(points[:, 1])
            assert renderer.render().shape == (3, 3, 4)
