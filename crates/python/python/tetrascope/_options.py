"""The parameters that `render`, `Renderer`, `choose` and `compare` share."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any, TypedDict

import numpy as np

from . import _arrays as arrays
from . import _camera, _transfer_function
from . import _tetrascope as native
from ._errors import error, unknown
from ._volume import Volume


class VolumeOptions(TypedDict, total=False):
    """Which volume; see :class:`Volume`."""

    offsets: Any
    connectivity: Any
    association: str | None
    field: str | None
    spacing: Any
    origin: Any
    direction: Any
    interpolation: str | None
    step: int | None
    time: float | None
    solution: str | os.PathLike[str] | None
    n_cells: int | None
    seed: int | None
    dims: Any
    type: str | None
    offset: int | None
    byte_order: str | None
    curved: float | None


class ColorOptions(TypedDict, total=False):
    """How scalars become light.

    cmap
        A color map: "viridis", "cividis", "inferno", "magma", "plasma", "coolwarm", "gray"; any of matplotlib's, by
        name or object; an array (n, 3) or (n, 4) of sRGB from 0 to 1, whose fourth column is
        opacities. ``colormap`` is the same.
    range
        (low, high) of the scalars that the color map spans, in the field's unit. Left out, it is
        chosen from the values, without outliers. ``clim`` is the same.
    opacity
        Opacity over one unit distance: a number, or numbers evenly over the range, or pairs of
        scalar and opacity; "linear" or "linear_r". Left out, it rises from 0 to 1 over the range.
    unit_distance
        The distance over which an opacity counts, world units: PyVista's
        ``opacity_unit_distance``, which is accepted, too. Left out: the bounding box's diagonal
        over the cube root of the number of cells.
    transfer_function
        Knots, in place of the four above; see :class:`TransferFunction`.
    optical_model
        "emission-absorption" (the default), "emission", "absorption", "maximum-intensity" or
        "isosurfaces".
    isovalues
        Scalars of isosurfaces, or a dictionary from these to linear RGB.
    clip
        What stays: the side to which the normal points of a plane ``(point, normal)``, or of
        each in a list, or a box (xmin, xmax, ymin, ymax, zmin, zmax). World units.
    depth_cue
        How much light the farthest point loses, 0 to 1.
    ambient, lights
        Of surfaces: the share of color without light, and pairs ``(toward, color)``.
    """

    cmap: Any
    colormap: Any
    range: Any
    clim: Any
    opacity: Any
    unit_distance: float | None
    opacity_unit_distance: float | None
    optical_model: str | None
    isovalues: Any
    clip: Any
    depth_cue: float | None
    ambient: float | None
    lights: Any


class LookOptions(ColorOptions, total=False):
    """All of :class:`ColorOptions`, and the transfer function."""

    transfer_function: Any


class FrameOptions(TypedDict, total=False):
    """From where, how large and before what.

    camera
        A side from which the whole volume is seen ("+x", "-x", "+y", "-y", "+z", "-z", "+iso",
        "-iso"), a :class:`Camera`, a dictionary of its parts, a camera of VTK or PyVista, or
        ``[position, focal_point, view_up]``.
    position, focal_point, view_up, view_angle, parallel_scale, fit, orthographic
        The parts of a camera by themselves; see :class:`Camera`.
    size
        Width and height in pixels, or one for both; 512 unless given.
    background
        "transparent", "white", "black", "#rrggbb" (sRGB), or linear RGB or RGBA with straight
        alpha. Transparent unless given; black for models that only add light.
    """

    position: Any
    focal_point: Any
    view_up: Any
    view_angle: float | None
    parallel_scale: float | None
    fit: str | None
    orthographic: bool | None
    size: Any
    background: Any


class ViewOptions(FrameOptions, total=False):
    """All of :class:`FrameOptions`, and the camera."""

    camera: Any


class SceneOptions(VolumeOptions, LookOptions, ViewOptions, total=False):
    """All of :class:`VolumeOptions`, :class:`LookOptions` and :class:`ViewOptions`."""


class MethodOptions(TypedDict, total=False):
    """What draws.

    algorithm
        A name of :func:`algorithms`; "raycast-cpu", exact and on the CPU, unless given.
    settings
        A dictionary of the algorithm's settings, or "name=value,name=value".
    """

    algorithm: str
    settings: Mapping[str, Any] | str | None


class RenderOptions(SceneOptions, MethodOptions, total=False):
    """All parameters of :func:`render` and :class:`Renderer` beside the volume."""


VOLUME = tuple(VolumeOptions.__annotations__)
LOOK = tuple(LookOptions.__annotations__)
VIEW = tuple(ViewOptions.__annotations__)
METHOD = tuple(MethodOptions.__annotations__)

# Names of PyVista and of scenes for what has another name here.
ALIASES = (("clim", "range"), ("opacity_unit_distance", "unit_distance"), ("colormap", "cmap"))

DEFAULT_ALGORITHM = "raycast-cpu"


def check(options: Mapping[str, Any], *groups: tuple[str, ...]) -> None:
    """Refuses a parameter that does not exist, with the one that was meant."""
    valid = [name for group in groups for name in group]
    for name in options:
        if name not in valid:
            near = native.nearest(name, valid)
            meant = f"; did you mean '{near}'?" if near else ""
            raise TypeError(f"there is no parameter '{name}'{meant}")


def part(options: Mapping[str, Any], group: tuple[str, ...]) -> dict[str, Any]:
    """The parameters of a group that are given."""
    return {name: options[name] for name in group if options.get(name) is not None}


def volume_of(source: Any, arrays_: tuple[Any, Any, Any], options: Mapping[str, Any]) -> Volume:
    """The volume that is meant, which may be one already."""
    given = part(options, VOLUME)
    if isinstance(source, Volume) and not given and all(array is None for array in arrays_):
        return source
    return Volume(source, *arrays_, **given)


def scene_of(
    volume: Volume,
    look: Mapping[str, Any],
    view: Mapping[str, Any] | None,
    like: native.Scene | None = None,
) -> native.Scene:
    """The completed scene; with the view of ``like`` in place of ``view``."""
    appearance, paint = _look(dict(look))
    written: dict[str, Any] = {"version": 1, "appearance": appearance}
    if view is not None:
        camera, written["image"] = view_of(view)
        if camera is not None:
            written["camera"] = camera
    return native.resolve(volume._native, json.dumps(written), like, **paint)


def view_of(view: Mapping[str, Any]) -> tuple[dict[str, Any] | None, dict[str, Any]]:
    """Camera, if there is any, and image of a scene."""
    parts = {name: view[name] for name in _camera.NAMES if view.get(name) is not None}
    camera = view.get("camera")
    if camera is not None and parts:
        raise error(f"camera excludes {' and '.join(parts)}", "keep one of the two ways")
    written: dict[str, Any] | None = None
    if camera is not None:
        written = _camera.camera_of(camera)._json()
    elif parts:
        written = _camera.Camera(**parts)._json()
    image: dict[str, Any] = {}
    if view.get("size") is not None:
        image["width"], image["height"] = _camera.size_of(view["size"])
    if view.get("background") is not None:
        image["background"] = _camera.background_of(view["background"])
    return written, image


def _look(look: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """An appearance as a scene has it, and what no scene holds."""
    for alias, name in ALIASES:
        if look.get(alias) is not None:
            if look.get(name) is not None:
                raise error(f"{alias} and {name} are the same", "give one of them")
            look[name] = look[alias]
    written: dict[str, Any] = {}
    paint: dict[str, Any] = {}
    if look.get("transfer_function") is not None:
        both = [k for k in ("cmap", "range", "opacity", "unit_distance") if look.get(k) is not None]
        if both:
            raise error(
                f"transfer_function excludes {' and '.join(both)}", "keep one of the two ways"
            )
        given = look["transfer_function"]
        if not isinstance(given, _transfer_function.TransferFunction):
            given = _transfer_function.TransferFunction(given)
        written["transfer_function"] = given._json()
    if look.get("cmap") is not None:
        ours, table = _transfer_function.colors_of(look["cmap"])
        if ours is not None:
            written["colormap"] = ours
        if table is not None:
            paint["colors"] = arrays.plain(table[:, :3], np.float64)
            if table.shape[1] == 4 and look.get("opacity") is None and (table[:, 3] < 1.0).any():
                paint["opacities"] = [float(alpha) for alpha in table[:, 3]]
    if look.get("opacity") is not None:
        paint["opacities"], paint["scalars"] = _transfer_function.opacities_of(look["opacity"])
    if look.get("range") is not None:
        written["range"] = arrays.vector("range", look["range"], 2)
    for name in ("unit_distance", "depth_cue", "ambient"):
        if look.get(name) is not None:
            written[name] = arrays.number(name, look[name])
    model = look.get("optical_model")
    if model is None and look.get("isovalues") is not None:
        model = "isosurfaces"
    if model is not None:
        models = json.loads(native.names(False))["optical_models"]
        if model not in models:
            raise unknown("optical model", model, models)
        written["optical_model"] = model
    if look.get("isovalues") is not None:
        written["isosurfaces"] = _isosurfaces(look["isovalues"])
    if look.get("clip") is not None:
        written["clip_planes"] = _planes(look["clip"])
    if look.get("lights") is not None:
        written["lights"] = [_light(light) for light in _listed("lights", look["lights"])]
    return written, paint


def _listed(what: str, given: Any) -> list[Any]:
    try:
        return list(given)
    except TypeError:
        raise error(f"{what} must be a list, not {given!r:.40}") from None


def _isosurfaces(given: Any) -> list[dict[str, Any]]:
    if isinstance(given, Mapping):
        return [
            {
                "value": arrays.number("an isovalue", value),
                "color": arrays.vector("an isosurface's color", color),
            }
            for value, color in given.items()
        ]
    values = arrays.numbers("isovalues", given).reshape(-1)
    return [{"value": arrays.number("an isovalue", value)} for value in values]


def _light(given: Any) -> dict[str, Any]:
    if isinstance(given, Mapping):
        given = given.get("toward"), given.get("color", (1.0, 1.0, 1.0))
    try:
        toward, color = given
    except (TypeError, ValueError):
        raise error("a light must be a direction and a color") from None
    return {
        "toward": arrays.vector("a light's direction", toward),
        "color": arrays.vector("a light's color", color),
    }


def _planes(given: Any) -> list[dict[str, Any]]:
    if isinstance(given, Mapping):
        given = [given]
    listed = _listed("clip", given)
    if len(listed) == 6 and all(np.ndim(part) == 0 for part in listed):
        x0, x1, y0, y1, z0, z1 = arrays.vector("clip", listed, 6)
        low, high = [x0, y0, z0], [x1, y1, z1]
        unit = np.eye(3).tolist()
        planes = [{"point": low, "normal": axis} for axis in unit]
        return planes + [{"point": high, "normal": [-x for x in axis]} for axis in unit]
    if len(listed) == 2 and all(np.shape(part) == (3,) for part in listed):
        listed = [listed]
    return [_plane(plane) for plane in listed]


def _plane(given: Any) -> dict[str, Any]:
    if isinstance(given, Mapping):
        given = given.get("point"), given.get("normal")
    try:
        point, normal = given
    except (TypeError, ValueError):
        raise error("a clip plane must be a point and a normal") from None
    return {
        "point": arrays.vector("a clip plane's point", point),
        "normal": arrays.vector("a clip plane's normal", normal),
    }


def settings_of(settings: Any) -> list[str]:
    """Settings as the library reads them."""
    if settings is None:
        return []
    if isinstance(settings, str):
        return [pair for pair in settings.split(",") if pair]
    if not isinstance(settings, Mapping):
        raise error("settings must be a dictionary of names and values")
    return [f"{str(name).replace('_', '-')}={value}" for name, value in settings.items()]
