"""Samples of a mesh on a regular grid by VTK's vtkResampleToImage and by `resample` and `voxel-hw`, in turn.

    pip install vtk numpy
    cargo build --release --workspace --example resample_in_turn
    python benches/peers/vtk_resample.py mesh.vtu 256x128x64

VTK runs on all threads (vtkSMPTools, STDThread); its default is one. Ours uploads the mesh in each
turn and waits for the samples on the device. The mesh is given as .vtu; `sphere` and other data sets
are written by ours first. Medians over the rounds, and how much the samples differ.
"""

import pathlib
import statistics
import subprocess
import sys
import time

import vtk

ROUNDS = 9

PROGRAM = pathlib.Path(__file__).parents[2] / "target/release/examples/resample_in_turn"


def main():
    path, dims = sys.argv[1], sys.argv[2]
    program = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else PROGRAM
    vtk.vtkSMPTools.SetBackend("STDThread")
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    mesh = reader.GetOutput()
    resample = vtk.vtkResampleToImage()
    resample.SetInputDataObject(mesh)
    resample.SetSamplingDimensions(*(int(d) for d in dims.split("x")))
    ours = subprocess.Popen(
        [program, path, dims], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    print("ours:", ours.stdout.readline().strip())
    print("VTK:", vtk.vtkVersion().GetVTKVersion(), mesh.GetNumberOfCells(), "cells")
    times = {"resample": [], "voxel-hw": [], "VTK": []}
    for _ in range(ROUNDS):
        ours.stdin.write("\n")
        ours.stdin.flush()
        resampled, voxelized = ours.stdout.readline().split()
        times["resample"].append(float(resampled))
        times["voxel-hw"].append(float(voxelized))
        # Other points make it find the cells anew, as those of a mesh that has moved.
        mesh.GetPoints().Modified()
        mesh.Modified()
        resample.Modified()
        start = time.perf_counter()
        resample.Update()
        times["VTK"].append(time.perf_counter() - start)
    ours.stdin.close()
    medians = {name: statistics.median(seconds) for name, seconds in times.items()}
    for name, seconds in medians.items():
        print(f"{name}: {1e3 * seconds:.0f} ms ({dims}, median of {ROUNDS})")
    print(f"VTK / resample: {medians['VTK'] / medians['resample']:.2f}")
    print(f"VTK / voxel-hw: {medians['VTK'] / medians['voxel-hw']:.2f}")
    print(f"voxel-hw / resample: {medians['voxel-hw'] / medians['resample']:.2f}")


main()
