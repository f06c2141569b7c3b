"""Choosing, comparing, resampling, and lists of what there is."""

from __future__ import annotations

import json
import logging
import os
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _arrays as arrays
from . import _options as options_
from . import _tetrascope as native
from ._errors import TetrascopeError, unknown
from ._errors import error as wrong
from ._options import LOOK, VIEW, VOLUME
from ._picture import Picture, picture_of
from ._renderer import Renderer
from ._table import Table
from ._volume import Volume, source_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import SceneOptions

log = logging.getLogger("tetrascope")


@dataclass(frozen=True)
class Choice:
    """What :func:`choose` has chosen: an algorithm, its settings, and the picture."""

    algorithm: str
    settings: dict[str, str]
    picture: Picture
    report: list[str]
    trials: Table
    gives_way: list[str]
    found: dict[str, Any]
    volume: Volume

    def renderer(self, **options: Any) -> Renderer:
        """A renderer of the same volume by what was chosen; takes a look and a view."""
        return Renderer(self.volume, algorithm=self.algorithm, settings=self.settings, **options)

    def __repr__(self) -> str:
        return "\n".join(self.report)


def choose(
    volume: Any,
    cells: Any = None,
    celltypes: Any = None,
    scalars: Any = None,
    *,
    error: float | None = None,
    budget_ms: float | None = None,
    memory: int | None = None,
    effort: str = "full",
    keep: bool = True,
    recalibrate: bool = False,
    **options: Unpack[SceneOptions],
) -> Choice:
    """Chooses the algorithm and settings that do what a picture needs, and draws it.

    ``error`` is the RMSE against the truth that must be kept, over all channels of premultiplied
    linear RGBA; ``budget_ms`` the time of a frame, milliseconds; ``memory`` bytes for the volume.
    With an error, the fastest setting that keeps it is chosen; without, the most exact one within
    the budget. Where none keeps both, the budget gives way, and ``gives_way`` says by how much.

    The first call on a machine measures it, which takes about a minute (``effort="quick"``: some
    seconds, and less is known); ``keep`` keeps that in the user's cache. What is being measured
    goes to the logger "tetrascope". The other parameters are those of :func:`render`.
    """
    options_.check(options, VOLUME, LOOK, VIEW)
    if effort not in ("full", "quick"):
        raise unknown("effort", effort, ("full", "quick"))
    given: dict[str, Any] = dict(options)
    drawn = options_.volume_of(volume, (cells, celltypes, scalars), given)
    scene = options_.scene_of(drawn, options_.part(given, LOOK), options_.part(given, VIEW))
    budget = None if budget_ms is None else arrays.number("budget_ms", budget_ms) / 1e3
    frame, name, settings, text = native.choose(
        drawn._native,
        scene,
        None if error is None else arrays.number("error", error),
        budget,
        None if memory is None else arrays.count("memory", memory),
        effort == "quick",
        keep,
        recalibrate,
        log.info,
    )
    report = json.loads(text)
    needs_gpu = {found["name"]: found["needs_gpu"] for found in algorithms()}
    adapter = native.adapter() if needs_gpu[name] else None
    chosen = dict(settings)
    return Choice(
        algorithm=name,
        settings=chosen,
        picture=picture_of(frame, scene, name, chosen, adapter, drawn.notes),
        report=report["report"],
        trials=Table(_trial(trial) for trial in report["trials"]),
        gives_way=report["gives_way"],
        found=report["chosen"]["found"],
        volume=drawn,
    )


def _trial(trial: dict[str, Any]) -> dict[str, Any]:
    found = trial["found"]
    return {
        "name": trial["name"],
        "ms": 1e3 * found["seconds"],
        "prepare_ms": 1e3 * found["prepare"],
        "rmse": found["error"]["rmse"],
        "megabytes": found["bytes"] / 1e6,
    }


