"""Graphics cards as Python users meet them: by the tests' stand-in for one, and without any."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import omma
from omma.scene import devices

BUILT = Path(__file__).parents[2] / "build/default/tests/cpp"
STAND_IN = BUILT / "libomma_emulated_driver.so"
with_stand_in = pytest.mark.skipif(not STAND_IN.exists(), reason="the C++ tests are not built")


def run(
    *arguments, card=True, cache="", nvrtc=BUILT / "libomma_stand_in_nvrtc.so", compiles_s=0, **more
):
    """What a process prints that has the stand-in for a card, or none."""
    driver = str(STAND_IN) if card else "libno_such_driver.so.1"
    environment = {
        **os.environ,
        "OMMA_CUDA_DRIVER": driver,
        "OMMA_NVRTC": str(nvrtc),
        "STAND_IN_NVRTC": str(compiles_s),
        "OMMA_CACHE": str(cache),
    }
    return subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True, **more
    )


RENDER = """
import numpy as np, omma
from omma.light import Bands, clear_sky
scene = omma.load_scene(omma.examples.meadow())
eye = omma.eye.generate_eye(70)
lit = {"light": clear_sky(30, bands=Bands.equal(12, 400, 700)), "ultraviolet": "dark"}
for asked in ({}, lit):
    worlds = [omma.World(scene, backend=name, **asked) for name in ("portable", "cuda")]
    one, other = (omma.Renderer(w, eye, omma.Fixed(2)).render("bee") for w in worlds)
    print(worlds[1].backend, np.array_equal(one, other), one.mean() > 0)
"""


@with_stand_in
def test_a_card_gives_the_bits_of_portable(tmp_path):
    done = run("-W", "error", "-c", RENDER, cache=tmp_path)
    assert done.stdout.splitlines() == ["cuda:0 (emulated card) True True"] * 2, done.stderr
    assert list((tmp_path / "kernels").glob("*.cubin"))


@with_stand_in
def test_kernels_that_cannot_be_kept_are_told_of(tmp_path):
    cache = tmp_path / "file"
    cache.write_text("no folder")
    program = "import omma; omma.World(omma.load_scene(omma.examples.meadow()), backend='cuda')"
    done = run("-c", program, cache=cache)
    assert "UserWarning: the card's kernels are compiled by each process" in done.stderr
    assert done.returncode == 0


@with_stand_in
def test_info_says_which_card_there_is():
    done = run("-m", "omma", "info", "--devices")
    assert "cuda:0 (emulated card)" in done.stdout
    assert "backend cuda" in done.stdout
    assert "portable" in done.stdout


CHOOSE = """
import ctypes, os, omma
from omma.scene import card_check
{}
scene = omma.scene.box()
for _ in range(2):
    print(omma.World(scene).backend)
