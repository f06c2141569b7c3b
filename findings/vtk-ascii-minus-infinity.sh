#!/usr/bin/env bash
# VTK reads the `-inf` that its own ASCII writer of .vtu files has written as +infinity, without an error.
#
# Guess:    what vtkXMLUnstructuredGridWriter writes, vtkXMLUnstructuredGridReader reads back, sign included.
# Behavior: in ASCII the file holds `-inf`, and the reader gives +inf; binary files keep the sign.
# Seen:     vtk 9.7.2 from the Python index, Linux x86-64.
# Output:   written [-inf, inf, 1.0, 2.0]
#           ascii   [inf, inf, 1.0, 2.0]
#           binary  [-inf, inf, 1.0, 2.0]
#
# Fails if this changes.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet vtk==9.7.2 numpy==2.4.6

"$folder/venv/bin/python" - "$folder" <<'PYTHON'
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

print("vtk", vtk.vtkVersion.GetVTKVersion())
written = np.array([-np.inf, np.inf, 1.0, 2.0])
points = vtk.vtkPoints()
for point in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)):
    points.InsertNextPoint(point)
grid = vtk.vtkUnstructuredGrid()
grid.SetPoints(points)
grid.InsertNextCell(vtk.VTK_TETRA, 4, (0, 1, 2, 3))
scalars = numpy_to_vtk(written, deep=1)
scalars.SetName("T")
grid.GetPointData().SetScalars(scalars)


def read_back(mode):
    path = f"{sys.argv[1]}/{mode}.vtu"
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(path)
    writer.SetInputData(grid)
    getattr(writer, f"SetDataModeTo{mode}")()
    assert writer.Write() == 1
    if mode == "Ascii":
        assert "-inf" in open(path).read()
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    assert reader.GetErrorCode() == 0
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetArray("T")).tolist()


ascii, binary = read_back("Ascii"), read_back("Binary")
print("written", written.tolist())
print("ascii  ", ascii)
print("binary ", binary)
assert binary == written.tolist()
assert ascii == [np.inf, np.inf, 1.0, 2.0]
PYTHON
