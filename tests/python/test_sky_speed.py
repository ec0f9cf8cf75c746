"""What a sky's time goes to: no other threads, and no imports that take longer than the sky."""

import subprocess
import sys
import time

import omma


def test_a_sky_keeps_to_its_thread():
    few = omma.light.Bands.equal(4, 400, 700)
    # An azimuth between the map's columns, so that none is like another.
    make = lambda turn: omma.light.clear_sky(11.5, sun_azimuth_deg=12.3 + turn, bands=few)  # noqa: E731
    make(0)  # reads the tables
    everything, own = time.process_time(), time.thread_time()
    for turn in (1, 2, 3):
        make(turn)
    own = time.thread_time() - own
    # Threads of a large product that wait for each other had taken 0.6 of it on two cores, and made
    # it many times as long on a machine with other work. Allowed is what clocks are off by.
    assert time.process_time() - everything - own < 0.1 * own + 0.02


def test_a_sky_needs_no_scipy():
    code = (
        "import sys, omma; omma.light.clear_sky(30, bands=omma.light.Bands.equal(2)); "
        "print(sorted(name for name in sys.modules if name.startswith('scipy')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
