"""What is drawn."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from . import _arrays as arrays
from . import _cells as cells_
from . import _objects as objects
from . import _tetrascope as native
from ._arrays import Array
from ._errors import error, unknown

INTERPOLATIONS = ("linear", "nearest")
ASSOCIATIONS = ("point", "cell")


class Volume:
    """A tetrahedral mesh or a regular grid, with the field that is drawn.

    ``Volume(points, cells, celltypes, scalars)``
        A mesh in VTK's layout. ``points`` is (n, 3), world units. ``cells`` is VTK's padded list
        (the number of a cell's points, then these), or the connectivity alone with ``offsets``
        (m + 1), or an array (m, 4), (m, 5), (m, 6) or (m, 8) of tetrahedra, pyramids, wedges or
        hexahedra, or a dictionary from cell types (VTK's numbers or meshio's names) to such
        arrays. ``celltypes`` is (m,), VTK's numbers, or one for all. ``scalars`` is (n,) for
        points or (m,) for cells; ``association`` ("point" or "cell") decides where n is m.
    ``Volume(samples, spacing=, origin=, direction=)``
        A grid: ``samples[i, j, k]`` lies at ``origin + direction @ (spacing * (i, j, k))``.
        ``direction`` is a 3×3 matrix whose columns are the axes. With ``interpolation="nearest"``
        each sample fills a cell around itself.
    ``Volume("mesh.vtu", field=, step=)``
        A file in any format of :func:`tetrascope.info`, or a data set by its name (then
        ``n_cells`` and ``seed``). ``step`` is a number from 0, or ``time`` a time; ``solution`` is
        the file of a Plot3D solution; ``dims``, ``type``, ``offset`` and ``byte_order`` are of
        raw files.
    ``Volume(object, field=)``
        An unstructured, structured or rectilinear grid or image data of PyVista or VTK, or a mesh
        of meshio. ``scalars`` replaces its own fields.

    Curved cells of order 2 are cut into straight ones, and ``notes`` say how far these are off;
    ``curved`` is a tolerance for that, in parts of the mesh's diagonal and of the field's range.

    NaN, infinities and masked values are no values: cells that have one are transparent. Arrays
    are copied into the mesh; nothing that happens to them later changes it.
    """

    _native: native.Volume

    def __init__(
        self,
        source: Any,
        cells: Any = None,
        celltypes: Any = None,
        scalars: Any = None,
        *,
        offsets: Any = None,
        connectivity: Any = None,
        association: str | None = None,
        field: str | None = None,
        spacing: Any = None,
        origin: Any = None,
        direction: Any = None,
        interpolation: str | None = None,
        step: int | None = None,
        time: float | None = None,
        solution: str | os.PathLike[str] | None = None,
        n_cells: int | None = None,
        seed: int | None = None,
        dims: Any = None,
        type: str | None = None,
        offset: int | None = None,
        byte_order: str | None = None,
        curved: float | None = None,
    ) -> None:
        if association is not None and association not in ASSOCIATIONS:
            raise unknown("association", association, ASSOCIATIONS)
        if interpolation is not None and interpolation not in INTERPOLATIONS:
            raise unknown("interpolation", interpolation, INTERPOLATIONS)
        of_arrays = {
            "cells": cells,
            "celltypes": celltypes,
            "offsets": offsets,
            "connectivity": connectivity,
        }
        of_files = {
            "step": step,
            "time": time,
            "solution": solution,
            "n_cells": n_cells,
            "seed": seed,
            "dims": dims,
            "type": type,
            "offset": offset,
            "byte_order": byte_order,
        }
        if isinstance(source, (str, os.PathLike)):
            of_files["curved"] = curved
        of_grids = {
            "spacing": spacing,
            "origin": origin,
            "direction": direction,
            "interpolation": interpolation,
        }
        if isinstance(source, (str, os.PathLike)):
            _refuse(of_arrays | {"scalars": scalars, "association": association}, "a file")
            _refuse({"direction": direction}, "a file")
            self._native = _load(source, field, spacing, origin, interpolation, of_files)
            return
        _refuse(of_files, "arrays and objects")
        if isinstance(source, Volume):
            _refuse(of_arrays | of_grids | {"curved": curved}, "a volume")
            self._native = source._native
            if scalars is not None:
                self._native = source._with_scalars(scalars, association, field or "scalars")
            return
        if isinstance(source, native.Volume):
            self._native = source
            return
        found = None if isinstance(source, np.ndarray) else objects.read(source)
        if isinstance(found, objects.Mesh):
            _refuse(of_arrays | of_grids, "an object with cells")
            self._native = _of_mesh(found, scalars, association, field, curved)
        elif isinstance(found, objects.Grid):
            _refuse(of_arrays | of_grids | {"curved": curved}, "an object with samples")
            self._native = _of_grid(found, scalars, association, field)
        elif cells is None and connectivity is None:
            if not hasattr(source, "__array__") and not isinstance(source, (list, tuple)):
                raise error(
                    f"a {_class(source)} is not a volume",
                    "give arrays, the path of a file, or an object of PyVista, VTK or meshio",
                )
            _refuse(of_arrays | {"scalars": scalars, "association": association, "curved": curved}, "a grid")
            nearest = interpolation == "nearest"
            self._native = _grid(source, spacing, origin, direction, nearest, field or "samples")
        else:
            _refuse(of_grids, "a mesh")
            if cells is not None and connectivity is not None:
                raise error("cells and connectivity are the same", "give one of them")
            cells = connectivity if cells is None else cells
            if scalars is None:
                raise error("a mesh needs scalars to be drawn", "give `scalars`")
            self._native = _mesh(
                source, cells, celltypes, offsets, scalars, association, field or "scalars", curved
            )

    def with_scalars(
        self, scalars: Any, association: str | None = None, name: str = "scalars"
    ) -> Volume:
        """The same geometry with other scalars (or samples of a grid); nothing else is rebuilt."""
        return Volume(self._with_scalars(scalars, association, name))

    def _with_scalars(self, scalars: Any, association: str | None, name: str) -> native.Volume:
        if self.kind == "grid":
            values, _ = arrays.samples("samples", scalars)
            dims = self._native.dims
            if dims is not None and values.shape != tuple(dims):
                expected = "×".join(map(str, dims))
                raise error(f"samples of a grid of {expected} are {arrays.shape(values)}")
            return self._native.with_scalars(_x_fastest(values), "point", name)
        values = arrays.scalars("scalars", scalars)
        association = _association(
            values, self._native.n_points, self._native.n_input_cells, association
        )
        return self._native.with_scalars(arrays.plain(values, values.dtype), association, name)

    @property
    def kind(self) -> str:
        """"mesh" or "grid"."""
        return self._native.kind

    @property
    def description(self) -> str:
        """One line: cells before and after they were split, and the field."""
        return self._native.description

    @property
    def notes(self) -> list[str]:
        """What was found out, repaired or left out, one sentence each."""
        return self._native.notes

    @property
    def fields(self) -> list[dict[str, Any]]:
        """Every scalar field: name, association, range, how many values are missing."""
        fields: list[dict[str, Any]] = json.loads(self._native.fields_json)
        return fields

    @property
    def files(self) -> list[str]:
        """The files that were read."""
        return [os.fspath(path) for path in self._native.files]

    @property
    def bounds(self) -> tuple[float, float, float, float, float, float]:
        """(xmin, xmax, ymin, ymax, zmin, zmax), world units, as VTK has them."""
        x0, x1, y0, y1, z0, z1 = self._native.bounds
        return x0, x1, y0, y1, z0, z1

    @property
    def range(self) -> tuple[float, float] | None:
        """The least and greatest finite value of the field, if there is any."""
        return self._native.range

    @property
    def n_cells(self) -> int:
        """How many tetrahedra or voxel cells are drawn."""
        return self._native.n_cells

    @property
    def n_points(self) -> int:
        """How many points or samples there are."""
        return self._native.n_points

    @property
    def dims(self) -> tuple[int, int, int] | None:
        """Samples of a grid along each axis; ``None`` for a mesh."""
        dims = self._native.dims
        return None if dims is None else (dims[0], dims[1], dims[2])

    def __repr__(self) -> str:
        return f"<tetrascope.Volume: {self.description}>"


def _class(given: Any) -> str:
    kind = given.__class__
    return f"{kind.__module__.split('.')[0]} {kind.__name__}".removeprefix("builtins ")


def _refuse(parameters: dict[str, Any], of: str) -> None:
    given = [f"`{name}`" for name, value in parameters.items() if value is not None]
    if given:
        raise error(f"{' and '.join(given)} do not go with {of}", "leave them out")


def _load(
    source: str | os.PathLike[str],
    field: str | None,
    spacing: Any,
    origin: Any,
    interpolation: str | None,
    of_files: dict[str, Any],
    previous: native.Volume | None = None,
) -> native.Volume:
    path, written = source_of(source, field, spacing, origin, interpolation, of_files)
    return native.load(path, json.dumps(written), previous)


def source_of(
    source: str | os.PathLike[str],
    field: str | None = None,
    spacing: Any = None,
    origin: Any = None,
    interpolation: str | None = None,
    of_files: dict[str, Any] | None = None,
) -> tuple[str | None, dict[str, Any]]:
    """A file's path, and the rest of a scene's table `volume`."""
    written: dict[str, Any] = {}
    path: str | None = os.fsdecode(source)
    if not path:
        raise error("a path without a character is not a file")
    sets = [found["name"] for found in json.loads(native.names(False))["datasets"]]
    if path in sets and not os.path.exists(path):
        path, written["dataset"] = None, path
    elif isinstance(source, str) and not os.path.exists(source) and _is_word(source):
        near = native.nearest(source, sets)
        help = f"did you mean '{near}'?" if near else f"data sets: {', '.join(sets)}"
        raise error(f"'{source}' is neither a file nor a data set", help)
    if field is not None:
        written["field"] = str(field)
    for name, value in (("spacing", spacing), ("origin", origin)):
        if value is not None:
            written[name] = arrays.vector(name, value)
    if interpolation is not None:
        written["interpolation"] = interpolation
    for name, value in (of_files or {}).items():
        if value is None:
            continue
        if name in ("step", "n_cells", "seed", "offset"):
            written["cells" if name == "n_cells" else name] = arrays.count(name, value)
        elif name in ("time", "curved"):
            written[name] = arrays.number(name, value)
        elif name == "dims":
            dims = arrays.indices(name, value)
            if dims.shape != (3,) or (dims < 0).any():
                raise error("dims must be three whole numbers from 0 on")
            written[name] = [int(n) for n in dims]
        elif name == "solution":
            written[name] = os.fsdecode(value)
        else:
            written[name] = str(value)
    return path, written


def _is_word(name: str) -> bool:
    return os.path.basename(name) == name and not os.path.splitext(name)[1]


def _x_fastest(samples: Array) -> Array:
    """Samples in the order in which grids keep them, without a copy of what is in it."""
    return arrays.plain(samples.reshape(-1, order="F"), samples.dtype)


def _grid(
    samples: Any,
    spacing: Any,
    origin: Any,
    direction: Any,
    nearest: bool,
    name: str,
) -> native.Volume:
    values, notes = arrays.samples("a grid's samples", samples)
    if direction is None:
        rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    else:
        matrix = arrays.numbers("direction", direction)
        if matrix.shape == (9,):
            matrix = matrix.reshape(3, 3)
        if matrix.shape != (3, 3):
            raise error(f"direction must be a matrix of 3×3, not {arrays.shape(matrix)}")
        rows = [[float(number) for number in row] for row in matrix]
    apart = [1.0] * 3 if spacing is None else _spacing(spacing)
    first = [0.0] * 3 if origin is None else arrays.vector("origin", origin)
    nx, ny, nz = values.shape
    return native.grid(
        _x_fastest(values), [nx, ny, nz], apart, first, rows, nearest, str(name), notes
    )


def _spacing(given: Any) -> list[float]:
    """One number for all axes, or three."""
    array = arrays.numbers("spacing", given)
    return [arrays.number("spacing", given)] * 3 if array.ndim == 0 else arrays.vector("spacing", given)


def _points(given: Any) -> Array:
    points = arrays.reals("points", given)
    if points.ndim != 2 or points.shape[1] != 3:
        raise error(f"points must be three coordinates each, (n, 3), not {arrays.shape(points)}")
    return points


def _association(values: Array, points: int, cells: int, given: str | None) -> str:
    if given is not None:
        return given
    if len(values) not in (points, cells):
        raise error(f"{len(values)} scalars for {points} points and {cells} cells")
    return "point" if len(values) == points else "cell"


def _mesh(
    points: Any,
    cells: Any,
    celltypes: Any,
    offsets: Any,
    scalars: Any,
    association: str | None,
    name: str,
    curved: Any,
) -> native.Volume:
    places = _points(points)
    values = arrays.scalars("scalars", scalars)
    width: int | None = None
    kinds: Any
    if objects.is_mapping(cells):
        if celltypes is not None or offsets is not None:
            raise error("cells by their types need neither celltypes nor offsets", "leave them out")
        blocks = []
        for kind, block in cells.items():
            rows = arrays.indices(f"cells of type {kind}", block)
            if rows.ndim != 2:
                raise error(f"cells of type {kind} must be a row each, not {arrays.shape(rows)}")
            blocks.append((cells_.number(kind), rows))
        if not blocks:
            raise error("a mesh needs cells")
        if len(blocks) == 1:
            kinds, connectivity = blocks[0]
            width, count = connectivity.shape[1], len(connectivity)
        else:
            kinds, offsets, connectivity = cells_.together(blocks)
            count = len(kinds)
    else:
        connectivity = arrays.indices("cells", cells)
        if connectivity.ndim == 2:
            if offsets is not None:
                raise error("cells with a row each need no offsets", "leave them out")
            kinds, width = _kind_of_rows(connectivity, celltypes), connectivity.shape[1]
            count = len(connectivity)
            if not isinstance(kinds, int):  # a type for each row
                offsets = np.arange(count + 1, dtype=np.int64) * width
        elif connectivity.ndim != 1:
            raise error(f"cells must have one axis or two, not {arrays.shape(connectivity)}")
        else:
            if celltypes is None:
                raise error("cells in a list need celltypes", "give VTK's number of each cell's type")
            kinds = arrays.numbers("celltypes", celltypes) if not isinstance(celltypes, str) else None
            if kinds is None or kinds.ndim == 0:  # one for all
                kinds = np.full(_count(connectivity, offsets), cells_.number(celltypes), np.uint8)
            else:
                kinds = arrays.small("celltypes", kinds)
            count = len(kinds)
    if offsets is not None:
        offsets = arrays.indices("offsets", offsets).reshape(-1)
    return native.mesh(
        places.reshape(-1),
        connectivity.reshape(-1),
        kinds,
        offsets,
        width,
        arrays.plain(values, values.dtype),
        _association(values, len(places), count, association),
        str(name),
        None if curved is None else arrays.number("curved", curved),
    )


def _kind_of_rows(rows: Array, celltypes: Any) -> Any:
    """The type of all rows, or of each."""
    if celltypes is None:
        kind = cells_.BY_POINTS.get(rows.shape[1])
        if kind is None:
            raise error(f"cells of {rows.shape[1]} points need celltypes", "give VTK's number of their type")
        return kind
    if isinstance(celltypes, str) or np.ndim(celltypes) == 0:
        return cells_.number(celltypes)
    kinds = arrays.small("celltypes", celltypes)
    if len(kinds) != len(rows):
        raise error(f"{len(rows)} cells have {len(kinds)} types", "give one type for each cell")
    if len(kinds) and (kinds == kinds[0]).all():
        return int(kinds[0])
    return kinds


def _count(connectivity: Array, offsets: Any) -> int:
    """How many cells there are, where one type is given for all."""
    if offsets is not None:
        return max(arrays.indices("offsets", offsets).size - 1, 0)
    width = int(connectivity[0]) + 1 if connectivity.size else 1
    if width < 1 or connectivity.size % width:
        raise error("one type of cells has one number of points", "give a type for each cell")
    return int(connectivity.size // width)


def _of_mesh(
    found: objects.Mesh, scalars: Any, association: str | None, field: str | None, curved: Any
) -> native.Volume:
    if scalars is None:
        field, association, scalars = objects.choose(found, field)
    return _mesh(
        found.points,
        found.cells,
        found.celltypes,
        found.offsets,
        scalars,
        association,
        field or "scalars",
        curved,
    )


def _of_grid(
    found: objects.Grid, scalars: Any, association: str | None, field: str | None
) -> native.Volume:
    dims = found.dims
    points = dims[0] * dims[1] * dims[2]
    between = (max(dims[0] - 1, 1), max(dims[1] - 1, 1), max(dims[2] - 1, 1))
    cells = between[0] * between[1] * between[2]
    if scalars is None:
        field, association, scalars = objects.choose(found, field)
    values = arrays.numbers("scalars", scalars)
    if values.ndim == 3:
        values = values.reshape(-1, order="F")
    elif values.ndim == 2:
        values = arrays.scalars("scalars", values)
    association = _association(values, points, cells, association)
    origin, spacing = np.asarray(found.origin, float), np.asarray(found.spacing, float)
    if association == "cell":
        # Samples at the centers of cells, which they fill.
        dims = between
        turn = np.eye(3) if found.direction is None else np.asarray(found.direction, float)
        origin = origin + turn.reshape(3, 3) @ (spacing / 2)
    if values.shape != (dims[0] * dims[1] * dims[2],):
        raise error(f"{values.size} scalars for {points} points and {cells} cells")
    values = values.reshape(dims, order="F")
    return _grid(
        values, spacing, origin, found.direction, association == "cell", field or "scalars"
    )
