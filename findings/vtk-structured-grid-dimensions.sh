#!/usr/bin/env bash
# In Python, vtkStructuredGrid.GetDimensions() wants a list to fill, and those of its relatives return a tuple.
#
# Guess:    GetDimensions() without arguments gives the dimensions of any structured data set, as that of vtkImageData does.
# Behavior: vtkImageData and vtkRectilinearGrid return a tuple; vtkStructuredGrid raises TypeError and fills an argument. Code that
#           takes all three asks for GetExtent(), which returns a tuple everywhere.
# Seen:     VTK 9.7.2 from the Python index.
# Output:   vtkImageData (2, 3, 4)
#           vtkRectilinearGrid (2, 3, 4)
#           vtkStructuredGrid TypeError; filled [2, 3, 4]; extent (0, 1, 0, 2, 0, 3)
#
# Fails if this changes.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet vtk==9.7.2

"$folder/venv/bin/python" - <<'PYTHON'
import vtk

for kind in (vtk.vtkImageData, vtk.vtkRectilinearGrid):
    data = kind()
    data.SetDimensions(2, 3, 4)
    print(kind.__name__, data.GetDimensions())
    assert data.GetDimensions() == (2, 3, 4)

grid = vtk.vtkStructuredGrid()
grid.SetDimensions(2, 3, 4)
try:
    grid.GetDimensions()
except TypeError:
    pass
else:
    raise SystemExit("vtkStructuredGrid.GetDimensions() takes no argument now")
filled = [0, 0, 0]
grid.GetDimensions(filled)
assert filled == [2, 3, 4] and grid.GetExtent() == (0, 1, 0, 2, 0, 3)
print("vtkStructuredGrid TypeError; filled", filled, end="; ")
print("extent", grid.GetExtent())
PYTHON
