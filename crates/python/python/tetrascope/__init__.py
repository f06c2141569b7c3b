"""Exact volume rendering of tetrahedral meshes and regular grids, with the error of every picture.

>>> import tetrascope
>>> picture = tetrascope.render("sphere", size=256)
>>> picture.shape, picture.dtype
((256, 256, 4), dtype('float32'))

:func:`render` draws once, :class:`Renderer` often; :func:`choose` finds the algorithm for an error or
a time; :func:`compare` tells error against time of all; :func:`resample` makes a regular grid of a
mesh. Pictures are premultiplied linear RGBA in float32, the top row first. Space is right-handed,
in the data's own unit; lengths, such as ``unit_distance``, are in that unit.

Python's lock is released while something is drawn, and Ctrl-C interrupts.
"""

from ._camera import Camera
from ._errors import DeviceError, TetrascopeError, TetrascopeWarning
from ._picture import Picture, to_srgb8
from ._renderer import Renderer, render
from ._table import Table
from ._tetrascope import VERSION as __version__
from ._tools import (
    Choice,
    Comparison,
    Samples,
    algorithms,
    choose,
    compare,
    info,
    load_steps,
    resample,
    steps,
)
from ._transfer_function import TransferFunction
from ._volume import Volume

__all__ = [
    "Camera",
    "Choice",
    "Comparison",
    "DeviceError",
    "Picture",
    "Renderer",
    "Samples",
    "Table",
    "TetrascopeError",
    "TetrascopeWarning",
    "TransferFunction",
    "Volume",
    "__version__",
    "algorithms",
    "choose",
    "compare",
    "info",
    "load_steps",
    "render",
    "resample",
    "steps",
    "to_srgb8",
]
