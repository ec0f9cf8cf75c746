"""Graphics cards as Python users meet them: by the tests' stand-in for one, and without any."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from dataset_jobs import write_job

import omma
from omma.base.backend_names import without_ordinals
from omma.scene import devices

BUILT = Path(__file__).parents[2] / "build/default/tests/cpp"
STAND_IN = BUILT / "libomma_emulated_driver.so"
with_stand_in = pytest.mark.skipif(not STAND_IN.exists(), reason="the C++ tests are not built")


def run(
    *arguments,
    card=True,
    cards=1,
    cache="",
    nvrtc=BUILT / "libomma_stand_in_nvrtc.so",
    compiles_s=0,
    **more,
):
    """What a process prints that has the stand-in for so many cards, or none."""
    driver = str(STAND_IN) if card else "libno_such_driver.so.1"
    environment = {
        **os.environ,
        "OMMA_CUDA_DRIVER": driver,
        "OMMA_EMULATED_CARDS": str(cards),
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


SEVERAL = """
import copy, pickle
import numpy as np, omma
scene = omma.load_scene(omma.examples.meadow())
eye = omma.eye.generate_eye(70)
poses = omma.poses_from_angles([[0.1 * k, 1, 0.1 * k] for k in range(5)], [[20, 5, 0]] * 5)
def rendered(world):
    return omma.Renderer(world, eye, omma.Fixed(2)).render(poses)
first = omma.World(scene, backend="cuda", devices=[0])
both = omma.World(scene, backend="cuda", devices=[0, 1])
for world in (both, pickle.loads(pickle.dumps(both))):
    print(world.backend, np.array_equal(rendered(first), rendered(world)))
renderer = omma.Renderer(scene, eye, omma.Fixed(2), backend="cuda", devices=np.array([1]))
print(renderer.backend, np.array_equal(renderer.render(poses), rendered(first)))
for wrong, backend in (([2], "cuda"), ([0, 0], "cuda"), ([-1], "cuda"), ([0], "portable"),
                       (1, "cuda"), ([0.5], "cuda"), ("01", "cuda")):
    try:
        omma.World(scene, backend=backend, devices=wrong)
    except (omma.Error, TypeError) as error:
        print(type(error).__name__, error)
try:
    omma.Renderer(both, eye, devices=[0])
except omma.Error as error:
    print(error)
