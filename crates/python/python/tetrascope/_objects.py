"""Meshes and grids of PyVista, VTK and meshio, by what their objects can do; none is imported.

Each becomes a :class:`Mesh` or a :class:`Grid` of arrays, without a copy where the object hands
out its memory.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import _cells as cells
from ._arrays import Array, numbers
from ._errors import error, unknown

Fields = dict[str, Any]


@dataclass
class Mesh:
    points: Any
    cells: Any
    celltypes: Any
    offsets: Any = None
    point_data: Fields = field(default_factory=dict)
    cell_data: Fields = field(default_factory=dict)
    active: str | None = None


@dataclass
class Grid:
    dims: tuple[int, int, int]  # of points
    spacing: Any
    origin: Any
    direction: Any
    point_data: Fields = field(default_factory=dict)
    cell_data: Fields = field(default_factory=dict)
    active: str | None = None


def read(given: Any) -> Mesh | Grid | None:
    """What an object holds; ``None`` if it is none that is known."""
    if hasattr(given, "GetClassName") and hasattr(given, "IsA"):
        return _vtk(given)
    if hasattr(given, "points") and hasattr(given, "cells_dict"):
        return _meshio(given)
    if hasattr(given, "points") and hasattr(given, "celltypes"):
        return _pyvista_mesh(given)
    if all(hasattr(given, name) for name in ("dimensions", "spacing", "origin", "point_data")):
        return _pyvista_grid(given)
    return None


def choose(source: Mesh | Grid, name: str | None) -> tuple[str, str, Array]:
    """The name, association and values of the field called ``name``, or of a good first one.

    A name is an array's; ``point:NAME`` and ``cell:NAME`` tell two of one name apart, and
    ``NAME-0`` or ``NAME-x`` is a component.
    """
    every = [("point", key) for key in source.point_data] + [("cell", key) for key in source.cell_data]
    if not every:
        raise error("the object has no point or cell data", "give `scalars`")
    if name is None:
        name = source.active if source.active in [key for _, key in every] else None
        if name is None:
            usable = [(a, key) for a, key in every if _is_numbers(_data(source, a)[key])]
            if not usable:
                raise error("the object has no field of numbers")
            wide = [(a, key) for a, key in usable if _is_wide(_data(source, a)[key])]
            association, key = (wide or usable)[0]
            return key, association, numbers(key, _data(source, association)[key])
    wanted = str(name)
    associations: tuple[str, ...] = ("point", "cell")
    if wanted not in (key for _, key in every):
        for association in associations:
            if wanted.startswith(association + ":"):
                wanted, associations = wanted[len(association) + 1 :], (association,)
    for association in associations:
        data = _data(source, association)
        if wanted in data:
            return wanted, association, numbers(wanted, data[wanted])
        whole, dash, part = wanted.rpartition("-")
        if dash and whole in data:
            values = numbers(whole, data[whole])
            index = {"x": 0, "y": 1, "z": 2}.get(part, int(part) if part.isdigit() else -1)
            if part == "magnitude":
                return wanted, association, values
            if values.ndim == 2 and 0 <= index < values.shape[1]:
                return wanted, association, values[:, index]
    raise unknown("field", name, (key for _, key in every))


def _data(source: Mesh | Grid, association: str) -> Fields:
    return source.point_data if association == "point" else source.cell_data


def _is_numbers(values: Any) -> bool:
    array = np.asarray(values)
    return array.dtype.kind in "biuf" and array.ndim in (1, 2)


def _is_wide(values: Any) -> bool:
    array = np.asarray(values)
    return array.ndim == 1 and array.size > 0 and not bool((array == array[0]).all())


def _copied(data: Any) -> Fields:
    """A mapping of names to arrays."""
    if data is None:
        return {}
    return {str(key): data[key] for key in data.keys()}


# PyVista, and what looks like it.


def _pyvista_mesh(given: Any) -> Mesh:
    connectivity = getattr(given, "cell_connectivity", None)
    offsets = getattr(given, "offset", None) if connectivity is not None else None
    return Mesh(
        points=given.points,
        cells=given.cells if offsets is None else connectivity,
        celltypes=given.celltypes,
        offsets=offsets,
        point_data=_copied(getattr(given, "point_data", None)),
        cell_data=_copied(getattr(given, "cell_data", None)),
        active=getattr(given, "active_scalars_name", None),
    )


def _pyvista_grid(given: Any) -> Grid:
    return Grid(
        dims=_dims(given.dimensions),
        spacing=given.spacing,
        origin=given.origin,
        direction=getattr(given, "direction_matrix", None),
        point_data=_copied(given.point_data),
        cell_data=_copied(getattr(given, "cell_data", None)),
        active=getattr(given, "active_scalars_name", None),
    )


def _dims(given: Any) -> tuple[int, int, int]:
    x, y, z = (int(n) for n in given)
    return x, y, z


# meshio


def _meshio(given: Any) -> Mesh:
    blocks: list[tuple[int, Array]] = []
    kept: list[int] = []
    for index, block in enumerate(given.cells):
        data = numbers("cells", block.data)
        if data.ndim == 2:
            blocks.append((cells.number(block.type), data))
            kept.append(index)
    if not blocks:
        raise error("the mesh has no cells with a fixed number of points")
    cell_data = {
        str(key): np.concatenate([np.asarray(arrays[index]) for index in kept])
        for key, arrays in dict(given.cell_data).items()
    }
    types, offsets, connectivity = cells.together(blocks)
    points = numbers("points", given.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    return Mesh(
        points=points,
        cells=connectivity,
        celltypes=types,
        offsets=offsets,
        point_data=_copied(given.point_data),
        cell_data=cell_data,
    )


# VTK


def _vtk(given: Any) -> Mesh | Grid:
    if given.IsA("vtkUnstructuredGrid"):
        array = given.GetCells()
        return Mesh(
            points=_vtk_points(given),
            cells=_vtk_array(array.GetConnectivityArray()),
            celltypes=_vtk_types(given),
            offsets=_vtk_array(array.GetOffsetsArray()),
            **_vtk_data(given),
        )
    if given.IsA("vtkImageData"):
        matrix = given.GetDirectionMatrix() if hasattr(given, "GetDirectionMatrix") else None
        direction = matrix and [[matrix.GetElement(i, j) for j in range(3)] for i in range(3)]
        # The origin is that of the point (0, 0, 0), which an extent may leave out.
        first = [given.GetExtent()[2 * axis] for axis in range(3)]
        turn = np.eye(3) if direction is None else np.asarray(direction)
        origin = np.asarray(given.GetOrigin()) + turn @ (np.asarray(given.GetSpacing()) * first)
        return Grid(
            dims=_dims(given.GetDimensions()),
            spacing=given.GetSpacing(),
            origin=origin,
            direction=direction,
            **_vtk_data(given),
        )
    if given.IsA("vtkStructuredGrid") or given.IsA("vtkRectilinearGrid"):
        extent = given.GetExtent()
        dims = _dims(extent[2 * axis + 1] - extent[2 * axis] + 1 for axis in range(3))
        if given.IsA("vtkStructuredGrid"):
            points = _vtk_points(given)
        else:
            axes = [_vtk_array(getattr(given, f"Get{axis}Coordinates")()) for axis in "XYZ"]
            z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
            points = np.column_stack([x.reshape(-1), y.reshape(-1), z.reshape(-1)])
        hexahedra = cells.hexahedra(dims)
        types, offsets, connectivity = cells.together([(12, hexahedra)])
        return Mesh(points, connectivity, types, offsets, **_vtk_data(given))
    name = given.GetClassName()
    if given.IsA("vtkCompositeDataSet"):
        raise error(f"a {name} holds several data sets", "give one of its blocks, or combine them")
    raise error(
        f"a {name} has no volume cells",
        "give an unstructured, structured or rectilinear grid, or image data",
    )


def _vtk_points(given: Any) -> Array:
    points = given.GetPoints()
    if points is None:
        return np.zeros((0, 3))
    return _vtk_array(points.GetData())


def _vtk_types(given: Any) -> Array:
    # Which of both there is depends on VTK's version.
    for name in ("GetCellTypes", "GetCellTypesArray"):
        try:
            array = getattr(given, name)()
        except (AttributeError, TypeError):
            continue
        if array is not None and hasattr(array, "GetNumberOfTuples"):
            types = _vtk_array(array)
            if len(types) == given.GetNumberOfCells():
                return types
    return np.fromiter(
        (given.GetCellType(cell) for cell in range(given.GetNumberOfCells())), np.uint8
    )


def _vtk_data(given: Any) -> dict[str, Any]:
    found: dict[str, Any] = {"active": None}
    for key, data in (("point_data", given.GetPointData()), ("cell_data", given.GetCellData())):
        fields: Fields = {}
        for index in range(data.GetNumberOfArrays()):
            array = data.GetArray(index)
            if array is not None and array.GetName() != "vtkGhostType":
                fields[array.GetName() or f"array {index}"] = _vtk_array(array)
        found[key] = fields
        active = data.GetScalars()
        if active is not None and found["active"] is None:
            found["active"] = active.GetName()
    return found


def _vtk_array(array: Any) -> Array:
    """The values of a ``vtkDataArray``, a row for each tuple; its own memory where it has any."""
    count, width = array.GetNumberOfTuples(), array.GetNumberOfComponents()
    try:
        values = np.asarray(memoryview(array))
    except (TypeError, ValueError, BufferError):
        # An array that is computed, or kept in parts: VTK's own conversion knows it.
        support = sys.modules.get("vtkmodules.util.numpy_support")
        if support is None:
            import importlib

            support = importlib.import_module("vtkmodules.util.numpy_support")
        values = support.vtk_to_numpy(array)
    return values.reshape((count, width) if width != 1 else (count,))


def is_mapping(given: Any) -> bool:
    """Whether cells are given by their types."""
    return isinstance(given, Mapping)
