"""CompoundRay's library for the tests: loaded with a state of its own, and the helpers that its
scripts have, too. The scene is tests/compat/room.gltf, see compat_test.c there."""

import math
import shutil
from ctypes import (
    CDLL,
    POINTER,
    Structure,
    byref,
    c_bool,
    c_char_p,
    c_double,
    c_float,
    c_int,
    c_size_t,
    c_ubyte,
    c_void_p,
)
from pathlib import Path

import numpy as np
from conftest import DATA
from numpy.ctypeslib import ndpointer

import omma

ROOM = Path(__file__).resolve().parents[1] / "compat"
SCENES = DATA / "compound-ray" / "scenes"
GREY = (186,) * 3  # trunc(255 * 0.5 ** (1 / 2.2))
CYAN, RED, GREEN, BLUE, YELLOW = (0, 255, 255), (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0)
# fmt: off
EVERY_FUNCTION = [
    "setVerbosity", "loadGlTFscene", "stop", "setRenderSize", "renderFrame", "displayFrame",
    "saveFrameAs", "getFramePointer", "getFrame", "getCameraCount", "nextCamera",
    "previousCamera", "getCurrentCameraIndex", "getCurrentCameraName", "gotoCamera",
    "gotoCameraByName", "setCameraPosition", "getCameraPosition", "setCameraLocalSpace",
    "rotateCameraAround", "rotateCameraLocallyAround", "translateCamera",
    "translateCameraLocally", "resetCameraPose", "setCameraPose", "isCompoundEyeActive",
    "setCurrentEyeSamplesPerOmmatidium", "getCurrentEyeSamplesPerOmmatidium",
    "changeCurrentEyeSamplesPerOmmatidiumBy", "getCurrentEyeOmmatidialCount", "setOmmatidia",
    "getCurrentEyeDataPath", "setCurrentEyeShaderName", "isInsideHitGeometry",
    "getGeometryMaxBounds", "getGeometryMinBounds", "getWindowPointer",
]
# fmt: on


class Float3(Structure):
    _fields_ = [("x", c_float), ("y", c_float), ("z", c_float)]

    def values(self):
        return np.array([self.x, self.y, self.z])


class Packet(Structure):
    _fields_ = [
        (name, c_float) for name in ["px", "py", "pz", "dx", "dy", "dz", "acceptance", "offset"]
    ]


def declare(lib):
    """Argument and result types, where they are not int."""
    types = {
        "setVerbosity": ([c_bool], None),
        "loadGlTFscene": ([c_char_p], None),
        "saveFrameAs": ([c_char_p], None),
        "renderFrame": ([], c_double),
        "getFrame": ([c_void_p], None),
        "getCameraCount": ([], c_size_t),
        "getCurrentCameraIndex": ([], c_size_t),
        "getCurrentCameraName": ([], c_char_p),
        "gotoCameraByName": ([c_char_p], c_bool),
        "setCameraPosition": ([c_float] * 3, None),
        "getCameraPosition": ([POINTER(c_float)] * 3, None),
        "setCameraLocalSpace": ([c_float] * 9, None),
        "rotateCameraAround": ([c_float] * 4, None),
        "rotateCameraLocallyAround": ([c_float] * 4, None),
        "translateCamera": ([c_float] * 3, None),
        "translateCameraLocally": ([c_float] * 3, None),
        "setCameraPose": ([c_float] * 6, None),
        "isCompoundEyeActive": ([], c_bool),
        "getCurrentEyeSamplesPerOmmatidium": ([], c_int),
        "getCurrentEyeOmmatidialCount": ([], c_size_t),
        "setOmmatidia": ([c_void_p, c_size_t], None),
        "getCurrentEyeDataPath": ([], c_char_p),
        "setCurrentEyeShaderName": ([c_char_p], None),
        "isInsideHitGeometry": ([c_float] * 3 + [c_char_p], c_bool),
        "getGeometryMaxBounds": ([c_char_p], Float3),
        "getGeometryMinBounds": ([c_char_p], Float3),
        "getWindowPointer": ([], c_void_p),
    }
    for name, (arguments, result) in types.items():
        getattr(lib, name).argtypes = arguments
        getattr(lib, name).restype = result
    return lib


def fresh_library(folder):
    """The library as a new process finds it: a copy has a state of its own."""
    copy = folder / "libEyeRenderer3.so"
    shutil.copy(omma.compat.compoundray_library(), copy)
    return declare(CDLL(str(copy)))


def load_room(lib):
    lib.setVerbosity(False)
    lib.loadGlTFscene(str(ROOM / "room.gltf").encode())


def set_size(lib, width, height):
    lib.setRenderSize(width, height)
    lib.getFramePointer.restype = ndpointer(dtype=c_ubyte, shape=(height, width, 4))


def frame(lib):
    assert lib.renderFrame() > 0
    return np.copy(lib.getFramePointer())


def go(lib, name):
    assert lib.gotoCameraByName(name.encode())


def position(lib):
    values = [c_float(math.nan) for _ in range(3)]
    lib.getCameraPosition(*[byref(value) for value in values])
    return [value.value for value in values]


def shader(lib, name):
    lib.setCurrentEyeShaderName(name.encode())


def ids(picture):
    r, g, b, a = (picture[..., k].astype(np.uint32) for k in range(4))
    return r << 24 | g << 16 | b << 8 | a


def set_ommatidia(lib, rows):
    packets = (Packet * len(rows))(*[Packet(*row) for row in rows])
    lib.setOmmatidia(packets, len(rows))


def read_ppm(path):
    magic, size, depth, pixels = path.read_bytes().split(b"\n", 3)
    assert (magic, depth) == (b"P6", b"255")
    width, height = map(int, size.split())
    return np.frombuffer(pixels, np.uint8).reshape(height, width, 3)
