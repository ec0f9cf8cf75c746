"""CompoundRay's library under its old name: compound eyes and their projections."""

import itertools
import math
import os
import re
import shutil
from ctypes import c_void_p
from pathlib import Path

import numpy as np
import pytest
from compoundray_lib import (
    BLUE,
    CYAN,
    GREEN,
    GREY,
    RED,
    ROOM,
    SCENES,
    YELLOW,
    frame,
    go,
    ids,
    set_ommatidia,
    set_size,
    shader,
)

import omma

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def test_an_eye_is_sought_as_given_then_beside_the_scene(fresh, tmp_path, monkeypatch):
    folder = tmp_path / "scenes"
    folder.mkdir()
    for name in ("room.gltf", "six.eye"):
        shutil.copy(ROOM / name, folder)
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    fresh.loadGlTFscene(b"../scenes/room.gltf")
    go(fresh, "insect")
    assert fresh.getCurrentEyeDataPath() == b"../scenes/six.eye"
    assert fresh.getCurrentEyeOmmatidialCount() == 6
    (work / "six.eye").write_text("0 0 0 0 0 1 0.1 0\n0 0 0 0 1 0 0.1 0\n")
    fresh.loadGlTFscene(b"../scenes/room.gltf")
    go(fresh, "insect")
    assert fresh.getCurrentEyeDataPath() == b"six.eye"
    assert fresh.getCurrentEyeOmmatidialCount() == 2
    monkeypatch.chdir(folder)
    fresh.loadGlTFscene(b"room.gltf")
    go(fresh, "insect")
    assert fresh.getCurrentEyeDataPath() == b"six.eye"


def test_what_stands_behind_the_eighth_column_is_passed_over(fresh, tmp_path):
    shutil.copy(ROOM / "room.gltf", tmp_path)
    lines = ["0 0 0 0 0 1 0.1 0 7.5", "0 0 0 0 1 0 0.1 0 old file", "", "0 0 0 1 0 0 0.1 0"]
    (tmp_path / "six.eye").write_text("\n".join(lines) + "\n")
    fresh.loadGlTFscene(str(tmp_path / "room.gltf").encode())
    go(fresh, "insect")
    assert fresh.getCurrentEyeOmmatidialCount() == 3


def test_ids_over_four_channels(lib):
    """More than 65,536 ommatidia, so that three of the four bytes are used."""
    go(lib, "insect")
    count = 70_000
    rows = np.zeros((count, 8), np.float32)
    rows[:, 5] = -1  # backwards, but for the last
    rows[-1, 5] = 1
    lib.setOmmatidia(rows.ctypes.data_as(c_void_p), count)
    assert lib.getCurrentEyeOmmatidialCount() == count
    shader(lib, "spherical_orientationwise_ids")
    set_size(lib, 4, 4)
    picture = frame(lib)
    assert list(picture[2, 2]) == [0, 1, 17, 111]  # 69,999 = 0x1116f
    assert ids(picture)[2, 2] == count - 1
    assert ids(picture)[2, 0] == 0


