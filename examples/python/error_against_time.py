"""How wrong and how fast is each algorithm on my mesh?

    python error_against_time.py [--small] [--error 1e-3] [MESH]

Draws a mesh (a file, or a data set if none is given) with every algorithm, compares each picture
with the exact ground truth, prints a table by time, and chooses for an error. Needs NumPy alone;
where matplotlib is installed, it also writes error_against_time.png.
"""

import argparse

import tetrascope


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", nargs="?", help="a file; a data set of 20 000 cells if left out")
    parser.add_argument("--error", type=float, default=1e-3, help="RMSE of linear RGBA to keep")
    parser.add_argument("--small", action="store_true", help="a small mesh and picture")
    arguments = parser.parse_args()

    size = 64 if arguments.small else 256
    if arguments.mesh:
        volume = tetrascope.Volume(arguments.mesh)
    else:
        volume = tetrascope.Volume("orbital", n_cells=1_000 if arguments.small else 20_000)
    print(volume.description)

    table = tetrascope.compare(volume, size=size, repeat=1 if arguments.small else 5).sorted("ms")
    print(table)

    # The fastest that keeps the error; this is what a table cannot tell of other settings.
    fitting = [row for row in table if row["rmse"] <= arguments.error]
    print(f"fastest within {arguments.error:g}: {fitting[0]['name']}, {fitting[0]['ms']:.1f} ms")

    try:
        import matplotlib

        matplotlib.use("agg")
        from matplotlib import pyplot
    except ImportError:
        return
    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    for row in table:
        axes.loglog(row["ms"], max(row["rmse"], 1e-9), "o")
        axes.annotate(row["name"], (row["ms"], max(row["rmse"], 1e-9)), fontsize=8)
    axes.set(xlabel="time of a frame, ms", ylabel="RMSE against the truth, linear RGBA")
    figure.savefig("error_against_time.png", dpi=150)


if __name__ == "__main__":
    main()
