"""The command line: what it writes and prints, and one clear line for everything that is wrong."""

import csv
import re

import numpy as np
import pytest
from conftest import write_gltf
from PIL import Image

import omma


@pytest.fixture
def rendered(omma_command, tmp_path):
    """Runs ``omma render scene.gltf ARGUMENTS -o x.npy`` and returns the array."""

    def run(*arguments, eye="bug.eye"):
        eyes = ("--eye", eye) if eye else ()
        path = tmp_path / "x.npy"
        code, _, err = omma_command("render", "scene.gltf", *eyes, *arguments, "-o", path)
        assert (code, err) == (0, "")
        return np.load(path)

    return run


def test_three_outputs_of_one_render(omma_command, tmp_path):
    folder = tmp_path / "new" / "folder"
    outputs = [folder / f"x.{suffix}" for suffix in ("png", "npy", "csv")]
    named = [part for path in outputs for part in ("-o", path)]
    code, out, err = omma_command("render", "scene.gltf", "--eye", "bug.eye", *named)
    assert (code, err) == (0, f"omma: made the folder {folder}\n")
    for path in outputs:
        assert f"wrote      {path}" in out
    for words in ("ommatidia  60", "960 (16 per ommatidium", "frames/s", "embree", "threads"):
        assert words in out
    array = np.load(outputs[1])
    assert array.shape == (1, 60, 3)
    with outputs[2].open() as file:
        rows = list(csv.DictReader(file))
    assert [np.float32(row["g"]) for row in rows] == array[0, :, 1].tolist()
    assert outputs[0].read_bytes()[:4] == b"\x89PNG"
    written = sorted(path.name for path in outputs[0].parent.iterdir())
    assert written == ["x.csv", "x.json", "x.npy", "x.png"]


def test_command_equals_library(rendered, scene, eye):
    renderer = omma.Renderer(scene, eye)
    assert (rendered() == renderer.render("plain")).all()  # the scene's first camera
    assert (rendered("--camera", "insect") == renderer.render("insect")).all()
    assert (rendered("--position", 1, 2, -3, "--look-at", -1, 0, 5) ==
            renderer.render(omma.look_at((1, 2, -3), (-1, 0, 5)))).all()  # fmt: skip
    assert (rendered("--position", 1, 2, -3) ==
            renderer.render(omma.look_at((1, 2, -3), (1, 2, -4)))).all()  # fmt: skip


def test_settings(rendered, scene, eye):
    def expected(*sampling, **settings):
        return omma.Renderer(scene, eye, *sampling, **settings).render("plain")

    assert (rendered("--samples", 3, "--seed", 8) == expected(omma.Fixed(3), seed=8)).all()
    assert (
        rendered("--angular-sensitivity", "pillbox") == expected(angular_sensitivity="pillbox")
    ).all()
    assert (rendered("--points", "random") == expected(points="random")).all()
    assert (rendered("--threads", 1) == expected()).all()
    for text, background in [
        ("1,0.5,-0", omma.Background.constant((1, 0.5, 0))),
        ("simple_sky", omma.Background.simple_sky()),
        ("test_pattern", omma.Background.test_pattern()),
    ]:
        assert (rendered("--background", text) == expected(background=background)).all()


def test_the_old_name_of_angular_sensitivity(omma_command, tmp_path):
    """It works with a warning, which no help mentions."""
    paths = [tmp_path / "old.npy", tmp_path / "new.npy"]
    command = ("render", "scene.gltf", "--eye", "bug.eye", "-o")
    code, _, err = omma_command(*command, paths[0], "--kernel", "pillbox")
    assert (code, err) == (
        0,
        "omma: warning: --kernel is called --angular-sensitivity now; the old name works until "
        "0.2\n",
    )
    assert omma_command(*command, paths[1], "--angular-sensitivity", "pillbox")[0] == 0
    assert (np.load(paths[0]) == np.load(paths[1])).all()
    code, _, err = omma_command(*command, paths[0], "--kernel", "box")
    assert code != 0
    assert "expected one of own, gaussian, pillbox, compoundray, found 'box'" in err
    assert "--kernel" not in omma_command("render", "--help")[1]


