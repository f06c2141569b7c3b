#!/usr/bin/env bash
# VTK's vtkCellSizeFilter gives a polyhedron that is not convex too large a volume.
#
# Guess:    the volume of a polyhedron is what its faces enclose, as for a mesh of the cells that it is made of.
# Behavior: a prism over an L of three unit squares, whose faces are flat and close it, is said to have more than 3;
#           a prism over a unit square has its 1.
# Seen:     VTK 9.7.2 from the Python index.
# Output:   a cube: 1.000 (is 1), an L: 3.500 (is 3)
#
# Fails if the cube's volume is wrong, or that of the L is right.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet vtk==9.7.2

"$folder/venv/bin/python" - <<'PYTHON'
import vtk


def volume(outline):
    """That of a prism of height 1 over an outline, listed counterclockwise, as one polyhedron."""
    n = len(outline)
    points = vtk.vtkPoints()
    for z in (0.0, 1.0):
        for x, y in outline:
            points.InsertNextPoint(x, y, z)
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    faces = [list(reversed(range(n))), list(range(n, 2 * n)), *sides]
    stream = vtk.vtkIdList()
    stream.InsertNextId(len(faces))
    for face in faces:
        stream.InsertNextId(len(face))
        for point in face:
            stream.InsertNextId(point)
    grid = vtk.vtkUnstructuredGrid()
    grid.SetPoints(points)
    grid.InsertNextCell(vtk.VTK_POLYHEDRON, stream)
    size = vtk.vtkCellSizeFilter()
    size.SetInputData(grid)
    size.Update()
    return size.GetOutput().GetCellData().GetArray("Volume").GetValue(0)


cube = volume([(0, 0), (1, 0), (1, 1), (0, 1)])
ell = volume([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
print(f"a cube: {cube:.3f} (is 1), an L: {ell:.3f} (is 3)")
assert abs(cube - 1) < 1e-9, "the cube's volume is wrong"
assert abs(ell - 3) > 0.1, "the L's volume is right"
PYTHON
