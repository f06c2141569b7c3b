#!/usr/bin/env bash
# VTK's vtkHDFWriter loses digits of a file with time steps: times have 32 bits, and coordinates of a rectilinear grid are
# written as whole numbers.
#
# Guess:    a file of several time steps holds the numbers that a file of one holds, and times as VTK has them, in 64 bits.
# Behavior: z coordinates 0.1 and 0.4 are there as written without time steps, and 0 and 0 with them, of type int64; vtkHDFReader
#           gives a grid without height. The time 0.1 is 0.10000000149011612.
# Seen:     VTK 9.7.2 from the Python index.
# Output:   one step: z [0.1 0.4] float64
#           two steps: z [0 0 0 0] int64, times [0.0, 0.10000000149011612]
#
# Fails if this changes.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet vtk==9.7.2 numpy==2.4.6 h5py==3.16.0

"$folder/venv/bin/python" - "$folder" <<'PYTHON'
import sys

import h5py
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk
from vtk.util.vtkAlgorithm import VTKPythonAlgorithmBase

AXES = [np.array(axis) for axis in ([0.5, 1.5], [0.25, 0.75], [0.1, 0.4])]


def grid():
    data = vtk.vtkRectilinearGrid()
    data.SetDimensions(2, 2, 2)
    setters = [data.SetXCoordinates, data.SetYCoordinates, data.SetZCoordinates]
    for setter, axis in zip(setters, AXES):
        setter(numpy_to_vtk(axis, deep=1))
    return data


class Steps(VTKPythonAlgorithmBase):
    TIMES = [0.0, 0.1]

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkRectilinearGrid")

    def RequestInformation(self, request, inputs, outputs):
        info = outputs.GetInformationObject(0)
        executive = vtk.vtkStreamingDemandDrivenPipeline
        info.Set(executive.TIME_STEPS(), self.TIMES, 2)
        info.Set(executive.TIME_RANGE(), self.TIMES, 2)
        info.Set(executive.WHOLE_EXTENT(), [0, 1, 0, 1, 0, 1], 6)
        return 1

    def RequestData(self, request, inputs, outputs):
        info = outputs.GetInformationObject(0)
        time = info.Get(vtk.vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP())
        data = info.Get(vtk.vtkDataObject.DATA_OBJECT())
        data.ShallowCopy(grid())
        data.GetInformation().Set(vtk.vtkDataObject.DATA_TIME_STEP(), time or 0.0)
        return 1


def written(name, source):
    path = f"{sys.argv[1]}/{name}.vtkhdf"
    writer = vtk.vtkHDFWriter()
    writer.SetFileName(path)
    if source is None:
        writer.SetInputDataObject(grid())
    else:
        writer.SetInputConnection(source.GetOutputPort())
        writer.SetWriteAllTimeSteps(True)
    assert writer.Write() == 1
    return h5py.File(path)["VTKHDF"]


one, two = written("one", None), written("two", Steps())
times = [float(time) for time in two["Steps/Values"]]
print("one step: z", one["ZCoordinates"][()], one["ZCoordinates"].dtype)
print("two steps: z", two["ZCoordinates"][()], f"{two['ZCoordinates'].dtype}, times", times)
assert one["ZCoordinates"][()].tolist() == [0.1, 0.4]
assert two["ZCoordinates"].dtype == np.int64 and not two["ZCoordinates"][()].any()
assert times == [0.0, float(np.float32(0.1))]
PYTHON
