#!/usr/bin/env bash
# VTK's legacy writer leaves out the orders of Lagrange hexahedra and the weights of Bézier cells, without a word.
#
# Guess:    vtkUnstructuredGridWriter writes the array that SetHigherOrderDegrees() or SetRationalWeights() made an attribute, as
#           vtkXMLUnstructuredGridWriter does, and as both do with arrays that are no attributes.
# Behavior: the legacy file has CELL_DATA and POINT_DATA with nothing behind them. A hexahedron of the orders 1, 2 and 3 along its axes
#           cannot be told from others then. The writer reports no error.
# Seen:     VTK 9.7.2 from the Python index.
# Output:   .vtu: HigherOrderDegrees [(1.0, 2.0, 3.0)], RationalWeights 24
#           .vtk: HigherOrderDegrees None, RationalWeights None
#
# Fails if this changes.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet vtk==9.7.2

# The warnings that follow say that the orders of the cell that was read from .vtk are not known.
"$folder/venv/bin/python" - <<'PYTHON'
import vtk

grid, ids, points = vtk.vtkUnstructuredGrid(), vtk.vtkIdList(), vtk.vtkPoints()
vtk.vtkHigherOrderInterpolation.AppendHexahedronCollocationPoints(points, [1, 2, 3])
count = points.GetNumberOfPoints()
for node in range(count):
    ids.InsertNextId(node)
grid.SetPoints(points)
grid.InsertNextCell(vtk.VTK_BEZIER_HEXAHEDRON, ids)
degrees, weights = vtk.vtkDoubleArray(), vtk.vtkDoubleArray()
degrees.SetName("HigherOrderDegrees")
degrees.SetNumberOfComponents(3)
degrees.InsertNextTuple3(1, 2, 3)
weights.SetName("RationalWeights")
for _ in range(count):
    weights.InsertNextValue(0.5)
grid.GetCellData().SetHigherOrderDegrees(degrees)
grid.GetPointData().SetRationalWeights(weights)

kinds = {
    ".vtu": (vtk.vtkXMLUnstructuredGridWriter, vtk.vtkXMLUnstructuredGridReader),
    ".vtk": (vtk.vtkUnstructuredGridWriter, vtk.vtkUnstructuredGridReader),
}
for name, (writer, reader) in kinds.items():
    writer, reader = writer(), reader()
    writer.SetInputData(grid)
    writer.WriteToOutputStringOn()
    assert writer.Write() == 1 and writer.GetErrorCode() == 0
    reader.ReadFromInputStringOn()
    reader.SetInputString(writer.GetOutputString())
    reader.Update()
    back = reader.GetOutput()
    found = back.GetCellData().GetArray("HigherOrderDegrees")
    found = found and [found.GetTuple3(i) for i in range(found.GetNumberOfTuples())]
    many = back.GetPointData().GetArray("RationalWeights")
    many = many and many.GetNumberOfTuples()
    print(f"{name}: HigherOrderDegrees {found}, RationalWeights {many}")
    wanted = ([(1.0, 2.0, 3.0)], count) if name == ".vtu" else (None, None)
    assert (found, many) == wanted
PYTHON