def test_background_from_an_image(rendered, tmp_path):
    omma.save_png(tmp_path / "white.png", np.full((4, 8, 3), 255, np.uint8))
    up = rendered("--background", tmp_path / "white.png").max()
    assert up == pytest.approx(1, abs=1e-6)


def test_a_cameras_own_eye(rendered, scene, files):
    own = omma.load_eye(files / "bug.eye", unit="m")
    expected = omma.Renderer(scene, own).render("insect")
    assert (rendered("--camera", "insect", eye=None) == expected).all()
    assert (rendered(eye=None) == expected).all()  # the first camera that has one
    in_mm = omma.Renderer(scene, omma.load_eye(files / "bug.eye")).render("insect")
    assert (rendered("--unit", "mm", eye=None) == in_mm).all()


def test_a_cameras_own_eye_beside_the_scene(omma_command, files, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # bug.eye is not here, but beside the scene
    code, out, _ = omma_command("render", files / "scene.gltf", "-o", tmp_path / "a.npy")
    assert code == 0
    assert str(files / "bug.eye") in out


def test_units(rendered):
    mm, um = rendered("--unit", "mm"), rendered("--unit", "um")
    assert (rendered("--unit", "0.001") == mm).all()
    assert (um != mm).any()


def test_path_with_standard_errors_and_pictures(omma_command, scene, eye, flight, tmp_path):
    path = tmp_path / "flight.csv"
    lines = ["x,y,z,yaw_deg,pitch_deg,roll_deg"]
    lines += [f"{x},1,{-x},{20 * x},0,0" for x in range(3)]
    path.write_text("\n".join(lines))
    outputs = [tmp_path / name for name in ("a.npy", "a.csv", "a.png")]
    named = [part for output in outputs for part in ("-o", output)]
    code, out, err = omma_command(
        *("render", "scene.gltf", "--eye", "bug.eye", "--path", path, "--standard-error", *named)
    )
    assert (code, err) == (0, "")
    expected, errors = omma.Renderer(scene, eye).render(omma.load_poses(path), standard_error=True)
    assert (np.load(outputs[0]) == expected).all()
    assert (np.load(tmp_path / "a.error.npy") == errors).all()
    header = outputs[1].read_text().split("\n")[0]
    assert header.endswith("r,g,b,r_error,g_error,b_error")
    pictures = [f"a_000{i}.png" for i in range(3)]
    assert sorted(p.name for p in tmp_path.glob("*.png")) == pictures
    assert "poses      3" in out
    assert "a.error.npy" in out
    assert "a_0002.png" in out


def test_many_poses_go_through_memory_in_pieces(monkeypatch, rendered, scene, eye, tmp_path):
    monkeypatch.setattr("omma.job.pieces._PIECE_BYTES", 60 * 12 * 4)  # four poses
    path = tmp_path / "flight.csv"
    rows = "".join(f"{x / 5},1,0,0,0,0,1\n" for x in range(11))
    path.write_text("x,y,z,qx,qy,qz,qw\n" + rows)
    whole = omma.Renderer(scene, eye).render(omma.load_poses(path))
    assert (rendered("--path", path) == whole).all()


def test_all_files_are_named_but_those_of_a_long_series(omma_command, tmp_path):
    outputs = [tmp_path / name for name in ("a.npy", "b.npy", "a.csv", "b.csv", "a.png", "b.png")]
    named = [part for output in outputs for part in ("-o", output)]
    flights = tmp_path / "path.csv"
    lines = [f"{0.1 * i},1,0,0,0,0" for i in range(8)]
    flights.write_text("\n".join(["x,y,z,yaw_deg,pitch_deg,roll_deg", *lines]))
    words = ("render", "scene.gltf", "--eye", "bug.eye", "--standard-error", *named)
    code, out, _ = omma_command(*words)
    assert code == 0
    wrote = [line.split(maxsplit=1)[1] for line in out.splitlines() if line.startswith("wrote")]
    assert sorted(wrote) == sorted(map(str, tmp_path.glob("[ab].*")))
    code, out, _ = omma_command(*words, "--path", flights)
    wrote = [line.split(maxsplit=1)[1] for line in out.splitlines() if line.startswith("wrote")]
    for stem in "ab":
        shown = [one for one in wrote if one.endswith(".png") and f"{stem}_0" in one]
        assert [one[-8:] for one in shown] == ["0000.png", "0001.png", "0002.png", "0007.png"]
    assert sum("4 more" in one for one in wrote) == 2
    assert str(tmp_path / "b.error.npy") in wrote


def test_two_eyes_side_by_side(omma_command, files, tmp_path):
    arguments = ["render", "scene.gltf", "--eye", "left.eye", "--eye", "right.eye"]
    code, out, _ = omma_command(
        *(*arguments, "--side-by-side", "--width", 64, "-o", tmp_path / "a.png"),
        *("-o", tmp_path / "a.npy"),
    )
    assert code == 0
    assert "ommatidia  80" in out
    head = omma.eye.merge_eyes([omma.load_eye(files / f"{s}.eye") for s in ("left", "right")])
    expected = omma.picture.framed(head, np.load(tmp_path / "a.npy"), 64, apart=True)
    omma.save_png(tmp_path / "b.png", expected)
    # The same picture; files of series are packed in another way.
    a, b = (np.asarray(Image.open(tmp_path / name)) for name in ("a.png", "b.png"))
    np.testing.assert_array_equal(a, b)


def test_warnings_go_to_stderr(omma_command, tmp_path):
    odd = {"name": "ground", "mesh": 0, "extensions": {"EXT_something_odd": {}}}
    write_gltf(tmp_path / "odd.gltf", extensionsUsed=["EXT_something_odd"], nodes=[odd])
    code, out, err = omma_command("info", tmp_path / "odd.gltf")
    assert code == 0
    assert "EXT_something_odd" in out
    code, _, err = omma_command(
        *("render", tmp_path / "odd.gltf", "--eye", "bug.eye", "-o", tmp_path / "a.npy")
    )
    assert code == 0
    assert err.startswith("omma: warning: ")
    assert "EXT_something_odd" in err


def test_version_and_help(omma_command):
    assert omma_command("--version") == (0, f"omma {omma.__version__}\n", "")
    code, out, _ = omma_command("info", "-h")
    assert code == 0
    assert "omma info honeybee.eye" in out


WRONG_USAGE = [
    (["render", "scene.gltf"], "output"),
    (["render", "-o", "a.npy"], "scene"),
    (["render", "scene.gltf", "-o", "a.npy", "--samples", "many"], "--samples"),
    (["render", "scene.gltf", "-o", "a.npy", "--angular-sensitivity", "box"], "gaussian"),
    (["render", "scene.gltf", "-o", "a.npy", "--position", "1", "2"], "--position"),
    (["render", "scene.gltf", "-o", "a.npy", "--position", "0", "0", "-o", "b.npy"], "3 numbers"),
    (["render", "scene.gltf", "-o", "a.npy", "--nonsense"], "--nonsense"),
    (["paint"], "paint"),
    # Each camera is rendered as it is, by rays of a number.
    *(
        (["render-cameras", "scene.gltf", "-o", "all", *words], words[0])
        for words in (
            ["--eye", "bug.eye"],
            ["--camera", "plain"],
            ["--position", "1", "2", "3"],
            ["--path", "x.csv"],
            ["--scene-unit", "mm"],
            ["--standard-error"],
            ["--receptors"],
            ["--error", "0.1"],
            ["--relative-error", "0.1"],
            ["--shared", "4"],
            ["--noise", "new_every_frame"],
            ["--side-by-side"],
            ["--resume"],
        )
    ),
    # The file says all of it.
    *(
        (["render-again", "out.npy", "-o", "again.npy", *words], words[0])
        for words in (["--seed", "0"], ["--samples", "4"], ["--light", "clear_sky"])
    ),
]


@pytest.mark.parametrize(("arguments", "word"), WRONG_USAGE)
def test_wrong_usage(omma_command, arguments, word):
    code, out, err = omma_command(*arguments)
    assert code == 2
    assert out == ""
    assert err.startswith("omma: error: ")
    assert err.count("\n") == 1
    assert word.lower() in err.lower()


RENDER = ["render", "scene.gltf", "--eye", "bug.eye", "-o", "OUT/a.npy"]
PICTURE = ["render", "scene.gltf", "--camera", "plain", "-o", "OUT/a.npy"]
ALL = ["render-cameras", "scene.gltf", "-o", "OUT/all"]
BAD_INPUT = [
    (["render", "no.gltf", "--eye", "bug.eye", "-o", "OUT/a.npy"], "no.gltf"),
    (["render", "scene.gltf", "--eye", "no.eye", "-o", "OUT/a.npy"], "no.eye"),
    (["render", "OUT", "--eye", "bug.eye", "-o", "OUT/a.npy"], "director"),
    (["render", "scene.gltf", "--eye", "OUT", "-o", "OUT/a.npy"], "director"),
    (["render", "bug.eye", "--eye", "bug.eye", "-o", "OUT/a.npy"], "bug.eye: expected a scene"),
    (["render", "scene.gltf", "--eye", "scene.gltf", "-o", "OUT/a.npy"], "scene.gltf: has no eyes"),
    ([*RENDER, "--camera", "nobody"], "nobody"),
    (["render", "scene.gltf", "--camera", "2", "-o", "OUT/a.npy"], '0 "plain", 1 "insect"'),
    ([*PICTURE, "-o", "OUT/a.csv"], "plain"),
    ([*PICTURE, "--standard-error"], "error: --standard-error: "),
    ([*PICTURE, "--projection", "mollweide"], "projection"),
    ([*PICTURE, "--side-by-side"], "error: --side-by-side: "),
    ([*PICTURE, "--width", "0"], "width"),
    ([*PICTURE, "--height", "40000"], "height"),
    ([*PICTURE, "--samples", "0"], "samples"),
    ([*PICTURE, "-o", "OUT"], "ending in"),
    ([*RENDER, "-o", "OUT/a.png", "--projection", "flat"], "mollweide"),
    ([*RENDER, "-o", "OUT/a.png", "--projection", "facets", "--side-by-side"], "projection"),
    ([*ALL, "--ultraviolet", "dark"], "--ultraviolet: goes with --light"),
    ([*ALL, "-o", "OUT/b"], "one folder"),
    (["render-cameras", "scene.gltf", "-o", "OUT/a.png"], "one folder"),
    (["render-cameras", "scene.gltf", "-o", "scene.gltf"], "scene.gltf"),
    ([*ALL, "--projection", "flat"], "mollweide"),
    ([*ALL, "--samples", "0"], "samples"),
    (["render-cameras", "eyeless.gltf", "-o", "OUT/all"], "nowhere.eye"),
    (["render", "eyeless.gltf", "-o", "OUT/a.png"], "nowhere.eye"),
    (["render-cameras", "empty.gltf", "-o", "OUT/all"], "no camera"),
    (["render", "empty.gltf", "-o", "OUT/a.png"], "no camera"),
    ([*RENDER, "--camera", "plain", "--position", "1", "2", "3"], "only one of them"),
    ([*RENDER, "--look-at", "1", "2", "3"], "--look-at: needs"),
    ([*RENDER, "--position", "1", "2", "3", "--look-at", "1", "2", "3"], "target"),
    ([*RENDER, "--position", "nan", "2", "3"], "finite"),
    ([*RENDER, "--path", "no.csv"], "no.csv"),
    ([*RENDER, "--samples", "0"], "samples"),
    ([*RENDER, "--samples", "100000000"], "samples"),
    ([*RENDER, "--seed", "-1"], "seed"),
    ([*RENDER, "--threads", "-1"], "threads"),
    ([*RENDER, "--threads", "4000"], "--threads: expected 0 (all) to "),
    ([*RENDER, "--error", "0"], "omma: error: --error: expected"),
    ([*RENDER, "-o", "OUT/a.png", "--projection", "mollweid"], "did you mean 'mollweide'?"),
    (["eye", "plot", "bug.eye", "--property", "facets", "-o", "OUT/a.png"], "--property: expected"),
    (["eye", "species", "megalopta", "-o", "OUT/a.csv"], "megalopta has numbers"),
    (["eye", "species", "honeybee_work", "-o", "OUT/a.csv"], "did you mean 'honeybee_worker'?"),
    (["eye", "species", "bumblebee", "--assume", "honeybee"], "--assume: expected with -o"),
    (
        ["eye", "species", "bumblebee", "--assume", "dog", "-o", "OUT/a.csv"],
        "--assume: expected one of honeybee_worker",
    ),
    (
        ["eye", "species", "bumblebee", "--assume", "calliphora", "-o", "OUT/a.csv"],
        "--assume: expected an animal whose absorption is known (honeybee_worker)",
    ),
    ([*RENDER, "--background", "1,2"], "background"),
    ([*RENDER, "--background", "1,2,x"], "background"),
    ([*RENDER, "--background", "scene.gltf"], "scene.gltf"),
    ([*RENDER, "--unit", "inch"], "unit"),
    ([*RENDER, "-o", "OUT/a.gif"], "a.gif"),
    ([*RENDER, "-o", "OUT/./a.npy"], "twice"),
    ([*RENDER, "-o", "OUT/a.png", "--width", "0"], "width"),
    ([*RENDER, "-o", "OUT/a.png", "--gamma", "0"], "gamma"),
    ([*RENDER, "-o", "scene.gltf/a.png"], "scene.gltf"),
    (["info", "no.gltf"], "no.gltf"),
    (["info", "no.eye"], "no.eye"),
    (["info", "OUT"], "director"),
    (["info", "bug.eye", "--unit", "-3"], "unit"),
]


@pytest.mark.parametrize(("arguments", "word"), BAD_INPUT)
def test_bad_input_is_one_line_and_leaves_nothing(omma_command, tmp_path, arguments, word):
    arguments = [argument.replace("OUT", str(tmp_path)) for argument in arguments]
    code, out, err = omma_command(*arguments)
    assert code == 1
    assert out == ""
    assert err.startswith("omma: error: ")
    assert err.count("\n") == 1
    assert word in err
    assert list(tmp_path.iterdir()) == []


def broken_scenes(folder):
    """Name of a scene file that is broken, and a word that its error has to have."""
    good = write_gltf(folder / "good.gltf").read_text()
    broken = {
        "empty.gltf": ("", "empty.gltf"),
        "cut.gltf": (good[: len(good) // 2], "cut.gltf"),
        "text.glb": ("not a scene at all", "text.glb"),
        "past.gltf": (good.replace('"byteLength": 12', '"byteLength": 1200'), "past.gltf"),
        "huge.gltf": (good.replace('"count": 4', f'"count": {1 << 40}'), "huge.gltf"),
        "type.gltf": (good.replace("5126", "999"), "type.gltf"),
        "index.gltf": (good.replace('"count": 6, "type": "SCALAR"', '"count": 9'), "index.gltf"),
        "required.gltf": (
            good.replace('"nodes": [{', '"extensionsRequired": ["EXT_no"], "nodes": [{', 1),
            "EXT_no",
        ),
        "outside.gltf": (
            re.sub(r'"uri": "[^"]*"', '"uri": "../../etc/passwd"', good), "outside.gltf"
        ),
    }  # fmt: skip
    for name, (text, word) in broken.items():
        (folder / name).write_text(text)
        yield name, word


def test_broken_scenes(omma_command, tmp_path):
    for name, word in broken_scenes(tmp_path):
        for command in (["info"], ["render", "--eye", "bug.eye", "-o", tmp_path / "a.npy"]):
            code, out, err = omma_command(command[0], tmp_path / name, *command[1:])
            assert (code, out) == (1, ""), name
            assert err.startswith("omma: error: "), name
            assert err.count("\n") == 1, name
            assert name in err, name
            assert word in err, name
            assert not (tmp_path / "a.npy").exists()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0 0 0 0 0 1 0.1\n", ", line 1"),
        ("0 0 0 0 0 1 0.1 0\n0 0 0 0 0 0 0.1 0\n", ", line 2"),
        ("0 0 0 0 0 1 -0.1 0\n", ", line 1"),
        ("0 0 nan 0 0 1 0.1 0\n", ", line 1"),
        ("0 0 x 0 0 1 0.1 0\n", ", line 1"),
    ],
)
def test_broken_eyes(omma_command, tmp_path, text, words):
    (tmp_path / "bad.eye").write_text(text)
    for command in (["info"], ["render", "scene.gltf", "-o", tmp_path / "a.npy", "--eye"]):
        code, out, err = omma_command(*command, tmp_path / "bad.eye")
        assert (code, out) == (1, "")
        assert "bad.eye" + words in err
        assert err.count("\n") == 1
