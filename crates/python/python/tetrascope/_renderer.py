"""Drawing, once or often."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from . import _options as options_
from . import _tetrascope as native
from . import _transfer_function
from ._options import LOOK, METHOD, VIEW, VOLUME
from ._picture import Picture, picture_of
from ._transfer_function import TransferFunction
from ._volume import Volume

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import ColorOptions, FrameOptions, RenderOptions


class Renderer:
    """A renderer that keeps what lasts, for many pictures of one volume.

    Takes what :func:`render` takes. What changes often costs little: :meth:`render` with another
    camera rebuilds nothing, :meth:`set_transfer_function` touches no geometry, and
    :meth:`set_scalars` sends scalars alone.

    A renderer may be used from several threads, one at a time; others wait.
    """

    def __init__(
        self,
        volume: Any,
        cells: Any = None,
        celltypes: Any = None,
        scalars: Any = None,
        **options: Unpack[RenderOptions],
    ) -> None:
        options_.check(options, VOLUME, LOOK, VIEW, METHOD)
        self._volume = options_.volume_of(volume, (cells, celltypes, scalars), options)
        self._look = options_.part(options, LOOK)
        self._scene = options_.scene_of(self._volume, self._look, options_.part(options, VIEW))
        algorithm = str(options.get("algorithm") or options_.DEFAULT_ALGORITHM)
        settings = options_.settings_of(options.get("settings"))
        self._native = native.Renderer(self._volume._native, self._scene, algorithm, settings)
        self._settings = dict(self._native.settings)

    def render(self, camera: Any = None, **view: Unpack[FrameOptions]) -> Picture:
        """Draws a picture: (height, width, 4) of float32, premultiplied linear RGBA.

        ``camera`` and the other parameters are those of :func:`render`; what is left out is as it
        was when the renderer was made. Nothing is rebuilt.
        """
        given: dict[str, Any] = dict(view)
        options_.check(given, VIEW)
        if camera is not None:
            given["camera"] = camera
        scene = self._scene
        if options_.part(given, VIEW):
            place, image = options_.view_of(given)
            written = json.dumps({"camera": place, "image": image})
            scene = scene.with_view(self._volume._native, written)
        return self._drawn(scene)

    def _drawn(self, scene: native.Scene) -> Picture:
        drawn = self._native.render(scene)
        return picture_of(
            drawn,
            scene,
            self._native.algorithm,
            self._settings,
            self._native.adapter,
            self._volume.notes,
        )

    def set_scalars(
        self, scalars: Any, association: str | None = None, name: str = "scalars"
    ) -> None:
        """Takes other scalars on the same mesh, or other samples of the same grid.

        (n,) for points or (m,) for cells, or (nx, ny, nz) for a grid. Colors, opacities and
        camera stay as they are.
        """
        self.set_volume(self._volume.with_scalars(scalars, association, name))

    def set_volume(self, volume: Any, field: str | None = None) -> None:
        """Takes another volume, such as the next time step. Where a mesh shares its geometry with
        the one before (:meth:`Volume.with_scalars`, :func:`load_steps`) only scalars are sent.
        Colors, opacities and camera stay as they are.
        """
        if not isinstance(volume, Volume) or field is not None:
            volume = Volume(volume, field=field)
        self._native.reload(volume._native)
        self._volume = volume

    def set_transfer_function(
        self, transfer_function: Any = None, **look: Unpack[ColorOptions]
    ) -> None:
        """Takes other colors and opacities: a :class:`TransferFunction`, or what :func:`render`
        takes of ``cmap``, ``range``, ``opacity`` and ``unit_distance``; also ``clip``,
        ``isovalues`` and the others of a look. What is left out is chosen from the volume, but
        optical model, clip planes, surfaces, lights and depth cue stay as they are.
        """
        given: dict[str, Any] = dict(look)
        options_.check(given, LOOK)
        if transfer_function is not None:
            given["transfer_function"] = transfer_function
        lasting = ("optical_model", "isovalues", "clip", "depth_cue", "ambient", "lights")
        kept = {name: self._look[name] for name in lasting if name in self._look}
        given = kept | options_.part(given, LOOK)
        scene = options_.scene_of(self._volume, given, None, self._scene)
        self._native.restyle(scene)
        self._scene, self._look = scene, given

    @property
    def volume(self) -> Volume:
        """What is drawn."""
        return self._volume

    @property
    def transfer_function(self) -> TransferFunction:
        """Colors and extinctions as they are drawn."""
        return _transfer_function.of_scene(self._scene)

    @property
    def algorithm(self) -> str:
        """The algorithm's name."""
        return self._native.algorithm

    @property
    def settings(self) -> dict[str, str]:
        """All settings of the algorithm."""
        return dict(self._settings)

    @property
    def adapter(self) -> str | None:
        """The graphics adapter in words; ``None`` if the CPU draws."""
        return self._native.adapter

    @property
    def scene(self) -> str:
        """The scene with nothing left out, as TOML, which the command line reads, too."""
        return self._scene.to_toml()

    @property
    def defaults(self) -> list[str]:
        """What was chosen because it was not given, one line each."""
        return self._scene.defaults

    def __repr__(self) -> str:
        return f"<tetrascope.Renderer: {self.algorithm}, {self._volume.description}>"


def render(
    volume: Any,
    cells: Any = None,
    celltypes: Any = None,
    scalars: Any = None,
    **options: Unpack[RenderOptions],
) -> Picture:
    """Draws a volume: an array (height, width, 4) of float32, premultiplied linear RGBA.

    The volume is what :class:`Volume` takes, or one: ``render(points, cells, celltypes,
    scalars)``, ``render(samples, spacing=…)``, ``render("mesh.vtu", field=…)``, or an object of
    PyVista, VTK or meshio. All that is left out is chosen from the volume, and
    :attr:`Picture.defaults` says what was chosen.
    """
    return Renderer(volume, cells, celltypes, scalars, **options).render()


def _documented() -> None:
    """Adds the descriptions of all parameters to what takes them."""
    groups = (options_.ColorOptions, options_.FrameOptions, options_.MethodOptions)
    text = "\n\n".join((group.__doc__ or "").strip() for group in groups)
    render.__doc__ = f"{(render.__doc__ or '').strip()}\n\n    {text}\n"


_documented()
