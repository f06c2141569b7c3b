"""Cameras, with VTK's names, and colors of backgrounds."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from . import _arrays as arrays
from . import _tetrascope as native
from ._errors import error, unknown


@dataclass(frozen=True)
class Camera:
    """A camera in world space, right-handed, with VTK's names.

    ``position`` is the eye, world units; ``focal_point`` what it looks at, the volume's center
    unless given; ``view_up`` a direction that points up, (0, 1, 0) unless given; ``view_angle`` the
    vertical opening angle, degrees, 30 unless given. With ``parallel_scale``, half the height of
    the picture in world units, it is orthographic.

    In place of ``position``, ``fit`` is a side from which the whole volume is seen: "+x", "-x", "+y",
    "-y", "+z", "-z", "+iso", "-iso"; ``orthographic=True`` then makes rays parallel.
    """

    position: Any = None
    focal_point: Any = None
    view_up: Any = None
    view_angle: float | None = None
    parallel_scale: float | None = None
    fit: str | None = None
    orthographic: bool | None = None

    def _json(self) -> dict[str, Any]:
        written: dict[str, Any] = {}
        for name, value in asdict(self).items():
            if value is None:
                continue
            if name == "fit":
                sides = json.loads(native.names(False))["fits"]
                side = str(value).removeprefix("fit")
                if side not in sides:
                    raise unknown("camera", value, sides)
                written[name] = side
            elif name == "orthographic":
                if bool(value):
                    written["projection"] = "orthographic"
            elif name in ("view_angle", "parallel_scale"):
                written[name] = arrays.number(name, value)
            else:
                written[name] = arrays.vector(name, value)
        return written


NAMES = tuple(Camera.__dataclass_fields__)


def camera_of(given: Any) -> Camera:
    """A camera, whatever describes it: a side, a dictionary, VTK's, PyVista's."""
    if isinstance(given, Camera):
        return given
    if isinstance(given, str):
        return Camera(fit=given)
    if isinstance(given, dict):
        for name in given:
            if name not in NAMES:
                raise unknown("part of a camera", name, NAMES)
        return Camera(**given)
    if hasattr(given, "GetFocalPoint"):
        parallel = bool(given.GetParallelProjection())
        return Camera(
            given.GetPosition(),
            given.GetFocalPoint(),
            given.GetViewUp(),
            None if parallel else given.GetViewAngle(),
            given.GetParallelScale() if parallel else None,
        )
    try:
        position, focal_point, view_up = given
    except (TypeError, ValueError):
        raise error(
            f"a camera must be a side such as '+iso', a dictionary or a Camera, not {given!r:.40}"
        ) from None
    # PyVista's `camera_position`.
    return Camera(position, focal_point, view_up)


COLORS = {
    "black": (0.0, 0.0, 0.0, 1.0),
    "white": (1.0, 1.0, 1.0, 1.0),
    "transparent": (0.0, 0.0, 0.0, 0.0),
}


def background_of(given: Any) -> list[float]:
    """Linear RGBA with straight alpha."""
    if isinstance(given, str):
        if given in COLORS:
            return list(COLORS[given])
        digits = given.removeprefix("#")
        if given.startswith("#") and len(digits) in (6, 8):
            try:
                channels = [int(digits[i : i + 2], 16) / 255 for i in range(0, len(digits), 2)]
            except ValueError:
                raise unknown("color", given, [*COLORS, "#rrggbb", "#rrggbbaa"]) from None
            return [_linear(channel) for channel in channels[:3]] + (channels[3:] or [1.0])
        raise unknown("color", given, [*COLORS, "#rrggbb", "#rrggbbaa"])
    array = arrays.numbers("background", given)
    if array.shape not in ((3,), (4,)):
        raise error(f"background must be 3 or 4 numbers or a name, not {arrays.shape(array)}")
    return arrays.vector("background", [*array, 1.0][:4], 4)


def _linear(srgb: float) -> float:
    """IEC 61966-2-1."""
    return srgb / 12.92 if srgb <= 0.04045 else float(((srgb + 0.055) / 1.055) ** 2.4)


def size_of(given: Any) -> tuple[int, int]:
    """Width and height, pixels; a square of one number."""
    array = arrays.indices("size", given)
    if array.shape not in ((), (1,), (2,)) or (array < 0).any() or (array > 1 << 31).any():
        raise error(f"size must be a width and a height, not {given!r:.40}", "give pixels")
    width, height = np.broadcast_to(array, (2,))
    return int(width), int(height)
