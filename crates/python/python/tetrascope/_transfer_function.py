"""From scalars to colors and opacities."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import numpy as np

from . import _arrays as arrays
from . import _tetrascope as native
from ._arrays import Array
from ._errors import error, unknown


class TransferFunction:
    """Color and extinction as piecewise-linear functions of the scalar.

    ``knots`` is a sequence of ``(scalar, (r, g, b), extinction)``: the scalar in the field's unit,
    linear RGB (usually from 0 to 1), and extinction per world unit, 0 or more. Scalars do not
    decrease; two knots at one scalar make a step. Beyond the ends all is constant.

    An opacity α that counts over a unit distance D is the extinction −ln(1 − α) / D.
    """

    def __init__(self, knots: Iterable[Any]) -> None:
        made: list[tuple[float, tuple[float, float, float], float]] = []
        try:
            listed = list(knots)
        except TypeError:
            raise error(f"knots must be a list, not {knots!r:.40}") from None
        for index, knot in enumerate(listed):
            what = f"knot {index}"
            if isinstance(knot, dict):
                try:
                    scalar, color, extinction = knot["scalar"], knot["color"], knot["extinction"]
                except KeyError as key:
                    raise error(f"{what} has no {key}") from None
            else:
                try:
                    scalar, color, extinction = knot
                except (TypeError, ValueError):
                    raise error(f"{what} must be a scalar, a color and an extinction") from None
            r, g, b = arrays.vector(f"the color of {what}", color)
            made.append(
                (
                    arrays.number(f"the scalar of {what}", scalar),
                    (r, g, b),
                    arrays.number(f"the extinction of {what}", extinction),
                )
            )
        self._knots = tuple(made)

    @property
    def knots(self) -> tuple[tuple[float, tuple[float, float, float], float], ...]:
        """``(scalar, (r, g, b), extinction)`` each: linear RGB, per world unit."""
        return self._knots

    @property
    def range(self) -> tuple[float, float]:
        """The scalars of the first and last knot."""
        if not self._knots:
            raise error("a transfer function needs at least one knot")
        return self._knots[0][0], self._knots[-1][0]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, TransferFunction) and self._knots == other._knots

    def __hash__(self) -> int:
        return hash(self._knots)

    def __repr__(self) -> str:
        return f"TransferFunction({list(self._knots)!r})"

    def _json(self) -> list[dict[str, Any]]:
        return [
            {"scalar": scalar, "color": list(color), "extinction": extinction}
            for scalar, color, extinction in self._knots
        ]


def of_scene(scene: native.Scene) -> TransferFunction:
    """The transfer function of a completed scene."""
    return TransferFunction(json.loads(scene.to_json())["appearance"]["transfer_function"])


def builtin() -> list[str]:
    """The color maps that need no other package."""
    names: list[str] = json.loads(native.names(False))["colormaps"]
    return names


def colors_of(cmap: Any) -> tuple[str | None, Array | None]:
    """The name of a color map of ours, or a table of sRGB (n, 3 or 4) from 0 to 1."""
    if isinstance(cmap, str):
        ours = builtin()
        if cmap in ours:
            return cmap, None
        found = _matplotlib(cmap)
        if found is None:
            raise unknown("color map", cmap, ours)
        cmap = found
    if callable(cmap):
        try:
            table = np.asarray(cmap(np.linspace(0.0, 1.0, 256)), dtype=np.float64)
        except (TypeError, ValueError) as problem:
            raise error(f"the color map cannot be called with numbers: {problem}") from None
    else:
        if hasattr(cmap, "colors"):
            cmap = cmap.colors
        table = arrays.numbers("the color map", cmap)
        # Bytes, as images have them.
        table = table / 255.0 if table.dtype == np.uint8 else table.astype(np.float64)
    if table.ndim != 2 or table.shape[1] not in (3, 4) or len(table) < 1:
        raise error(
            f"a color map must be colors of 3 or 4 channels, not {arrays.shape(table)}",
            "give an array (n, 3) or (n, 4), a name, or a color map of matplotlib",
        )
    if not ((table >= 0.0) & (table <= 1.0)).all():
        raise error("a color map has a channel that is not from 0 to 1")
    if len(table) > 4096:
        raise error(f"a color map of {len(table)} colors", "give at most 4096")
    return None, table


def _matplotlib(name: str) -> Any:
    """A color map of matplotlib, where that is installed."""
    try:
        import matplotlib  # type: ignore[import-not-found, unused-ignore]
    except ImportError:
        return None
    return matplotlib.colormaps.get(name)


def opacities_of(opacity: Any) -> tuple[list[float] | None, list[float] | None]:
    """Opacities, and their scalars unless they are evenly over the range."""
    if opacity is None:
        return None, None
    if isinstance(opacity, str):
        shapes = {"linear": [0.0, 1.0], "linear_r": [1.0, 0.0]}
        if opacity not in shapes:
            raise unknown("opacity", opacity, shapes)
        return shapes[opacity], None
    array = arrays.numbers("opacity", opacity)
    # Bytes, as PyVista takes them.
    values = array / 255.0 if array.dtype == np.uint8 else array.astype(np.float64)
    if not np.isfinite(values).all() or values.size == 0 or values.size > 8192:
        raise error("opacity must be some finite numbers, at most 4096")
    if values.ndim == 0:
        return [float(values)], None
    if values.ndim == 1:
        return [float(value) for value in values], None
    if values.ndim == 2 and values.shape[1] == 2:
        return [float(v) for v in values[:, 1]], [float(v) for v in values[:, 0]]
    raise error(
        f"opacity must be a number, numbers, or pairs of scalar and opacity, not {arrays.shape(values)}"
    )
