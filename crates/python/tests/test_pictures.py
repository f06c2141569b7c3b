"""Pictures as arrays, files and bytes."""

import pickle
import struct
import zlib

import numpy as np
import pytest

import tetrascope


@pytest.fixture(scope="module")
def picture(mesh, look):
    points, cells, scalars = mesh
    return tetrascope.render(points, cells, None, scalars, **look)


def png_texels(data):
    """The texels of an 8-bit RGBA file, and its texts."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, texts, size = 8, b"", {}, None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            size = struct.unpack(">II", body[:8])
        elif kind == b"IDAT":
            packed += body
        elif kind in (b"tEXt", b"iTXt"):
            key, _, text = body.partition(b"\0")
            texts[key.decode()] = text.decode()
        at += 12 + length
    width, height = size
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 4 * width)
    texels = np.zeros((height, width, 4), np.uint8)
    for y, row in enumerate(rows):
        left = np.zeros(4, int)
        for x in range(width):
            raw = row[1 + 4 * x : 5 + 4 * x].astype(int)
            up = texels[y - 1, x].astype(int) if y else np.zeros(4, int)
            corner = texels[y - 1, x - 1].astype(int) if x and y else np.zeros(4, int)
            paeth = left + up - corner
            distances = np.abs([paeth - left, paeth - up, paeth - corner])
            nearest = np.choose(distances.argmin(axis=0), [left, up, corner])
            left = (raw + [0, left, up, (left + up) // 2, nearest][row[0]]) % 256
            texels[y, x] = left
    return texels, texts


def test_a_picture_is_an_array(picture):
    assert isinstance(picture, np.ndarray) and picture.dtype == np.float32
    assert picture.shape == (30, 40, 4) and picture.flags.c_contiguous and picture.flags.writeable
    colors, alpha = np.asarray(picture)[..., :3], np.asarray(picture)[..., 3:]
    assert alpha.max() <= 1 and (colors <= alpha + 1e-6).all()  # premultiplied
    assert type(picture - picture) is np.ndarray
    assert isinstance(picture[3:9, 2:7], tetrascope.Picture)
    assert float(picture.max()) == np.asarray(picture).max()


def test_statistics_are_a_dictionary(picture):
    stats = picture.stats
    assert stats["cpu_seconds"] > 0 and stats["bytes_resident"] > 0
    assert picture.algorithm == "raycast-cpu" and picture.settings["stop-opacity"] == "1"
    assert picture.adapter is None
    assert picture.notes == ["192 cells had the opposite orientation: fixed"]


def test_srgb_bytes(picture):
    texels = tetrascope.to_srgb8(picture)
    assert texels.dtype == np.uint8 and texels.shape == picture.shape
    straight = np.asarray(picture)[..., :3] / np.maximum(np.asarray(picture)[..., 3:], 1e-30)
    srgb = np.where(straight <= 0.0031308, 12.92 * straight, 1.055 * straight ** (1 / 2.4) - 0.055)
    shown = np.asarray(picture)[..., 3] > 0.01
    assert np.abs(255 * srgb - texels[..., :3])[shown].max() <= 0.51
    assert np.abs(255 * np.asarray(picture)[..., 3] - texels[..., 3]).max() <= 0.5
    one = np.array([[[0.5, 0.5, 0.5, 1.0]]])
    assert tetrascope.to_srgb8(one)[0, 0].tolist() == [188, 188, 188, 255]
    strange = np.array([[[np.nan, 9, -1, 1]]], np.float32)
    assert tetrascope.to_srgb8(strange)[0, 0].tolist() == [0, 255, 0, 255]


def test_jupyter_shows_the_same(picture):
    texels, _ = png_texels(picture._repr_png_())
    assert (texels == tetrascope.to_srgb8(picture)).all()
    part, _ = png_texels(picture[::2, 3:]._repr_png_())
    assert (part == texels[::2, 3:]).all()
    assert picture[..., 0]._repr_png_() is None and picture[:0]._repr_png_() is None


def test_files(picture, tmp_path):
    path = tmp_path / "a.png"
    picture.save(path)
    texels, texts = png_texels(path.read_bytes())
    assert (texels == tetrascope.to_srgb8(picture)).all()
    assert texts["Algorithm"] == "raycast-cpu" and "[camera]" in texts["Scene"]
    assert "_seconds" not in texts["Statistics"]
    picture.save(str(tmp_path / "a.npy"))
    assert (np.load(tmp_path / "a.npy") == np.asarray(picture)).all()
    picture.save(tmp_path / "a.exr")
    assert (tmp_path / "a.exr").read_bytes()[:4] == b"\x76\x2f\x31\x01"
    with pytest.raises(tetrascope.TetrascopeError, match="no image format 'jpg'; valid: png, exr, npy"):
        picture.save(tmp_path / "a.jpg")
    with pytest.raises(FileNotFoundError):
        picture.save(tmp_path / "no folder" / "a.png")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.exr", "a.npy", "a.npy.json", "a.png"]


def test_pictures_travel(picture):
    copy = pickle.loads(pickle.dumps(picture))
    assert isinstance(copy, tetrascope.Picture) and (np.asarray(copy) == np.asarray(picture)).all()
    assert copy.stats == picture.stats and copy.algorithm == "raycast-cpu"


@pytest.mark.parametrize("shape", [(3, 3), (3, 3, 3), (0, 3, 4), (3, 0, 4), (2, 2, 2, 4), ()])
def test_what_is_no_picture_is_refused(shape):
    with pytest.raises(tetrascope.TetrascopeError):
        tetrascope.to_srgb8(np.zeros(shape))
