"""Other threads run while something is drawn, and Ctrl-C interrupts it."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import tetrascope

# A picture that takes minutes: the ground truth, of 4096² pixels.
LONG = dict(n_cells=200_000, algorithm="reference", size=4096)


def test_other_threads_run_meanwhile():
    renderer = tetrascope.Renderer("sphere", n_cells=20_000, algorithm="reference", size=256)
    drawing, counted, drawn = threading.Event(), [0], threading.Event()

    def count():
        drawing.wait()
        while not drawn.is_set():
            counted[0] += 1
            time.sleep(0.001)  # gives the lock away, and waits for it again

    thread = threading.Thread(target=count)
    thread.start()
    # No thread is made to give the lock away, so this one does only where it does by itself.
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    try:
        drawing.set()
        before = counted[0]
        renderer.render()
        during = counted[0] - before
    finally:
        sys.setswitchinterval(interval)
        drawn.set()
    thread.join()
    assert during > 0


INTERRUPTED = f"""
import os, signal, sys, threading, tetrascope
# Who starts this may have had the signal ignored, and hands that on.
signal.signal(signal.SIGINT, signal.default_int_handler)
renderer = tetrascope.Renderer("sphere", **{LONG!r})
# The signal comes once the main thread draws: this one runs when the lock is free.
timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
timer.start()
try:
    renderer.render()
except KeyboardInterrupt:
    print("interrupted", flush=True)
    # Another renderer draws meanwhile, and this one once its frame has ended, which is soon.
    print(tetrascope.render("sphere", n_cells=100, size=4).shape, flush=True)
    small = renderer.render(size=8)
    fresh = tetrascope.render("sphere", **{LONG | dict(size=8)!r})
    print(bool((small == fresh).all() and small.any()), flush=True)
else:
    print("drawn")
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of Unix")
def test_an_interrupt_ends_the_call_and_the_program(tmp_path):
    script = tmp_path / "interrupted.py"
    script.write_text(INTERRUPTED)
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=600)
    assert run.stdout.splitlines() == ["interrupted", "(4, 4, 4)", "True"], run.stderr
    assert run.returncode == 0, run.stderr


@pytest.mark.skipif(os.name != "posix", reason="signals of Unix")
def test_without_a_handler_the_program_ends_by_the_signal(tmp_path):
    script = tmp_path / "ended.py"
    script.write_text(INTERRUPTED.replace("except KeyboardInterrupt:", "except ZeroDivisionError:"))
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=600)
    assert run.returncode in (-signal.SIGINT, 130) and "KeyboardInterrupt" in run.stderr


def test_errors_of_threads_are_exceptions():
    # What happens on the thread that works arrives here.
    with pytest.raises(tetrascope.TetrascopeError):
        tetrascope.render(np.zeros((3, 3, 3)), direction=np.zeros((3, 3)))
