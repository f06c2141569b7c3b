#!/usr/bin/env python3
"""Draws one volume with one of VTK's mappers, for `cargo xtask compare --peer vtk`.

    python benches/peers/vtk_compare.py --list
    python benches/peers/vtk_compare.py MAPPER VOLUME SCENE.toml IMAGE --repeat 5

VOLUME is a legacy .vtk file of tetrahedra or a .vti file. IMAGE gets premultiplied RGBA as little-endian floats, top
row first; they have the steps of 1/255 that a window has. Alpha is what differs between a black and a white background.
Prints one JSON object: milliseconds to prepare, of the first frame, and of frames from a camera that moves on by half a
degree each. Nothing of a frame is kept: the camera is modified before each.

Opacity: the unstructured mappers take optical depth per unit distance, so that the extinction of the scene, divided by
its maximum, with that unit distance, is the same medium. The mappers of images take opacity over the unit distance, so
that 1 - exp(-extinction * unit) at 4096 scalars is.
"""

import argparse
import json
import pathlib
import resource
import sys
import time
import tomllib

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

MESH = {
    "projected-tetrahedra": None,
    "bunyk-partial": "vtkUnstructuredGridPartialPreIntegration",
    "bunyk-table": "vtkUnstructuredGridPreIntegration",
    "bunyk-linear": "vtkUnstructuredGridLinearRayIntegrator",
}
GRID = {
    "fixed-point": "vtkFixedPointVolumeRayCastMapper",
    "gpu-ray-cast": "vtkOpenGLGPUVolumeRayCastMapper",
}
DEGREES = 0.5


def read(path):
    reader = vtk.vtkXMLImageDataReader() if path.suffix == ".vti" else vtk.vtkUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def volume_property(appearance, is_grid):
    stops = appearance["transfer_function"]
    is_dark = appearance.get("optical_model") == "absorption"
    greatest = max(stop["extinction"] for stop in stops) or 1.0
    color, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    color.AllowDuplicateScalarsOn()
    opacity.AllowDuplicateScalarsOn()
    for stop in stops:
        color.AddRGBPoint(stop["scalar"], *([0.0] * 3 if is_dark else stop["color"]))
    scalars = [stop["scalar"] for stop in stops]
    if is_grid:
        # The steps of a table that VTK makes anyway; equal scalars are a step there, too.
        for scalar in np.linspace(scalars[0], scalars[-1], 4096):
            extinction = np.interp(scalar, scalars, [stop["extinction"] for stop in stops])
            opacity.AddPoint(scalar, -np.expm1(-extinction / greatest))
    else:
        for stop in stops:
            opacity.AddPoint(stop["scalar"], stop["extinction"] / greatest)
    result = vtk.vtkVolumeProperty()
    result.SetColor(color)
    result.SetScalarOpacity(opacity)
    result.SetScalarOpacityUnitDistance(1.0 / greatest)
    result.SetInterpolationTypeToLinear()
    result.ShadeOff()
    return result


def mapper_of(name, data):
    if name == "projected-tetrahedra":
        mapper = vtk.vtkProjectedTetrahedraMapper()
    elif name in MESH:
        mapper = vtk.vtkUnstructuredGridVolumeRayCastMapper()
        mapper.SetRayCastFunction(vtk.vtkUnstructuredGridBunykRayCastFunction())
        mapper.SetRayIntegrator(getattr(vtk, MESH[name])())
        mapper.SetAutoAdjustSampleDistances(0)
        mapper.SetImageSampleDistance(1.0)
    else:
        mapper = getattr(vtk, GRID[name])()
        mapper.SetAutoAdjustSampleDistances(0)
        mapper.SetSampleDistance(0.5 * min(data.GetSpacing()))
        if name == "fixed-point":
            mapper.SetInteractiveSampleDistance(0.5 * min(data.GetSpacing()))
            mapper.SetImageSampleDistance(1.0)
    mapper.SetInputData(data)
    return mapper


class Window:
    def __init__(self, scene, volume):
        wanted, image = scene["camera"], scene["image"]
        self.camera = camera = vtk.vtkCamera()
        camera.SetPosition(*wanted["position"])
        camera.SetFocalPoint(*wanted["focal_point"])
        camera.SetViewUp(*wanted["view_up"])
        if wanted["projection"] == "orthographic":
            camera.ParallelProjectionOn()
            camera.SetParallelScale(wanted["parallel_scale"])
        else:
            camera.SetViewAngle(wanted["view_angle"])
        self.renderer = vtk.vtkRenderer()
        self.renderer.SetActiveCamera(camera)
        self.renderer.AddVolume(volume)
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(image["width"], image["height"])
        self.window.AddRenderer(self.renderer)
        self.renderer.ResetCameraClippingRange()

    def frame(self):
        """Milliseconds."""
        self.camera.Modified()
        start = time.perf_counter()
        self.window.Render()
        self.window.WaitForCompletion()
        return 1e3 * (time.perf_counter() - start)

    def rgb(self, background):
        """Of (rows, columns, 3), top row first."""
        self.renderer.SetBackground(background, background, background)
        self.frame()
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.SetInputBufferTypeToRGB()
        grab.ReadFrontBufferOff()
        grab.Update()
        image = grab.GetOutput()
        width, height, _ = image.GetDimensions()
        return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 3)[::-1] / 255.0


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--list", action="store_true", help="print VTK's version and the mappers as JSON")
    arguments.add_argument("mapper", nargs="?", choices=[*MESH, *GRID])
    arguments.add_argument("volume", nargs="?", type=pathlib.Path)
    arguments.add_argument("scene", nargs="?", type=pathlib.Path)
    arguments.add_argument("image", nargs="?", type=pathlib.Path)
    arguments.add_argument("--repeat", type=int, default=5)
    given = arguments.parse_args()
    if given.list:
        version = vtk.vtkVersion.GetVTKVersion()
        print(json.dumps({"version": version, "mesh": list(MESH), "grid": list(GRID)}))
        return
    if given.image is None:
        arguments.error("a mapper, a volume, a scene and an image are needed")
    scene = tomllib.loads(given.scene.read_text())
    start = time.perf_counter()
    data = read(given.volume)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper_of(given.mapper, data))
    volume.SetProperty(volume_property(scene["appearance"], given.mapper in GRID))
    window = Window(scene, volume)
    prepare = 1e3 * (time.perf_counter() - start)
    first = window.frame()
    on_black, on_white = window.rgb(0.0), window.rgb(1.0)
    alpha = 1.0 - (on_white - on_black).mean(axis=2, keepdims=True)
    np.concatenate([on_black, alpha], axis=2).astype("<f4").tofile(given.image)
    frames = []
    for _ in range(given.repeat):
        if first + sum(frames) >= 600.0:
            break
        window.camera.Azimuth(DEGREES)
        frames.append(window.frame())
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(json.dumps({"prepare_ms": prepare, "first_ms": first, "frames_ms": frames, "peak_bytes": peak}))


if __name__ == "__main__":
    sys.exit(main())
