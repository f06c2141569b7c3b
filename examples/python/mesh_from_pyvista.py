"""A mesh of PyVista, drawn exactly, without a window.

    python mesh_from_pyvista.py [--small] [FILE]

Takes an unstructured grid that PyVista has made or read, draws one of its fields, and does with the
picture what a notebook would: save it, and look at what it took. Needs PyVista; no display.
"""

import argparse

import numpy as np
import pyvista

import tetrascope


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", nargs="?", help="a file that PyVista reads")
    parser.add_argument("--small", action="store_true", help="few cells and pixels")
    arguments = parser.parse_args()

    if arguments.file:
        grid = pyvista.read(arguments.file)
    else:
        # Tetrahedra of a box of 2:1:1, with two fields.
        n = 6 if arguments.small else 24
        box = pyvista.ImageData(dimensions=(2 * n + 1, n + 1, n + 1), spacing=(1 / n,) * 3)
        grid = box.to_tetrahedra()
        x, y, z = np.asarray(grid.points).T
        grid["wave"] = np.sin(6 * x) * np.cos(5 * y) + z
        grid["velocity"] = np.column_stack([-y, x, 0.2 * z])

    size = (96, 64) if arguments.small else (768, 512)
    look = dict(camera="+iso", size=size, background="white", cmap="viridis")
    picture = tetrascope.render(grid, **look)
    picture.save("from_pyvista.png")
    print(picture.shape, f"{1e3 * picture.stats['cpu_seconds']:.1f} ms", *picture.defaults, sep="\n  ")

    # Another field of the same object: a vector's magnitude, or one of its components.
    if "velocity" in grid.point_data:
        tetrascope.render(grid, field="velocity-x", opacity="linear", **look).save("velocity_x.png")

    # An isosurface, cut open, from PyVista's own camera.
    plotter_camera = pyvista.Camera()
    plotter_camera.position, plotter_camera.focal_point = (5.0, 4.0, 3.0), grid.center
    plotter_camera.up = (0, 0, 1)
    low, high = tetrascope.Volume(grid).range
    surface = tetrascope.render(
        grid,
        isovalues=[(low + high) / 2],
        clip=(grid.center, (0, -1, 0)),
        camera=plotter_camera,
        size=size,
    )
    surface.save("surface.png")
    print("surface at depths from", float(np.min(surface.depths)))


if __name__ == "__main__":
    main()