class Comparison(Table):
    """The table of :func:`compare`; ``skipped`` says what could not be drawn and why, and ``truth``
    is the picture that all others are compared with."""

    skipped: Table
    truth: Picture
    pictures: dict[str, Picture]

    def __repr__(self) -> str:
        missing = [f"skipped {row['name']}: {row['why']}" for row in self.skipped]
        return "\n".join([super().__repr__(), *missing])


def compare(
    volume: Any,
    cells: Any = None,
    celltypes: Any = None,
    scalars: Any = None,
    *,
    algorithms: Iterable[str] | None = None,
    sweep: bool = False,
    repeat: int = 3,
    **options: Unpack[SceneOptions],
) -> Comparison:
    """Error against time of all algorithms on a volume, against the exact ground truth.

    One row for each algorithm that draws the volume with its default settings, or with ``sweep``
    for each of the settings that matter: name, ``ms`` (of a frame, the least of ``repeat``),
    ``prepare_ms`` (once for the volume), ``rmse`` and ``max_error`` (over all channels of
    premultiplied linear RGBA), ``megabytes`` that the volume takes. ``algorithms`` are names; an
    entry such as "projection,order=centroid" has settings. ``pictures`` has all pictures by name.
    """
    options_.check(options, VOLUME, LOOK, VIEW)
    given: dict[str, Any] = dict(options)
    drawn = options_.volume_of(volume, (cells, celltypes, scalars), given)
    rest = options_.part(given, LOOK) | options_.part(given, VIEW)
    times = max(1, arrays.count("repeat", repeat, 1000))
    table = Comparison()
    table.skipped, table.pictures = Table(), {}
    table.truth = Renderer(drawn, algorithm=_truth(), **rest).render()
    for name, settings in _entries(algorithms, sweep):
        label = ",".join([name, settings]) if settings else name
        try:
            start = time.perf_counter()
            renderer = Renderer(drawn, algorithm=name, settings=settings, **rest)
            prepare = time.perf_counter() - start
            renderer.render()  # warms up
            seconds = []
            for _ in range(times):
                start = time.perf_counter()
                picture = renderer.render()
                seconds.append(time.perf_counter() - start)
        except TetrascopeError as why:
            table.skipped.append({"name": label, "why": str(why)})
            continue
        off = np.abs(np.asarray(picture, np.float64) - np.asarray(table.truth, np.float64))
        table.pictures[label] = picture
        table.append(
            {
                "name": label,
                "ms": 1e3 * min(seconds),
                "prepare_ms": 1e3 * prepare,
                "rmse": float(np.sqrt((off**2).mean())),
                "max_error": float(off.max()),
                "megabytes": picture.stats["bytes_resident"] / 1e6,
            }
        )
    return table


def _truth() -> str:
    return next(str(found["name"]) for found in algorithms() if found["is_truth"])


def _entries(names: Iterable[str] | None, sweep: bool) -> Iterator[tuple[str, str]]:
    every = {str(found["name"]): found for found in algorithms()}
    if isinstance(names, str):
        names = [names]
    for entry in every if names is None else names:
        name, _, settings = str(entry).partition(",")
        if name not in every:
            raise unknown("algorithm", name, every)
        for swept in every[name]["sweep"] if sweep and not settings else [settings]:
            yield name, swept


@dataclass(frozen=True)
class Samples:
    """Samples of a mesh on a regular grid, in the layout that :class:`Volume` takes.

    ``values[i, j, k]`` is float32, at ``origin + spacing * (i, j, k)``, world units; ``inside`` says
    which are in the mesh.
    """

    values: npt.NDArray[np.float32]
    spacing: tuple[float, float, float]
    origin: tuple[float, float, float]
    inside: npt.NDArray[np.bool_]

    def volume(self) -> Volume:
        """The samples as a volume."""
        return Volume(self.values, spacing=self.spacing, origin=self.origin)


