"""What VTK reads of the grid that crates/io/examples/write_grid.rs writes.

    cargo run --example write_grid -- grid.vti
    cargo run --example write_grid -- packed.vti zlib
    python benches/peers/vtk_grid.py grid.vti packed.vti

Needs vtk and numpy. Prints what was read; fails if any number is not the one written.
"""

import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def read(path):
    reader = vtk.vtkXMLImageDataReader()
    if not reader.CanReadFile(path):
        raise SystemExit(f"{path}: VTK does not take it for an image")
    reader.SetFileName(path)
    reader.Update()
    if reader.GetErrorCode():
        raise SystemExit(f"{path}: VTK's error {reader.GetErrorCode()}")
    return reader.GetOutput()


def main(paths):
    x, y, z = np.meshgrid(np.arange(60), np.arange(50), np.arange(70), indexing="ij")
    flat = lambda a: a.ravel(order="F")
    distance = np.sqrt(((x - 30) ** 2 + (y - 25) ** 2 + (z - 35) ** 2).astype(np.float32))
    expected = {
        "wave": flat((x * x).astype(np.float32) / np.float32(8) - (y * z).astype(np.float32)),
        "coverage": flat(np.clip(np.float32(21) - distance, 0, 1)),
        "number": flat(x + 60 * y + 7 * z).astype(np.uint16),
    }
    for path in paths:
        image = read(path)
        assert image.GetDimensions() == (60, 50, 70), image.GetDimensions()
        assert image.GetOrigin() == (-1.0, 0.1, 2.5e3), image.GetOrigin()
        assert image.GetSpacing() == (0.1, 0.25, 1 / 3), image.GetSpacing()
        # Sample (1, 0, 0) lies one spacing along the second world axis, as the grid is turned.
        point = np.array(image.GetPoint(1)) - image.GetOrigin()
        assert np.allclose(point, (0, 0.1, 0), atol=1e-15), point
        data = image.GetPointData()
        assert data.GetScalars().GetName() == "wave"
        assert data.GetNumberOfArrays() == len(expected)
        for name, values in expected.items():
            found = vtk_to_numpy(data.GetArray(name))
            assert found.dtype == values.dtype, (name, found.dtype)
            assert np.array_equal(found, values), name
            print(f"{path}: {name}, {found.size} values of {found.dtype}, all equal")
    print(f"VTK {vtk.vtkVersion().GetVTKVersion()}")


if __name__ == "__main__":
    main(sys.argv[1:] or ["grid.vti"])
