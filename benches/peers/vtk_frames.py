#!/usr/bin/env python3
"""Times VTK's volume mappers, and our algorithms in turn with them, on one of our scene files.

    pip install vtk
    cargo build --release --workspace --example frames_in_turn
    python benches/peers/vtk_frames.py SCENE.toml [--repeat 5] [--mapper NAME]... [--ours NAME:KEY=VALUE]...

Prints one line per mapper: the median, the least and the greatest seconds of a frame; then the ratios of medians. Nothing
of a frame is kept: the camera is marked as modified before each. A mesh is cleaned first, so that every mapper here and
our own algorithms draw the same cells; one of the mappers crashed in some runs on the mesh as it is. Our algorithms draw
images of the scene's own size, in their own process, and read them back; VTK's frame stays where it is.
Mappers and their opacity are those of vtk_compare.py.
"""

import argparse
import pathlib
import statistics
import subprocess
import time
import tomllib

import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from vtk_compare import GRID, MESH, mapper_of, volume_property

PROGRAM = pathlib.Path(__file__).parents[2] / "target/release/examples/frames_in_turn"


def load(path, field):
    if path.suffix == ".vti":
        reader = vtk.vtkXMLImageDataReader()
        reader.SetFileName(str(path))
        reader.Update()
        return reader.GetOutput(), 0
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype("f8")
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
    a, b, c, d = (points[cells[:, i]] for i in range(4))
    volume = ((b - a)[:, [1, 2, 0]] * (c - a)[:, [2, 0, 1]] - (b - a)[:, [2, 0, 1]] * (c - a)[:, [1, 2, 0]])
    kept = cells[(volume * (d - a)).sum(axis=1) != 0]
    mesh = vtk.vtkUnstructuredGrid()
    mesh.SetPoints(grid.GetPoints())
    array = vtk.vtkCellArray()
    array.SetData(4, numpy_to_vtk(kept.reshape(-1).astype("i8"), deep=1, array_type=vtk.VTK_ID_TYPE))
    mesh.SetCells(vtk.VTK_TETRA, array)
    scalars = grid.GetPointData().GetArray(field)
    mesh.GetPointData().SetScalars(scalars)
    return mesh, len(cells) - len(kept)


def window(scene, size):
    wanted = scene["camera"]
    camera = vtk.vtkCamera()
    camera.SetPosition(*wanted["position"])
    camera.SetFocalPoint(*wanted["focal_point"])
    camera.SetViewUp(*wanted["view_up"])
    camera.SetViewAngle(wanted["view_angle"])
    renderer = vtk.vtkRenderer()
    renderer.SetActiveCamera(camera)
    renderer.SetBackground(*scene["image"]["background"][:3])
    result = vtk.vtkRenderWindow()
    result.SetOffScreenRendering(1)
    result.SetMultiSamples(0)
    result.SetSize(*size)
    result.AddRenderer(renderer)
    return result, renderer, camera


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("scene", type=pathlib.Path)
    arguments.add_argument("--size", help="of VTK's window; the scene's own if left out")
    arguments.add_argument("--repeat", type=int, default=5)
    arguments.add_argument("--mapper", action="append", choices=[*MESH, *GRID])
    arguments.add_argument("--ours", action="append", default=[], help="an algorithm of ours, in turn")
    arguments.add_argument("--program", type=pathlib.Path, default=PROGRAM)
    arguments.add_argument("--save", type=pathlib.Path, help="folder for a PNG of each mapper")
    arguments = arguments.parse_args()
    scene = tomllib.loads(arguments.scene.read_text())
    image = scene["image"]
    size = [int(n) for n in (arguments.size or f"{image['width']}x{image['height']}").split("x")]
    mesh, dropped = load(arguments.scene.parent / scene["volume"]["file"], scene["volume"].get("field"))
    is_grid = mesh.IsA("vtkImageData")
    vtk.vtkSMPTools.SetBackend("STDThread")
    print(f"VTK {vtk.vtkVersion.GetVTKVersion()}, {mesh.GetNumberOfCells()} cells ({dropped} left out)")
    runs = []
    for name in arguments.mapper or (GRID if is_grid else MESH):
        volume = vtk.vtkVolume()
        volume.SetMapper(mapper_of(name, mesh))
        volume.SetProperty(volume_property(scene["appearance"], is_grid=is_grid))
        target, renderer, camera = window(scene, size)
        renderer.AddVolume(volume)
        renderer.ResetCameraClippingRange()
        target.Render()
        runs.append((name, target, renderer, camera, []))
    ours = {name: [] for name in arguments.ours}
    if ours:
        program = subprocess.Popen(
            [arguments.program, arguments.scene, *ours], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        for _ in ours:
            print(program.stdout.readline().strip())
    for _ in range(arguments.repeat):
        if ours:
            program.stdin.write("\n")
            program.stdin.flush()
            for seconds, taken in zip(ours.values(), program.stdout.readline().split()):
                seconds.append(float(taken))
        for _, target, _, camera, seconds in runs:
            camera.Modified()
            start = time.perf_counter()
            target.Render()
            target.WaitForCompletion()
            seconds.append(time.perf_counter() - start)
    for name, seconds in ours.items():
        print(f"{name:22} median {statistics.median(seconds):.4f} s  least {min(seconds):.4f}  greatest {max(seconds):.4f}")
    for name, target, _, _, seconds in runs:
        print(f"{name:22} median {statistics.median(seconds):.3f} s  least {min(seconds):.3f}  greatest {max(seconds):.3f}")
        if arguments.save:
            grab = vtk.vtkWindowToImageFilter()
            grab.SetInput(target)
            grab.ReadFrontBufferOff()
            writer = vtk.vtkPNGWriter()
            writer.SetFileName(str(arguments.save / f"{name}.png"))
            writer.SetInputConnection(grab.GetOutputPort())
            writer.Write()
    for name, seconds in ours.items():
        for mapper, *_, theirs in runs:
            print(f"{mapper} / {name}: {statistics.median(theirs) / statistics.median(seconds):.2f}")


if __name__ == "__main__":
    main()
