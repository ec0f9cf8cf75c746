"""What tests of the window into the eye share."""

import time
import urllib.error
import urllib.request

import numpy as np

from omma.view.command import Sources
from omma.view.poses import HeadPose

LEVEL = HeadPose((0.3, 1.2, 4.0), yaw_deg=12.5, pitch_deg=-20.0)
ROLLED = HeadPose((0.3, 1.2, 4.0), yaw_deg=12.5, pitch_deg=-20.0, roll_deg=33.0)


def sources(folder):
    return Sources(str(folder / "ground.gltf"), (str(folder / "plain.csv"),))


def wait_for(condition, seconds=60.0):
    """Waits for what another thread does; fails where it never does."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def rotations(count):
    rng = np.random.default_rng(3)
    for _ in range(count):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        matrix = np.eye(4)
        matrix[:3, :3] = turn * np.sign(np.linalg.det(turn))
        matrix[:3, 3] = rng.normal(size=3)
        yield matrix


def ask(port, path="/", method="GET", **headers):
    """Status and body of a request."""
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", method=method)
    for name, value in headers.items():
        request.add_header(name, value)
    try:
        with urllib.request.urlopen(request, timeout=20) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()