def resample(
    volume: Any,
    cells: Any = None,
    celltypes: Any = None,
    scalars: Any = None,
    *,
    dims: Any = None,
    bounds: Any = None,
    outside: float = float("nan"),
    **options: Any,
) -> Samples:
    """Takes samples of a mesh's field at the points of a regular grid, on the graphics device.

    ``dims`` is (nx, ny, nz), or how many along the longest axis; left out, they are as far apart as
    the mesh's points, at most 2^24. ``bounds`` is (xmin, xmax, ymin, ymax, zmin, zmax), world units,
    the mesh's own unless given. ``outside`` is the value of samples outside of the mesh.
    """
    options_.check(options, VOLUME)
    drawn = options_.volume_of(volume, (cells, celltypes, scalars), options)
    longest, each = None, None
    if dims is not None and np.ndim(dims) == 0:
        longest = arrays.count("dims", dims, 1 << 20)
        if longest < 2:
            raise wrong(f"dims is {longest}", "give at least 2 samples along the longest axis")
    elif dims is not None:
        counts = arrays.indices("dims", dims)
        if counts.shape != (3,) or (counts < 0).any() or (counts > 1 << 20).any():
            raise wrong("dims must be one or three whole numbers", "give samples along each axis")
        each = [int(n) for n in counts]
    box = None if bounds is None else arrays.vector("bounds", bounds, 6)
    fill = float(arrays.numbers("outside", outside))
    values, inside, found, origin, spacing = native.resample(
        drawn._native, longest, each, box, fill
    )
    x, y, z = (float(number) for number in origin)
    dx, dy, dz = (float(number) for number in spacing)
    return Samples(
        values=values.reshape(tuple(found), order="F"),
        spacing=(dx, dy, dz),
        origin=(x, y, z),
        inside=inside.reshape(tuple(found), order="F"),
    )


def algorithms() -> Table:
    """Every algorithm: name, title, what it draws, its paper, whether it needs a graphics device,
    whether it is the truth, and its settings with their values and defaults."""
    return Table(json.loads(native.algorithms()))


def info(source: Any = None, **options: Any) -> dict[str, Any]:
    """What a volume holds: fields with their ranges, cells, bounds, notes.

    Without a volume: the version, graphics adapters, formats of files, data sets, color maps.
    """
    if source is None:
        options_.check(options)
        found: dict[str, Any] = json.loads(native.names(True))
        return found
    options_.check(options, VOLUME)
    if isinstance(source, (str, os.PathLike)):
        named = {k: options.pop(k) for k in ("field", "spacing", "origin", "interpolation") if k in options}
        path, written = source_of(source, **named, of_files=options)
        held: dict[str, Any] = json.loads(native.info(path, json.dumps(written)))
        return held
    volume = options_.volume_of(source, (None, None, None), options)
    return {
        "description": volume.description,
        "field": next(field["name"] for field in volume.fields if field["drawn"]),
        "fields": volume.fields,
        "cells": volume.n_cells,
        "range": volume.range,
        "bounds": list(volume.bounds),
        "notes": volume.notes,
    }


def steps(path: str | os.PathLike[str]) -> Table:
    """The time steps of a file or a collection (``.pvd``, ``.series``): file, step in it, time."""
    found = native.steps(os.fsdecode(path))
    rows = ({"file": os.fspath(file), "step": step, "time": when} for file, step, when in found)
    return Table(rows)


def load_steps(
    path: str | os.PathLike[str], field: str | None = None
) -> Iterator[tuple[float | None, Volume]]:
    """The time and the volume of each time step in turn, one in memory at a time.

    Steps on the same mesh share its geometry, so that :meth:`Renderer.set_volume` sends scalars alone.
    """
    previous: native.Volume | None = None
    for row in steps(path):
        written = {key: row[key] for key in ("step",) if row[key] is not None}
        if field is not None:
            written["field"] = field
        loaded = native.load(row["file"], json.dumps(written), previous)
        previous = loaded
        yield row["time"], Volume(loaded)
