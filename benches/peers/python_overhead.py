#!/usr/bin/env python3
"""Measures the Python package: what a call adds, passing arrays, and a picture beside PyVista's.

    pip install ./crates/python pyvista
    python benches/peers/python_overhead.py [MESH.vtu] [--cells 10000000] [--repeat 7]

Three parts, each with its ratio:
1. `Renderer.render` against the time that the frame itself took, as its statistics have it.
2. `Volume(points, cells, celltypes, scalars)` of float64 and int64 arrays: seconds, and the memory that it takes at
   its peak beyond what was there, in shares of the arrays' bytes. In a process of its own, on Linux.
3. A picture of 512×512 from arrays in memory to an array, everything included, in turn with PyVista's `add_volume` and
   `screenshot` of the same mesh; only with MESH and PyVista. Cameras and sizes are the same, and colors are each one's own.
"""

import argparse
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import tetrascope


def overhead(repeat):
    print("1. Renderer.render over the frame's own time")
    for cells, size in ((5_000, 128), (50_000, 256), (200_000, 512)):
        renderer = tetrascope.Renderer("orbital", n_cells=cells, size=size)
        renderer.render()
        ratios, times = [], []
        for _ in range(5 * repeat):
            start = time.perf_counter()
            picture = renderer.render("+iso")
            times.append(time.perf_counter() - start)
            ratios.append(times[-1] / picture.stats["cpu_seconds"])
        print(
            f"   {cells} cells, {size}²: {1e3 * statistics.median(times):.2f} ms, "
            f"{100 * (statistics.median(ratios) - 1):.1f} % more than the frame"
        )


def tetrahedra(wanted):
    """A cube of about so many tetrahedra, six in each of n³ cubes, as VTK's padded cells."""
    n = round((wanted / 6) ** (1 / 3))
    axis = np.linspace(0.0, 1.0, n + 1)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    i, j, k = np.meshgrid(*[np.arange(n, dtype=np.int64)] * 3, indexing="ij")
    first = (i + (n + 1) * (j + (n + 1) * k)).ravel()
    steps = np.array([1, n + 1, (n + 1) ** 2])
    orders = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]
    cells = np.empty((len(first), 6, 5), np.int64)
    cells[:, :, 0] = 4
    for which, order in enumerate(orders):
        corners = np.array([0, *np.cumsum(steps[list(order)])])
        cells[:, which, 1:] = first[:, None] + corners
    return points, cells.reshape(-1), np.full(6 * n**3, 10, np.uint8), points.sum(axis=1)


def status(key):
    for line in pathlib.Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key):
            return 1024 * int(line.split()[1])
    return 0


def passing(folder):
    """In a process of its own: arrays from files, then the volume."""
    arrays = [np.load(pathlib.Path(folder) / f"{name}.npy") for name in "pcts"]
    tetrascope.render("sphere", n_cells=100, size=4)  # threads and code are there
    pathlib.Path("/proc/self/clear_refs").write_text("5")  # the peak starts anew
    before, start = status("VmRSS"), time.perf_counter()
    volume = tetrascope.Volume(*arrays)
    seconds = time.perf_counter() - start
    given = sum(array.nbytes for array in arrays)
    peak, after = status("VmHWM") - before, status("VmRSS") - before
    print(
        f"   {volume.n_cells} tetrahedra, {given / 1e6:.0f} MB of arrays: {seconds:.2f} s, "
        f"{peak / given:.2f} times the arrays at the peak, {after / given:.2f} in the end"
    )


def beside_pyvista(path, repeat):
    import pyvista

    print("3. Arrays in memory to a picture of 512×512, in turn with PyVista")
    grid = pyvista.read(path)
    name = grid.point_data.keys()[0]
    points, cells = np.asarray(grid.points), np.asarray(grid.cells)
    types, scalars = np.asarray(grid.celltypes), np.asarray(grid[name])
    plain = pyvista.UnstructuredGrid(cells, types, points)
    plain[name] = scalars
    camera = tetrascope.render(points, cells, types, scalars, size=16).camera

    def ours():
        return tetrascope.render(points, cells, types, scalars, size=512, camera=camera)

    def theirs():
        plotter = pyvista.Plotter(off_screen=True, window_size=(512, 512))
        plotter.add_volume(plain, scalars=name, show_scalar_bar=False)
        plotter.camera.position, plotter.camera.focal_point = camera["position"], camera["focal_point"]
        plotter.camera.up, plotter.camera.view_angle = camera["view_up"], camera["view_angle"]
        picture = plotter.screenshot(return_img=True)
        plotter.close()
        return picture

    times = {ours: [], theirs: []}
    for _ in range(repeat):
        for draw, taken in times.items():
            start = time.perf_counter()
            draw()
            taken.append(time.perf_counter() - start)
    mine, other = (statistics.median(taken) for taken in times.values())
    print(f"   {len(types)} cells: tetrascope {mine:.3f} s, PyVista {other:.3f} s, ratio {other / mine:.1f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", nargs="?")
    parser.add_argument("--cells", type=int, default=10_000_000)
    parser.add_argument("--repeat", type=int, default=7)
    parser.add_argument("--passing", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.passing:
        return passing(arguments.passing)
    overhead(arguments.repeat)
    print("2. Arrays into a volume", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, array in zip("pcts", tetrahedra(arguments.cells)):
            np.save(pathlib.Path(folder) / f"{name}.npy", array)
        for _ in range(min(3, arguments.repeat)):
            subprocess.run([sys.executable, __file__, "--passing", folder], check=True)
    if arguments.mesh:
        beside_pyvista(arguments.mesh, arguments.repeat)


if __name__ == "__main__":
    main()
