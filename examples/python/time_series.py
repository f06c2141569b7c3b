"""A field that changes with time on a mesh that does not: one picture per step.

    python time_series.py [--small] [--out FOLDER]

Two warm spots circle each other in a cold cube. The renderer is made once; each step sends its
scalars alone, and one color means one temperature in all pictures. Needs NumPy alone.
"""

import argparse
import pathlib
import time

import numpy as np

import tetrascope


def cube(n):
    """Points of a cube of n³ hexahedra, and these."""
    axis = np.linspace(-1.0, 1.0, n + 1)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    i, j, k = np.meshgrid(*[np.arange(n)] * 3, indexing="ij")
    first = (i + (n + 1) * (j + (n + 1) * k)).ravel()
    corner = np.array([0, 1, n + 2, n + 1])
    return points, first[:, None] + np.concatenate([corner, corner + (n + 1) ** 2])


def temperature(points, turn):
    """Of each point, when the spots have turned by so much of a circle."""
    angle = 2 * np.pi * turn
    spot = 0.5 * np.array([np.cos(angle), np.sin(angle), 0.4 * np.sin(2 * angle)])
    warmth = [np.exp(-12 * ((points - center) ** 2).sum(axis=1)) for center in (spot, -spot)]
    return warmth[0] + 0.7 * warmth[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--small", action="store_true", help="few cells, pixels and steps")
    parser.add_argument("--out", default=".", type=pathlib.Path, help="folder of the pictures")
    arguments = parser.parse_args()

    points, cells = cube(8 if arguments.small else 40)
    steps = 3 if arguments.small else 24
    renderer = tetrascope.Renderer(
        points,
        cells,
        None,
        temperature(points, 0),
        range=(0, 1),  # of the series, not of a step
        unit_distance=0.2,
        cmap="inferno",
        camera="+iso",
        size=64 if arguments.small else 400,
        background="black",
    )
    for step in range(steps):
        start = time.perf_counter()
        renderer.set_scalars(temperature(points, step / steps))
        sent = time.perf_counter()
        picture = renderer.render()
        drawn = time.perf_counter()
        path = arguments.out / f"step_{step:02}.png"
        picture.save(path)
        print(f"{path}: scalars {1e3 * (sent - start):.1f} ms, picture {1e3 * (drawn - sent):.1f} ms")


if __name__ == "__main__":
    main()
