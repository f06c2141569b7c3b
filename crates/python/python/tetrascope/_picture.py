"""Pictures."""

from __future__ import annotations

import json
import os
import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _arrays as arrays
from . import _tetrascope as native
from ._errors import TetrascopeWarning, error, with_help

Drawn = tuple[Any, Any, str, Any]


class Picture(np.ndarray):
    """A picture: an array (height, width, 4) of float32.

    Premultiplied linear RGBA, the top row first: each channel is already scaled by the opacity,
    and 0.5 is half the light, not sRGB's middle gray. :func:`to_srgb8` makes bytes to show.
    Jupyter shows it as it is; arithmetic gives plain arrays.
    """

    algorithm: str | None
    settings: dict[str, str]
    adapter: str | None
    defaults: list[str]
    depths: npt.NDArray[np.float32] | None
    volume_notes: list[str]
    _stats: str
    _scene: native.Scene | None

    def __array_finalize__(self, parent: Any) -> None:
        # Views and slices are of the picture that they come from; depths are of a whole one.
        self.algorithm = getattr(parent, "algorithm", None)
        self.settings = getattr(parent, "settings", {})
        self.adapter = getattr(parent, "adapter", None)
        self.defaults = getattr(parent, "defaults", [])
        self.volume_notes = getattr(parent, "volume_notes", [])
        self._stats = getattr(parent, "_stats", "{}")
        self._scene = getattr(parent, "_scene", None)
        self.depths = None

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        # A result of arithmetic with pictures is a plain array.
        return array[()] if return_scalar else np.asarray(array)

    def __reduce__(self) -> Any:
        # Pictures travel between processes as arrays, with their statistics.
        return _unpickled, (np.asarray(self), self.algorithm, self.settings, self._stats)

    @property
    def stats(self) -> dict[str, Any]:
        """What the frame took and counted: seconds, bytes, error bound, and so on."""
        stats: dict[str, Any] = json.loads(self._stats)
        return stats

    @property
    def notes(self) -> list[str]:
        """What was found out about the volume, and fallbacks that were taken, a sentence each."""
        return [*self.volume_notes, *self.stats.get("notes", [])]

    @property
    def scene(self) -> str:
        """The scene with nothing left out, as TOML."""
        return "" if self._scene is None else self._scene.to_toml()

    @property
    def camera(self) -> dict[str, Any]:
        """The camera, with VTK's names; give it to another picture."""
        if self._scene is None:
            return {}
        camera: dict[str, Any] = json.loads(self._scene.to_json())["camera"]
        orthographic = camera.pop("projection", None) == "orthographic"
        return camera | ({"orthographic": True} if orthographic else {})

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture: ``.png`` (8-bit sRGB, straight alpha), ``.exr`` or ``.npy`` (as it is).

        The file holds the scene, the algorithm and the statistics, and appears whole or not at all.
        """
        native.write_image(os.fsdecode(path), _whole(self), self._metadata())

    def _metadata(self) -> list[tuple[str, str]]:
        if self.algorithm is None:
            return []
        settings = ",".join(f"{name}={value}" for name, value in self.settings.items())
        # The same picture is the same file: no times.
        stats = {k: v for k, v in self.stats.items() if not k.endswith("_seconds") and v is not None}
        texts = {
            "Software": f"tetrascope {native.VERSION}",
            "Algorithm": self.algorithm,
            "Settings": settings,
            "Adapter": self.adapter or "CPU",
            "Mesh": "\n".join(self.volume_notes),
            "Statistics": json.dumps(stats),
            "Scene": self.scene,
        }
        return [(key, text) for key, text in texts.items() if text]

    def _repr_png_(self) -> bytes | None:
        if self.ndim != 3 or self.shape[2] != 4 or 0 in self.shape:
            return None
        return native.encode_png(_whole(self), [])


def _unpickled(array: Any, algorithm: str | None, settings: dict[str, str], stats: str) -> Picture:
    picture: Picture = array.view(Picture)
    picture.algorithm, picture.settings, picture._stats = algorithm, settings, stats
    return picture


def _whole(array: Any) -> npt.NDArray[np.float32]:
    """An array that the native side reads: contiguous rows of pixels."""
    given = arrays.numbers("a picture", array)
    whole: arrays.Array = arrays.plain(given, np.float32).reshape(given.shape)
    if whole.ndim != 3 or whole.shape[2] != 4 or 0 in whole.shape:
        shape = "×".join(map(str, whole.shape))
        raise error(f"an array of {shape} is not a picture", "give (height, width, 4)")
    return whole


def to_srgb8(image: Any) -> npt.NDArray[np.uint8]:
    """Bytes to show: (height, width, 4) of uint8, sRGB with straight alpha, top row first.

    ``image`` is premultiplied linear RGBA, as :func:`render` gives it. NaN is 0, and what is
    beyond [0, 1] is clamped. These are the texels of :meth:`Picture.save`'s PNG files.
    """
    return native.to_srgb8(_whole(image))


def picture_of(
    drawn: Drawn,
    scene: native.Scene,
    algorithm: str,
    settings: dict[str, str],
    adapter: str | None,
    notes: list[str],
) -> Picture:
    """A picture of what was drawn; warns where it shows nothing."""
    pixels, depths, stats, warning = drawn
    picture: Picture = pixels.view(Picture)
    picture.algorithm, picture.settings, picture.adapter = algorithm, settings, adapter
    picture.defaults, picture.volume_notes = scene.defaults, notes
    picture.depths, picture._stats, picture._scene = depths, stats, scene
    if warning is not None:
        warnings.warn(with_help(*warning), TetrascopeWarning, stacklevel=4)
    return picture
