"""Whatever is a list of numbers, as one of the few kinds of arrays that are read natively.

Types that fit are passed as they are, without a copy: float32 and float64 for points and
scalars, int32 and int64 for indices, uint8 for types of cells. Other types, byte orders, strides
and orders of axes are converted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import error

Array = npt.NDArray[Any]


def shape(array: Array) -> str:
    """A shape in words."""
    return "×".join(map(str, array.shape)) if array.ndim else "a single number"


def numbers(what: str, given: Any) -> Array:
    """An array of numbers of any type; masked ones are NaN."""
    try:
        if isinstance(given, np.ma.MaskedArray):
            given = np.where(np.ma.getmaskarray(given), np.nan, np.ma.getdata(given))
        array = np.asarray(given)
    except (ValueError, TypeError, OverflowError) as problem:
        raise error(f"{what} cannot be made an array: {problem}") from None
    if array.dtype.kind not in "biuf":
        raise error(f"{what} must be real numbers, not of type {array.dtype}")
    return array


def plain(array: Array, dtype: Any) -> Array:
    """The array with one axis, contiguous, aligned and in native byte order."""
    with np.errstate(over="ignore"):  # numbers that are too large become infinite: not a value
        array = np.require(array, dtype=dtype, requirements=["C", "A"])
    return array.view(np.ndarray).reshape(-1)


def reals(what: str, given: Any) -> Array:
    """32- or 64-bit floats, of any shape."""
    array = numbers(what, given)
    fits = array.dtype == np.float32 and array.dtype.isnative
    kind = np.float32 if fits else np.float64
    return plain(array, kind).reshape(array.shape)


def indices(what: str, given: Any) -> Array:
    """32- or 64-bit integers, of any shape."""
    array = numbers(what, given)
    if array.size == 0:
        array = array.astype(np.int64)
    if array.dtype.kind not in "iu":
        raise error(f"{what} must be integers, not of type {array.dtype}")
    if array.dtype.kind == "u" and array.dtype.itemsize == 8:
        most = int(array.max(initial=0))
        if most > np.iinfo(np.int64).max:
            raise error(f"{what} hold {most}, beyond 64-bit integers with a sign")
    fits = array.dtype == np.int32 and array.dtype.isnative
    kind = np.int32 if fits else np.int64
    return plain(array, kind).reshape(array.shape)


def small(what: str, given: Any) -> Array:
    """Bytes along one axis."""
    if isinstance(given, np.ndarray) and given.dtype == np.uint8 and not isinstance(given, np.ma.MaskedArray):
        return plain(given, np.uint8)
    array = indices(what, given).reshape(-1)
    if array.size and (array.min() < 0 or array.max() > 255):
        wrong = int(array[(array < 0) | (array > 255)][0])
        raise error(f"{what} hold {wrong}, and are from 0 to 255")
    return plain(array, np.uint8)


def vector(what: str, given: Any, length: int = 3) -> list[float]:
    """So many finite numbers."""
    array = numbers(what, given)
    if array.shape != (length,):
        raise error(f"{what} must be {length} numbers, not {shape(array)}")
    if not np.isfinite(array).all():
        raise error(f"{what} has a number that is not finite", "give finite numbers")
    return [float(number) for number in array]


def number(what: str, given: Any) -> float:
    """A finite number."""
    array = numbers(what, given)
    if array.size != 1 or array.ndim > 1:
        raise error(f"{what} must be a number, not {shape(array)}")
    if not np.isfinite(array).all():
        raise error(f"{what} is not finite", "give a finite number")
    return float(array.reshape(-1)[0])


def count(what: str, given: Any, most: int = (1 << 63) - 1) -> int:
    """A whole number from 0 on."""
    array = numbers(what, given)
    if array.size != 1 or array.ndim > 1 or array.dtype.kind not in "iu":
        raise error(f"{what} must be a whole number, not {given!r:.40}")
    found = int(array.reshape(-1)[0])
    if not 0 <= found <= most:
        raise error(f"{what} is {found}, and must be from 0 to {most}")
    return found


def scalars(what: str, given: Any) -> Array:
    """One value for each point or cell: a vector's magnitude, with several components."""
    array = reals(what, given)
    if array.ndim == 2 and array.shape[1] == 1:
        array = array[:, 0]
    if array.ndim == 2 and 2 <= array.shape[1] <= 3:
        return np.asarray(np.linalg.norm(array.astype(np.float64), axis=1))
    if array.ndim != 1:
        raise error(f"{what} must be one value for each point or cell, not {shape(array)}")
    return array


def samples(what: str, given: Any) -> tuple[Array, list[str]]:
    """The samples of a grid with three axes, in a type that grids have, and what that changed."""
    array = numbers(what, given)
    if array.ndim != 3:
        raise error(f"{what} must have three axes, x, y and z, not {shape(array)}")
    kinds: Sequence[Any] = (np.uint8, np.uint16, np.int16, np.float32)
    native = array.dtype.newbyteorder("=")
    if native in kinds:
        return array.astype(native, copy=False), []
    if array.dtype.kind in "biu":
        low, high = (int(array.min()), int(array.max())) if array.size else (0, 0)
        for kind in kinds[:3]:
            if np.iinfo(kind).min <= low and high <= np.iinfo(kind).max:
                return array.astype(kind), []
    with np.errstate(over="ignore", invalid="ignore"):
        rounded = array.astype(np.float32)
        finite = np.isfinite(array)
        off = np.abs(rounded.astype(np.float64) - array.astype(np.float64))[finite]
        off = off[np.isfinite(off)]
    most = float(off.max()) if off.size else 0.0
    if most == 0.0:
        return rounded, []
    values = array[finite].astype(np.float64)
    width = float(values.max() - values.min())
    share = f", {most / width:.1e} of their range" if width > 0 else ""
    return rounded, [f"samples of {array.dtype} are rounded to 32-bit floats, by up to {most:.2g}{share}"]
