"""Exceptions. Their words are the library's; ``help`` says what to do."""

from __future__ import annotations

import os
from collections.abc import Iterable

from . import _tetrascope as native


class TetrascopeError(ValueError):
    """Something that was given makes no sense, or cannot be drawn.

    ``help`` is a sentence on what to do about it, or ``None``.
    """

    help: str | None = None


class DeviceError(TetrascopeError, RuntimeError):
    """No graphics adapter is there, or it failed, or something does not fit on it."""


class TetrascopeWarning(UserWarning):
    """A picture shows nothing, or hardly anything, or not all that was asked for."""


def with_help(message: str, help: str | None) -> str:
    return message if help is None else f"{message}; {help}"


def error(message: str, help: str | None = None) -> TetrascopeError:
    """An error of what was given."""
    made = TetrascopeError(with_help(message, help))
    made.help = help
    return made


def unknown(kind: str, name: object, valid: Iterable[str]) -> TetrascopeError:
    """An error of a name that does not exist."""
    names = list(valid)
    near = native.nearest(str(name), names)
    help = None if near is None else f"did you mean '{near}'?"
    return error(f"no {kind} '{name}'; valid: {', '.join(names)}", help)


def make(
    kind: str, message: str, help: str | None, code: int | None, path: str | os.PathLike[str] | None
) -> Exception:
    """The exception of a native error; ``kind`` says whose matter it is."""
    if kind == "file" and code is not None and path is not None:
        # Python chooses the class by the code, such as FileNotFoundError.
        return OSError(code, os.strerror(code), os.fspath(path))
    made: Exception
    if kind == "file":
        made = OSError(message)
    elif kind == "memory":
        made = MemoryError(with_help(message, help))
    else:
        made = (DeviceError if kind == "device" else TetrascopeError)(with_help(message, help))
        made.help = help
    return made