"""


@with_stand_in
def test_several_cards_share_a_render(tmp_path):
    done = run("-W", "error", "-c", SEVERAL, cards=2, cache=tmp_path)
    both = "cuda:0 (emulated card), cuda:1 (emulated card)"
    found = done.stdout.splitlines()
    assert found[:3] == [f"{both} True", f"{both} True", "cuda:1 (emulated card) True"], done.stderr
    expected = (
        f"Error devices: expected ordinals below 2, as the driver has {both}; found 2",
        "Error devices: expected each card once, found 0 twice",
        "Error devices: expected 0 to 65536, found -1",
        'Error devices: expected none with the backend "portable"',
        "TypeError devices: expected ordinals of cards such as [0, 1], found int 1",
        "TypeError devices: expected a whole number, found float 0.5",
        "TypeError devices: expected ordinals of cards such as [0, 1], found str '01'",
        "devices: the world that is given has its own",
    )
    assert len(found) == 3 + len(expected), done.stderr
    for line, words in zip(found[3:], expected):
        assert line.startswith(words)


@with_stand_in
def test_the_command_line_takes_several_cards(tmp_path):
    eye = tmp_path / "one.eye"
    omma.save_eye(eye, omma.eye.generate_eye(20))
    path = tmp_path / "path.csv"
    path.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0\n0,1,1,9,0,0\n")
    render = ("-m", "omma", "render", omma.examples.meadow(), "--eye", eye, "--path", path)
    by_card = (*render, "--samples", "2", "--backend", "cuda")
    for name, cards in (("first", ()), ("both", ("--device", "0", "--device", "1"))):
        done = run(*by_card, *cards, "-o", tmp_path / f"{name}.npy", cards=2, cache=tmp_path)
        assert done.returncode == 0, done.stderr
    both = tmp_path / "both.npy"
    assert both.read_bytes() == (tmp_path / "first.npy").read_bytes()
    again = tmp_path / "again.npy"
    done = run("-m", "omma", "render-again", both, "-o", again, cards=2, cache=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "last bits" not in done.stdout + done.stderr
    assert again.read_bytes() == both.read_bytes()
    done = run(*by_card, "--device", "2", "-o", again, cards=2, cache=tmp_path)
    assert done.returncode != 0
    assert "--device: expected ordinals below 2" in done.stderr


@with_stand_in
def test_a_data_set_goes_on_with_other_cards_of_the_kind(tmp_path):
    pytest.importorskip("zarr")
    for cards in ("[0, 1]", "[1]", "[2]"):
        rendering = f'backend = "cuda"\ndevices = {cards}'
        job = write_job(tmp_path / "of", rendering=rendering)
        done = run("-m", "omma", "dataset", "run", job, cards=2, cache=tmp_path)
        assert (done.returncode == 0) == (cards != "[2]"), done.stderr
    assert "devices: expected ordinals below 2" in done.stderr
    assert omma.datasets.verify(tmp_path / "of/job.zarr").damaged == ()


def test_kinds_of_cards_are_what_counts():
    one, two = "cuda:0 (H100)", "cuda:0 (H100), cuda:3 (H100)"
    assert without_ordinals(one) == without_ordinals(two) == "cuda (H100)"
    assert without_ordinals("cuda:1 (A100), cuda:0 (H100)") == "cuda (A100), cuda (H100)"
    assert without_ordinals("embree 3.13.5") == "embree 3.13.5"


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
            "driver = ctypes.CDLL(os.environ['OMMA_CUDA_DRIVER'])\n"
            "driver.emulated_fail(b'cuLaunchKernel', 2, 1, -1)",
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


DRIVER_FAILS = (
    "UserWarning: a graphics card is left alone, the processor traces the rays: cuda: cuInit failed"
)
FORK = """
import ctypes, os, omma
scene = omma.scene.box()
print(omma.World(scene).backend)
# What NVIDIA's driver says in a child of a process that has used it.
ctypes.CDLL(os.environ["OMMA_CUDA_DRIVER"]).emulated_fail(b"cuInit", 3, 10, -1)
for _ in range(2):
    print(omma.World(scene).backend)
"""


@with_stand_in
def test_a_child_says_that_it_cannot_use_the_card(tmp_path):
    done = run("-c", FORK, cache=tmp_path)
    parent, child, again = done.stdout.splitlines()
    assert parent == "cuda:0 (emulated card)"
    assert child == again
    assert "cuda" not in child
    assert done.stderr.count(DRIVER_FAILS) == 1
    assert "start workers by spawn" in done.stderr


@with_stand_in
def test_a_driver_that_fails_is_told(tmp_path):
    trouble = (
        "driver = ctypes.CDLL(os.environ['OMMA_CUDA_DRIVER'])\n"
        "driver.emulated_fail(b'cuInit', {}, 1000, -1)"
    )
    done = run("-c", CHOOSE.format(trouble.format(999)), cache=tmp_path)
    assert done.stderr.count(DRIVER_FAILS) == 1, done.stderr
    # CUDA_ERROR_NO_DEVICE: there is a driver, and nothing for it to drive.
    done = run("-W", "error", "-c", CHOOSE.format(trouble.format(100)), cache=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


def test_without_a_card_nothing_is_said():
    done = run("-W", "error", "-c", CHOOSE.format(""), card=False)
    assert done.returncode == 0
    assert "cuda" not in done.stdout


@with_stand_in
def test_info_says_all_cards():
    done = run("-m", "omma", "info", "--devices", cards=3)
    for ordinal in range(3):
        assert f"cuda:{ordinal} (emulated card)" in done.stdout


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