def test_spherical_projections_by_brute_force(lib):
    """All three kinds of map against every ommatidium compared with every pixel."""
    rng = np.random.default_rng(5)
    directions, positions = rng.normal(size=(2, 40, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rows = np.hstack([positions, directions, np.full((40, 1), 0.01), np.zeros((40, 1))])
    go(lib, "insect")
    set_ommatidia(lib, rows)
    width, height = 50, 31
    set_size(lib, width, height)

    def pixel_direction(x, y):
        azimuth, elevation = (2 * x - 1) * np.pi, (2 * y - 1) * np.pi / 2
        return np.stack([np.sin(azimuth) * np.cos(elevation), np.sin(elevation) + 0 * azimuth,
                         np.cos(azimuth) * np.cos(elevation)], axis=-1)  # fmt: skip

    x, y = np.meshgrid(np.arange(width) / width, np.arange(height) / height)
    for name, towards in (("orientation", directions), ("position", positions)):
        shader(lib, f"spherical_{name}wise_ids")
        unit = towards / np.linalg.norm(towards, axis=1, keepdims=True)
        cosine = pixel_direction(x, y) @ unit.T
        two = np.sort(cosine, axis=-1)[..., -2:]
        sure = two[..., 1] - two[..., 0] > 1e-5  # float arithmetic may decide the others
        found = ids(frame(lib))
        assert (found == cosine.argmax(-1))[sure].all()
        assert sure.mean() > 0.95

    # The split one has no ids: the colours tell, each ommatidium's taken from single_dimension.
    shader(lib, "single_dimension")
    set_size(lib, 40, 1)
    colors = frame(lib)[0]
    shader(lib, "spherical_split_orientationwise")
    set_size(lib, width, height)
    found = frame(lib)
    right = x > 0.5
    cosine = pixel_direction(np.where(2 * x > 1, 2 * x - 1, 2 * x), y) @ directions.T
    side = np.where(right[..., None], positions[:, 0] > 0, positions[:, 0] < 0)
    side &= (x != 0.5)[..., None]
    side[..., 0] = True  # the first ommatidium belongs to both
    cosine = np.where(side, cosine, -2)
    two = np.sort(cosine, axis=-1)[..., -2:]
    sure = two[..., 1] - two[..., 0] > 1e-5
    assert (found == colors[cosine.argmax(-1)])[sure].all()


def test_an_eye_with_all_positions_in_its_centre(lib):
    """No position has a direction then; CompoundRay's comparison never leaves the first."""
    go(lib, "insect")
    set_ommatidia(lib, [(0, 0, 0, *axis, 0.1, 0) for axis in np.eye(3)])
    set_size(lib, 8, 8)
    for name in ("spherical_positionwise_ids", "spherical_positionwise"):
        shader(lib, name)
        picture = frame(lib)
        assert (picture == picture[0, 0]).all()
    assert tuple(picture[0, 0, :3]) == RED


def test_the_fast_projection_leaves_the_rest(lib):
    go(lib, "front")
    set_size(lib, 8, 2)
    background = frame(lib)
    go(lib, "vector")  # single_dimension_fast
    picture = frame(lib)
    assert (picture[1] == background[1]).all()
    assert (picture[0, 6:] == background[0, 6:]).all()
    assert [tuple(p[:3]) for p in picture[0, :6]] == [GREY, CYAN, RED, GREEN, BLUE, YELLOW]


def test_raw_samples_are_shares_of_the_mean(lib):
    """Undone, the samples' shares add up to what single_dimension shows, within 8 bits."""
    go(lib, "vector")
    samples = 50
    set_ommatidia(lib, [(0, 0, 0, 1, 0, 1, 1.2, 0), (0, 0, 0, 0, 1, 1, 0.9, 0)])
    lib.setCurrentEyeSamplesPerOmmatidium(samples)
    shader(lib, "raw_ommatidial_samples")
    set_size(lib, 2, samples)
    picture = frame(lib)
    one = int(255 * (1 / samples) ** (1 / 2.2))
    assert set(np.unique(picture[:, 0, 0])) <= {0, one, int(255 * (0.5 / samples) ** (1 / 2.2))}
    counts = [(picture[:, 0, 0] == one).sum()]
    for _ in range(20):
        counts.append((frame(lib)[:, 0, 0] == one).sum())
    assert len(set(counts)) > 5  # new samples each time
    # Half of what the first one sees is the red wall; of floor and ceiling only the floor has red.
    assert 0.3 < np.mean(counts) / samples < 0.6


def test_each_eye_has_its_own_samples(lib):
    go(lib, "insect")
    lib.setCurrentEyeSamplesPerOmmatidium(7)
    lib.changeCurrentEyeSamplesPerOmmatidiumBy(3)
    go(lib, "vector")
    assert lib.getCurrentEyeSamplesPerOmmatidium() == 1
    lib.changeCurrentEyeSamplesPerOmmatidiumBy(-3)
    assert lib.getCurrentEyeSamplesPerOmmatidium() == 1
    go(lib, "insect")
    assert lib.getCurrentEyeSamplesPerOmmatidium() == 10
    go(lib, "front")
    assert lib.getCurrentEyeSamplesPerOmmatidium() == -1
    lib.setCurrentEyeSamplesPerOmmatidium(3)  # nothing to set


def test_every_frame_has_new_samples(lib):
    go(lib, "vector")
    axis = np.array([1, 0, 1]) / math.sqrt(2)  # towards an edge of the room
    set_ommatidia(lib, [(0, 0, 0, *axis, 1.0, 0)] * 50)
    set_size(lib, 50, 1)
    frames = np.array([frame(lib)[0, :, 0] for _ in range(40)])
    assert all((a != b).any() for a, b in itertools.pairwise(frames))
    # Ommatidia are independent, too: no frame is all one colour (chance 2^-50).
    assert (frames.min(axis=1) != frames.max(axis=1)).all()


@pytest.mark.parametrize("kernel", ["compoundray", "gaussian"])
def test_the_kernel_of_the_environment(fresh, monkeypatch, kernel):
    """A wide ommatidium towards the red wall, against Omma's own renderer."""
    if kernel == "gaussian":
        monkeypatch.setenv("OMMA_COMPAT_KERNEL", "gaussian")
    else:
        monkeypatch.delenv("OMMA_COMPAT_KERNEL", raising=False)
    fresh.loadGlTFscene(str(ROOM / "room.gltf").encode())
    go(fresh, "vector")
    acceptance, samples = 1.5, 200_000
    set_ommatidia(fresh, [(0, 0, 0, 1, 0, 0, acceptance, 0)])
    fresh.setCurrentEyeSamplesPerOmmatidium(samples)
    set_size(fresh, 1, 1)
    shown = frame(fresh)[0, 0, :3] / 255
    scene = omma.load_scene(ROOM / "room.gltf")
    eye = omma.Eye(np.zeros((1, 3)), [[1.0, 0, 0]], acceptance)
    renderer = omma.Renderer(scene, eye, omma.Fixed(1 << 16), angular_sensitivity=kernel)
    expected = renderer.render(np.eye(4))[0, 0]
    # Truncation takes up to a level; 200,000 random samples err by 0.5 / sqrt(200000) = 0.0011, a
    # quarter of a level here. The kernels differ by 30 levels.
    np.testing.assert_allclose(shown, expected ** (1 / 2.2), atol=2 / 255)


def test_an_unknown_kernel_is_said(fresh, monkeypatch, capfd):
    monkeypatch.setenv("OMMA_COMPAT_KERNEL", "pillbox")
    fresh.loadGlTFscene(str(ROOM / "room.gltf").encode())
    assert "ERROR: OMMA_COMPAT_KERNEL" in capfd.readouterr().err
    assert fresh.getCameraCount() == 6


def test_the_scale_of_the_node_scales_the_eye(lib):
    """The node has scale 0.5: positions count half, and so does the focal offset."""
    go(lib, "insect")
    shader(lib, "single_dimension")
    set_size(lib, 1, 1)
    for at, color in ((17, RED), (19, None)):  # world x is 1 + at / 2; the wall is at 10
        set_ommatidia(lib, [(at, 0, 0, 1, 0, 0, 0, 0)])
        assert (tuple(frame(lib)[0, 0, :3]) == RED) == (color == RED)
    # Nearer than the offset nothing is seen: 2 * 0.5 beyond a wall 0.5 away from the position.
    set_ommatidia(lib, [(17, 0, 0, 1, 0, 0, 0, 2)])
    assert tuple(frame(lib)[0, 0, :3]) == RED
    set_ommatidia(lib, [(19, 0, 0, 1, 0, 0, 0, 4)])  # the ray starts in front of the wall, unseen
    assert tuple(frame(lib)[0, 0, :3]) != RED


def test_ommatidia_that_cannot_be(lib, capfd):
    go(lib, "insect")
    for row in ((0, 0, 0, 0, 0, 0, 0.1, 0), (math.nan, 0, 0, 0, 0, 1, 0.1, 0),
                (0, 0, 0, 0, 0, 1, 0.1, -1)):  # fmt: skip
        set_ommatidia(lib, [(0, 0, 0, 0, 0, 1, 0.1, 0), row])
        assert "ERROR: setOmmatidia, ommatidium 1" in capfd.readouterr().err
    assert lib.getCurrentEyeOmmatidialCount() == 6
    set_ommatidia(lib, [(0, 0, 0, 0, 0, 5, 100.0, 0)])  # an acceptance of all directions
    assert lib.getCurrentEyeOmmatidialCount() == 1
    go(lib, "front")
    set_ommatidia(lib, [(0, 0, 0, 0, 0, 1, 0.1, 0)])  # no eye, no effect
    assert lib.getCurrentEyeOmmatidialCount() == 0


@pytest.mark.parametrize(
    "name",
    ["natural-standin-sky.gltf", "ofstad-arena.gltf", "test-scene.gltf", "test-scene-sky.gltf",
     "env_2.gltf", "environment.glb"],
)  # fmt: skip
def test_every_camera_of_the_shared_scenes(fresh, name):
    path = SCENES / name
    if not path.exists():
        pytest.skip(f"needs {path}")
    fresh.setVerbosity(False)
    fresh.loadGlTFscene(os.fsencode(path))
    scene = omma.load_scene(path)
    assert fresh.getCameraCount() == len(scene.cameras)  # none is dropped
    set_size(fresh, 60, 40)
    for i in range(fresh.getCameraCount()):
        fresh.gotoCamera(i)
        if name.startswith("env"):  # its cameras sit in a black sphere
            fresh.setCameraPosition(0, 0, 4)
        if not fresh.isCompoundEyeActive():
            picture = frame(fresh)
            assert (picture[..., 3] == 255).all()
            assert len(np.unique(picture.reshape(-1, 4), axis=0)) > 1, "nothing is seen"
            continue
        assert fresh.getCurrentEyeOmmatidialCount() > 1
        assert Path(os.fsdecode(fresh.getCurrentEyeDataPath())).exists()
        for projection in (None, "spherical_orientationwise", "single_dimension"):
            if projection is not None:
                shader(fresh, projection)
            picture = frame(fresh)
            assert len(np.unique(picture.reshape(-1, 4), axis=0)) > 1, "nothing is seen"


def test_the_page_for_those_who_come_from_compoundray(tmp_path, monkeypatch):
    """Both scripts of examples/from_compoundray.md, run as they stand, see the same."""
    if not (SCENES / "ofstad-arena.gltf").exists():
        pytest.skip(f"needs {SCENES / 'ofstad-arena.gltf'}")
    page = (EXAMPLES / "from_compoundray.md").read_text()
    old_code, new_code = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("OMMA_COMPAT_KERNEL", raising=False)
    link = tmp_path / "build" / "make" / "lib" / "libEyeRenderer3.so"
    link.parent.mkdir(parents=True)
    link.symlink_to(omma.compat.compoundray_library())
    for name in ("ofstad-arena.gltf", "eyes"):
        (tmp_path / name).symlink_to(SCENES / name)
    old, new = {}, {}
    exec(old_code, old)
    exec(new_code, new)
    assert (tmp_path / "view.png").exists()
    shown = (255 * np.clip(new["responses"], 0, 1) ** (1 / 2.2)).astype(np.uint8)
    difference = np.abs(np.array(old["frames"]).astype(int) - shown)
    # 1,000 random samples of black and white stripes err by half a level on average, see
    # compat_reference.cpp; any other ray, colour or order of ommatidia costs tens of levels.
    assert difference.mean() < 1
