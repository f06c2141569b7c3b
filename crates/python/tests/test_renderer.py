"""What changes often rebuilds nothing, and gives what a new renderer gives."""

import threading

import numpy as np
import pytest

import tetrascope


@pytest.fixture()
def renderer(mesh, look):
    points, cells, scalars = mesh
    return tetrascope.Renderer(points, cells, None, scalars, **look)


def test_a_camera_at_a_time(mesh, look, renderer):
    points, cells, scalars = mesh
    other = {**look, "position": (-2.0, 1.0, 0.7), "size": (21, 33), "background": "white"}
    expected = tetrascope.render(points, cells, None, scalars, **other)
    first = np.asarray(renderer.render())
    camera = tetrascope.Camera((-2.0, 1.0, 0.7), (0.5, 0.5, 0.5), (0, 0, 1))
    found = renderer.render(camera, size=(21, 33), background="white")
    assert found.shape == (33, 21, 4)
    assert (np.asarray(found) == np.asarray(expected)).all()
    # And what was drawn before is drawn again.
    assert (np.asarray(renderer.render()) == first).all()
    again = renderer.render(found.camera, size=(21, 33), background="white")
    assert (np.asarray(again) == np.asarray(found)).all()


@pytest.mark.parametrize("algorithm", ["raycast-cpu", "reference"])
def test_scalars_alone(mesh, look, algorithm):
    points, cells, scalars = mesh
    renderer = tetrascope.Renderer(points, cells, None, scalars, algorithm=algorithm, **look)
    before = renderer.volume
    renderer.set_scalars(1 - scalars)
    assert renderer.volume._native.shares_geometry(before._native)
    expected = tetrascope.render(points, cells, None, 1 - scalars, algorithm=algorithm, **look)
    assert (np.asarray(renderer.render()) == np.asarray(expected)).all()
    values = np.linspace(0, 1, len(cells))
    renderer.set_scalars(values, association="cell", name="number")
    expected = tetrascope.render(points, cells, None, values, algorithm=algorithm, **look)
    assert (np.asarray(renderer.render()) == np.asarray(expected)).all()
    assert renderer.volume.fields[0]["name"] == "number"


def test_only_scalars_go_to_the_device(mesh, look, device):
    points, cells, scalars = mesh
    renderer = tetrascope.Renderer(points, cells, None, scalars, algorithm="raycast-peel", **look)
    renderer.render()
    # Between frames nothing of the volume is sent.
    assert renderer.render("+x").stats["bytes_uploaded"] == 0
    renderer.set_scalars(1 - scalars)
    expected = tetrascope.render(points, cells, None, 1 - scalars, algorithm="raycast-peel", **look)
    assert np.abs(np.asarray(renderer.render()) - np.asarray(expected)).max() < 2e-6


def test_samples_of_a_grid(look):
    samples = np.random.default_rng(1).random((5, 6, 7))
    renderer = tetrascope.Renderer(samples, spacing=0.2, **look)
    renderer.set_scalars(1 - samples)
    expected = tetrascope.render(1 - samples, spacing=0.2, **look)
    assert (np.asarray(renderer.render()) == np.asarray(expected)).all()
    with pytest.raises(tetrascope.TetrascopeError, match="samples of a grid of 5×6×7 are 7×6×5"):
        renderer.set_scalars(samples.T)


def test_transfer_functions(mesh, look, renderer):
    points, cells, scalars = mesh
    function = tetrascope.TransferFunction([(0.0, (1, 0, 0), 0.0), (1.0, (0, 1, 0), 4.0)])
    renderer.set_transfer_function(function)
    assert renderer.transfer_function == function
    plain = {k: v for k, v in look.items() if k not in ("range", "unit_distance")}
    expected = tetrascope.render(points, cells, None, scalars, transfer_function=function, **plain)
    assert (np.asarray(renderer.render()) == np.asarray(expected)).all()
    renderer.set_transfer_function(cmap="magma", range=(0.2, 0.9), unit_distance=0.3)
    expected = tetrascope.render(
        points, cells, None, scalars, **{**look, "range": (0.2, 0.9), "unit_distance": 0.3}, cmap="magma"
    )
    # Scalars are rounded to f32 in the range of the first look: some units of f32's last place.
    assert np.abs(np.asarray(renderer.render()) - np.asarray(expected)).max() < 2e-6


def test_a_look_keeps_what_is_not_of_colors(mesh, look):
    points, cells, scalars = mesh
    clip = ((0.5, 0.5, 0.5), (0, 0, 1))
    renderer = tetrascope.Renderer(points, cells, None, scalars, clip=clip, **look)
    renderer.set_transfer_function(cmap="magma", range=(0, 1), unit_distance=0.4)
    expected = tetrascope.render(points, cells, None, scalars, clip=clip, cmap="magma", **look)
    assert (np.asarray(renderer.render()) == np.asarray(expected)).all()


def test_an_error_leaves_the_renderer_as_it_was(mesh, look, renderer):
    before = np.asarray(renderer.render())
    for wrong in (
        lambda: renderer.set_scalars([1.0, 2.0]),
        lambda: renderer.set_transfer_function([(1, (1, 1, 1), 1), (0, (1, 1, 1), 1)]),
        lambda: renderer.set_transfer_function(range=(2, 1)),
        lambda: renderer.render("+w"),
        lambda: renderer.render(size=0),
    ):
        with pytest.raises(tetrascope.TetrascopeError):
            wrong()
    assert (np.asarray(renderer.render()) == before).all()


def test_several_threads_share_a_renderer(renderer):
    expected = {fit: np.asarray(renderer.render(fit)) for fit in ("+x", "-y", "+iso")}
    wrong = []

    def draw(fit):
        for _ in range(5):
            if not (np.asarray(renderer.render(fit)) == expected[fit]).all():
                wrong.append(fit)

    threads = [threading.Thread(target=draw, args=(fit,)) for fit in expected]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert wrong == []


def test_settings(mesh, look):
    points, cells, scalars = mesh
    given = dict(algorithm="raycast-cpu", settings={"stop_opacity": 0.9})
    renderer = tetrascope.Renderer(points, cells, None, scalars, **given, **look)
    assert renderer.settings["stop-opacity"] == "0.9" and renderer.algorithm == "raycast-cpu"
    with pytest.raises(tetrascope.TetrascopeError, match="no setting 'stop=1'; valid: stop-opacity=0.5…1"):
        tetrascope.Renderer(points, cells, None, scalars, settings={"stop": 1}, **look)
    with pytest.raises(tetrascope.TetrascopeError, match="did you mean 'raycast-cpu'"):
        tetrascope.Renderer(points, cells, None, scalars, algorithm="raycast_cpu", **look)


def test_what_was_chosen_is_said(mesh):
    points, cells, scalars = mesh
    picture = tetrascope.render(points, cells, None, scalars, size=16)
    said = "\n".join(picture.defaults)
    assert all(word in said for word in ("camera: fit+iso", "colormap: viridis", "unit distance:"))
    assert "[camera]" in picture.scene and "transfer_function" in picture.scene
