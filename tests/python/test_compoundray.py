"""CompoundRay's library under its old name: loading, calls in any order, cameras, messages."""

import ctypes
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from ctypes import CDLL, c_ubyte, c_void_p

import numpy as np
import pytest
from compoundray_lib import EVERY_FUNCTION, GREY, ROOM, declare, frame, go, position, set_size
from numpy.ctypeslib import ndpointer

import omma


def test_the_path_is_that_of_a_library():
    assert omma.compat.compoundray_library().endswith("libEyeRenderer3.so")


def test_only_and_all_functions_are_exported(fresh):
    for name in [*EVERY_FUNCTION, "_Z16getWindowPointerv"]:
        assert hasattr(fresh, name), name
    if shutil.which("nm") is None:
        pytest.skip("there is no nm to list the symbols with")
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", omma.compat.compoundray_library()],
        check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    assert {line.split()[-1] for line in listed.splitlines()} == {
        *EVERY_FUNCTION,
        "_Z16getWindowPointerv",
    }


def test_nothing_happens_when_it_is_loaded(tmp_path):
    code = f"import ctypes; ctypes.CDLL({omma.compat.compoundray_library()!r}); print('loaded')"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "loaded\n", "")


@pytest.mark.parametrize("name", EVERY_FUNCTION)
def test_no_function_crashes_in_a_fresh_process(name):
    """Called without arguments the registers hold what they hold: nulls are given instead."""
    code = f"""
import ctypes, sys
lib = ctypes.CDLL({omma.compat.compoundray_library()!r})
zeros = [ctypes.c_void_p(0)] * 4 + [ctypes.c_float(0)] * 9
lib.{name}(*zeros)
lib.{name}(*zeros)
lib.renderFrame()
lib.stop()
lib.{name}(*zeros)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_before_a_scene(fresh, capfd):
    assert fresh.getCameraCount() == 0
    assert not fresh.isCompoundEyeActive()
    assert fresh.getCurrentEyeSamplesPerOmmatidium() == -1
    assert fresh.getCurrentEyeOmmatidialCount() == 0
    assert fresh.getCurrentEyeDataPath() == b""
    fresh.getFramePointer.restype = ndpointer(dtype=c_ubyte, shape=(400, 400, 4))
    assert not fresh.getFramePointer().any()
    fresh.renderFrame()
    assert "ERROR: there is no scene" in capfd.readouterr().err
    fresh.nextCamera()
    assert fresh.getCurrentCameraName() == b"Default Camera"
    assert fresh.getCameraCount() == 1
    assert position(fresh) == [0, 0, 0]


def test_a_camera_too_far_away_is_an_error(lib, capfd):
    # Embree ends the process at rays from beyond 1.84e18 m.
    for camera in range(lib.getCameraCount()):
        lib.gotoCamera(camera)
        lib.setCameraPosition(2e18, 0, 0)
        lib.renderFrame()
        assert "within 1e18 m" in capfd.readouterr().err.replace("e+18", "e18")


def test_bad_files_are_errors_and_change_nothing(lib, tmp_path, capfd):
    broken = tmp_path / "broken.gltf"
    broken.write_text("{")
    for path in (b"no-such.gltf", str(broken).encode(), b"", None):
        lib.loadGlTFscene(path)
        assert "ERROR: Failed to load GLTF scene" in capfd.readouterr().err
    assert lib.getCameraCount() == 6
    set_size(lib, 3, 3)
    go(lib, "front")
    assert (frame(lib)[1, 1] == [*GREY, 255]).all()


def test_messages_as_theirs(fresh, tmp_path, capfd):
    fresh.loadGlTFscene(str(ROOM / "room.gltf").encode())
    err = capfd.readouterr().err
    assert 'WARNING: Unable to open "no-such.eye", attempting to open at relative address' in err
    assert "ERROR" in err
    assert 'Unable to open "' + str(ROOM / "no-such.eye") in err
    target = tmp_path / "frame.ppm"
    fresh.setRenderSize(20, 10)
    fresh.renderFrame()
    fresh.getFramePointer()
    fresh.saveFrameAs(str(target).encode())
    fresh.stop()
    out = capfd.readouterr().out.splitlines()
    assert out[0] == "[PyEye] Resizing rendering buffer to (20, 10)."
    assert out[1].startswith("[PyEye] Rendered frame in ")
    assert out[1].endswith("ms.")
    assert out[2] == "[PyEye] Retrieving frame pointer..."
    assert out[3] == f"[PyEye] Saved render as '{target}'"
    assert out[4] == "[PyEye] Cleaning eye renderer resources."


def test_verbosity_silences_them(fresh, capfd):
    fresh.setVerbosity(False)
    fresh.loadGlTFscene(str(ROOM / "room.gltf").encode())
    fresh.setRenderSize(20, 10)
    fresh.renderFrame()
    fresh.getFramePointer()
    fresh.isInsideHitGeometry(0, 0, 0, b"nothing")
    captured = capfd.readouterr()
    assert captured.out == ""
    assert 'WARNING: No hitbox with the given name "nothing"' in captured.err
    fresh.setVerbosity(True)
    fresh.renderFrame()
    assert capfd.readouterr().out.startswith("[PyEye]")


def test_cameras_in_the_order_of_nodes(lib):
    names = []
    for i in range(lib.getCameraCount()):
        lib.gotoCamera(i)
        assert lib.getCurrentCameraIndex() == i
        names.append(lib.getCurrentCameraName().decode())
    # Roots by index whatever the order the scene lists them in; the eye without a file is left out.
    assert names == ["nested", "front", "insect", "panorama", "map", "vector"]
    lib.nextCamera()
    assert lib.getCurrentCameraIndex() == 0
    lib.previousCamera()
    assert lib.getCurrentCameraIndex() == 5
    for index, expected in ((6, 0), (-1, 5), (-7, 5), (2**31 - 1, (2**31 - 1) % 6)):
        lib.gotoCamera(index)
        assert lib.getCurrentCameraIndex() == expected
    assert lib.gotoCameraByName(b"map")
    assert lib.getCurrentCameraIndex() == 4
    assert not lib.gotoCameraByName(b"node of map")  # names of cameras, not of nodes
    assert lib.getCurrentCameraIndex() == 0


def test_from_several_threads(lib):
    """ctypes lets other threads run meanwhile; calls take turns."""
    set_size(lib, 20, 20)
    go(lib, "front")

    def work(k):
        for _ in range(10):
            lib.setCurrentEyeShaderName(b"single_dimension")
            lib.renderFrame()
            (lib.nextCamera if k % 2 else lib.previousCamera)()
        return lib.getCameraCount()

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(work, range(4))) == [6] * 4


def test_it_lives_beside_the_package_itself(lib, renderer):
    """Both hold an engine; neither meets the other's symbols."""
    responses = renderer.render(np.eye(4))
    go(lib, "insect")
    set_size(lib, 4, 4)
    frame(lib)
    assert (renderer.render(np.eye(4)) == responses).all()


def test_a_pointer_to_the_window():
    lib = declare(CDLL(omma.compat.compoundray_library()))
    assert lib.getWindowPointer() is None
    mangled = ctypes.cast(lib._Z16getWindowPointerv, c_void_p).value
    assert mangled is not None
