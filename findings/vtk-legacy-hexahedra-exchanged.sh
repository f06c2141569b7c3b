#!/usr/bin/env bash
# VTK reads a Lagrange hexahedron otherwise than it wrote it, where a legacy file of version 4.2 was asked for.
#
# Guess:    vtkUnstructuredGridReader gives back the points of a cell that vtkUnstructuredGridWriter wrote, whatever file version
#           was set. The node order of Lagrange hexahedra changed with VTK 9, and the reader exchanges the nodes of two edges in files
#           before 5.1.
# Behavior: the writer writes the order of VTK 9 under the number 4.2, so that the reader exchanges nodes that are right already: those
#           of the edges from corner 2 to 6 and from 3 to 7. With version 5.1 all stay. The cell is folded, without a warning.
# Seen:     VTK 9.7.2 from the Python index.
# Output:   5.1: nodes 24 to 31 come back as [24, 25, 26, 27, 28, 29, 30, 31]
#           4.2: nodes 24 to 31 come back as [24, 25, 26, 27, 30, 31, 28, 29]
#
# Fails if this changes.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet vtk==9.7.2

"$folder/venv/bin/python" - <<'PYTHON'
import vtk

grid, ids, points = vtk.vtkUnstructuredGrid(), vtk.vtkIdList(), vtk.vtkPoints()
vtk.vtkHigherOrderInterpolation.AppendHexahedronCollocationPoints(points, [3, 3, 3])
for node in range(points.GetNumberOfPoints()):
    ids.InsertNextId(node)
grid.SetPoints(points)
grid.InsertNextCell(vtk.VTK_LAGRANGE_HEXAHEDRON, ids)

expected = {51: [24, 25, 26, 27, 28, 29, 30, 31], 42: [24, 25, 26, 27, 30, 31, 28, 29]}
for version, nodes in expected.items():
    writer = vtk.vtkUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetFileVersion(version)
    writer.WriteToOutputStringOn()
    writer.Update()
    reader = vtk.vtkUnstructuredGridReader()
    reader.ReadFromInputStringOn()
    reader.SetInputString(writer.GetOutputString())
    reader.Update()
    back = [reader.GetOutput().GetCell(0).GetPointId(node) for node in range(24, 32)]
    print(f"{version // 10}.{version % 10}: nodes 24 to 31 come back as {back}")
    assert back == nodes
PYTHON