print(omma.World(scene, backend="portable").backend)
"""


@with_stand_in
def test_a_card_is_taken_by_itself(tmp_path):
    done = run("-W", "error", "-c", CHOOSE.format(""), cache=tmp_path)
    card = "cuda:0 (emulated card)"
    assert done.stdout.splitlines() == [card, card, "portable"], done.stderr


@with_stand_in
@pytest.mark.parametrize(
    ("trouble", "why"),
    [
        ("card_check._ALLOWED = -1", "it sees a small scene otherwise, by 0 of the mean"),
        (
            "ctypes.CDLL(os.environ['OMMA_CUDA_DRIVER']).emulated_fail(b'cuLaunchKernel', 2, 1)",
            "cuLaunchKernel failed: CUDA_ERROR_OUT_OF_MEMORY",
        ),
        ("os.environ['OMMA_NVRTC'] = 'libnone.so'", "libnone.so"),
    ],
)
def test_a_card_that_is_not_right_is_left_alone(trouble, why, tmp_path):
    """With a warning that says why, once."""
    done = run("-c", CHOOSE.format(trouble), cache=tmp_path)
    processor, again, _ = done.stdout.splitlines()
    assert processor == again
    assert "cuda" not in processor
    start = "UserWarning: cuda:0 (emulated card) is left alone, the processor traces the rays: "
    assert done.stderr.count(start) == 1
    assert why in done.stderr


def test_without_a_card_nothing_is_said():
    done = run("-W", "error", "-c", CHOOSE.format(""), card=False)
    assert done.returncode == 0
    assert "cuda" not in done.stdout


# With kernels that a packager has made, in the first argument.
PACKAGED = """
import sys
from pathlib import Path
import omma
from omma.scene import device_list
device_list._PACKAGED = Path(sys.argv[1])
why_not = omma.scene.devices()[1].why_not
print("NVRTC is missing" if "NVRTC" in why_not else why_not or "a card")
told = []
world = omma.World(omma.load_scene(omma.examples.meadow()), backend="cuda", progress=told.append)
print(world.backend, told[-1])
"""
PACKAGE = "import sys; from omma import _core; _core.compile_kernels(75, '', sys.argv[1])"


@with_stand_in
def test_packaged_kernels_need_no_nvrtc(tmp_path):
    package, cache = tmp_path / "package", tmp_path / "cache"
    assert run("-c", PACKAGE, package).returncode == 0
    assert len(list(package.glob("*kernel*-sm_75-nvrtc13.0.cubin"))) == 2
    done = run("-W", "error", "-c", PACKAGED, package, cache=cache, nvrtc="/nowhere")
    assert done.stdout.splitlines() == ["a card", "cuda:0 (emulated card) 1.0"], done.stderr
    assert not cache.exists()

    for file in package.iterdir():
        file.write_bytes(file.read_bytes()[:-1])
    done = run("-c", PACKAGED, package, cache=cache, nvrtc="/nowhere")
    assert done.stdout.splitlines() == ["NVRTC is missing"]
    assert "omma.Error: NVRTC, the compiler of kernels, cannot be loaded: /nowhere" in done.stderr
    done = run("-W", "error", "-c", PACKAGED, package, cache=cache)
    assert done.stdout.splitlines() == ["a card", "cuda:0 (emulated card) 1.0"], done.stderr
    assert list((cache / "kernels").glob("*.cubin"))


# Each stage as it is told, the first argument ends it.
BUILDS = """
import os, signal, sys
import omma
from omma.light import clear_sky
from omma.scene.building import build_world
stages = []
def tell(stage, done):
    if not stages or stages[-1] != stage:
        stages.append(stage)
        print(stage, flush=True)
    if stage == sys.argv[1]:
        os.kill(os.getpid(), signal.SIGINT)
mesh = omma.scene.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], material=0)
scene = omma.Scene(meshes=[mesh], materials=[omma.scene.Material()])
lit = {"light": clear_sky(30), "lighting": "baked", "bake": omma.scene.Bake(0.5, cache=False)}
build_world(scene, tell, backend="cuda", ultraviolet="dark", **lit)
"""
COMPILES = "Compiling kernels for the card, once"


@with_stand_in
def test_compiling_is_told_of(tmp_path):
    done = run("-c", BUILDS, "", cache=tmp_path, compiles_s=0.4)
    stages = [stage.split(" (")[0] for stage in done.stdout.splitlines()]
    assert stages[0] == COMPILES, done.stderr
    assert COMPILES in stages[stages.index("Baking light") :]  # what gathers is another program
    assert stages[-1] == "Baking light"


@with_stand_in
def test_ctrl_c_ends_compiling(tmp_path):
    done = run("-c", BUILDS, COMPILES, cache=tmp_path / "cache", compiles_s=60, timeout=30)
    assert done.stdout.splitlines() == [COMPILES]
    assert done.stderr.splitlines()[-1] == "KeyboardInterrupt"
    assert not (tmp_path / "cache").exists()


def test_info_says_why_there_is_none():
    done = run("-m", "omma", "info", "--devices", card=False)
    assert done.returncode == 0
    assert "cannot be used: cuda: expected NVIDIA's driver, found none" in done.stdout


def test_a_world_without_a_card_is_refused():
    program = "import omma; omma.World(omma.load_scene(omma.examples.meadow()), backend='cuda')"
    done = run("-c", program, card=False)
    assert "omma.Error: cuda: expected NVIDIA's driver, found none" in done.stderr


def test_info_takes_a_file_or_devices():
    for arguments in ([], ["--devices", omma.examples.meadow()]):
        done = run("-m", "omma", "info", *arguments, card=False)
        assert done.returncode != 0
        assert "--devices" in done.stderr


def test_the_processor_is_always_there():
    processor = devices()[0]
    assert "portable" in processor.backends
    assert processor.why_not == ""
