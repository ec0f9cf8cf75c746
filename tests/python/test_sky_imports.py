"""A sky imports nothing that takes longer than the sky."""

import subprocess
import sys


def test_a_sky_needs_no_scipy():
    code = (
        "import sys, omma; omma.light.clear_sky(30, bands=omma.light.Bands.equal(2)); "
        "print(sorted(name for name in sys.modules if name.startswith('scipy')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
