"""What the command line says of bad input names options as they are typed."""

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.cli.typed import as_typed

SKY = "clear_sky sun_elevation_deg=30"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("typed")
    omma.scene.save_scene(made / "grey.glb", omma.scene.plane((4, 4), (0.5, 0.5, 0.5)))
    (made / "mesh.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    omma.save_eye(made / "bee.csv", make_eye(60))
    return made


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["render", "grey.glb", "--light", SKY], "--ultraviolet: expected what surfaces reflect"),
        (["render", "grey.glb", "--light", SKY], "such as --ultraviolet dark (nothing), or"),
        (["view", "grey.glb", "--light", SKY], "such as --ultraviolet dark (nothing), or"),
        (
            ["render", "grey.glb", "--light", SKY, "--ultraviolet", "0,0,1"],
            '--ultraviolet: expected "dark", "as_blue" or a reflectance from 0 to 1, found',
        ),
        (
            ["render", "grey.glb", "--light", f"{SKY} ultraviolet=dark", "--ultraviolet", "dark"],
            "--ultraviolet: not together with the word ultraviolet= of --light",
        ),
        (
            ["render", "grey.glb", "--light", f"{SKY} ultraviolet=grey"],
            "--light: ultraviolet: expected",
        ),
        (["render", "grey.glb", "--ultraviolet", "dark"], "--ultraviolet: goes with --light or"),
        (["render", "grey.glb", "--scene-unit", "ell"], "grey.glb: --scene-unit: expected mm"),
        (["view", "grey.glb", "--scene-up", "x"], "grey.glb: --scene-up: expected one of y, z"),
        (["render", "mesh.obj", "--scene-unit", "ell"], "mesh.obj: --scene-unit: expected mm"),
        (["view", "mesh.obj", "--scene-unit", "ell"], "mesh.obj: --scene-unit: expected mm"),
        (["view", "mesh.obj", "--scene-up", "x"], "mesh.obj: --scene-up: expected one of y, z"),
        (["measure", "aliasing", "mesh.obj", "--scene-up", "x"], "mesh.obj: --scene-up: expected"),
        (["render", "mesh.obj", "--unit", "ell"], "error: --unit: expected mm"),
        (
            ["render", "grey.glb", "--camera", "1", "--position", "0", "0", "0"],
            "--camera and --position: only one",
        ),
        (
            ["render", "grey.glb", "--side-by-side", "--projection", "facets"],
            "--projection: --side-by-side has its own",
        ),
        (["render", "grey.glb", "--receptors", "--shared", "4"], "--shared: not for receptors"),
        (["measure", "speed", "grey.glb", "--rays", "1,0"], "--rays: expected 1 to"),
    ],
)
def test_of_scenes(run_omma, monkeypatch, folder, words, said):
    if words[0] == "view":
        pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
        words = [*words, "--no-browser", "--port", "0"]
    monkeypatch.chdir(folder)
    output = {"render": ["-o", "out.npy"], "view": [], "measure": ["-o", "out.csv"]}[words[0]]
    code, _, err = run_omma(*words, "--eye", "bee.csv", *output)
    assert code == 1
    assert said in err.splitlines()[-1]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["eye", "make", "50", "--radius-mm", "-1"], "--radius-mm: expected a number above 0, "),
        (["eye", "make", "50", "--semi-axes-mm", "1", "0", "1"], "--semi-axes-mm: expected"),
        (["eye", "make", "--dphi", "200"], "--dphi: expected degrees above 0 and below 180, found"),
        (["eye", "make", "50", "--skew", "-4"], "--skew: expected a number above 0, found -4"),
        (["eye", "make", "--facet-um", "-2"], "--facet-um: expected a number above 0, found -2"),
        (["eye", "scale", "bee.csv", "--mean-radius-mm", "0"], "--mean-radius-mm: expected"),
        (["eye", "place", "bee.csv", "--yaw", "nan"], "--yaw: expected finite numbers, found nan"),
        (["eye", "acceptance", "bee.csv", "--degrees", "-1"], "--degrees: expected degrees from 0"),
        (["eye", "split", "bee.csv", "--overlap-mm", "-1"], "--overlap-mm: expected a number of"),
        (["eye", "species", "unicorn"], "NAME: expected one of honeybee_worker"),
        (["eye", "plot", "--species", "unicorn"], "--species: expected one of honeybee_worker"),
        (["light", "show", "--sun", "100"], "--sun: expected -8 to 90, found 100"),
        (["light", "show", "--sun", "9", "--ozone", "1"], "--ozone: expected 200 to 450"),
        (
            ["light", "show", "--time", "2026-06-01T12:00:00", "--place", "0,0"],
            "--time: expected one such as 2026-06-21T12:00:00+02:00, found",
        ),
    ],
)
def test_of_eyes_and_skies(run_omma, monkeypatch, folder, words, said):
    if "--sun" in words or "plot" in words:
        pytest.importorskip("matplotlib")
    monkeypatch.chdir(folder)
    ending = ".csv" if words[0] == "eye" and words[1] != "plot" else ".png"
    code, _, err = run_omma(*words, "-o", f"out{ending}")
    assert code == 1
    assert said in err.splitlines()[-1]
    assert not list(folder.glob("out*"))


def test_a_word_behind_a_switch(run_omma, folder, monkeypatch):
    monkeypatch.chdir(folder)
    code, _, err = run_omma("render", "grey.glb", "--standard-error", "true", "-o", "out.npy")
    assert code == 2
    assert "switches take no word behind them" in err


def test_reflectance_and_word_are_those_of_the_light(run_omma, monkeypatch, folder):
    monkeypatch.chdir(folder)
    arguments = ["render", "grey.glb", "--eye", "bee.csv", "--position", 0, 1, 0]
    for k, words in enumerate(
        (
            ["--light", f"{SKY} bands=4", "--ultraviolet", "0.3"],
            ["--light", f"{SKY} bands=4 ultraviolet=0.3"],
            ["--light", f"{SKY} bands=4", "--ultraviolet", "dark"],
        )
    ):
        code, _, err = run_omma(*arguments, *words, "-o", f"lit{k}.npy")
        assert (code, err) == (0, "")
    by_option, by_word, dark = (np.load(f"lit{k}.npy") for k in range(3))
    assert np.array_equal(by_option, by_word)
    assert by_option[..., 0].mean() > dark[..., 0].mean()


def test_names_of_files_and_words_stay():
    options = {"--look-at", "--unit", "--light", "--standard-error"}
    for message in (
        "look_at.csv: expected a file, found none",
        "a/unit: expected a file, found none",
        "light-year.png: expected an ending",
        "the standard_error=0.1 of x.npy",
    ):
        kept = message.replace("standard_error=0.1", "--standard-error 0.1")
        assert as_typed(message, options) == kept
    assert as_typed("x: needs look_at and standard_error=True", options) == (
        "x: needs --look-at and --standard-error"
    )


# Words of a light that are also options of a command that has --light.
@pytest.mark.parametrize(
    ("command", "words", "said"),
    [
        ("show", "haze_kind=dust", "--light: haze_kind: expected one of rural, urban"),
        ("show", "sun_elevation=30", ", height_m, haze_kind, unit, bands,"),
        ("show", "haze_kind=urban haze_kind=urban", "--light: haze_kind: is said twice"),
        ("show", "unit=lux", "--light: unit: expected"),
        ("render", "unit=lux", "--light: unit: expected"),
        ("render", "sun_elevation=30", ", height_m, haze_kind, unit, bands,"),
        ("render", "lighting=fog", "--light: lighting: expected"),
    ],
)
def test_words_of_a_light_stay_words(run_omma, monkeypatch, folder, command, words, said):
    monkeypatch.chdir(folder)
    light = ["--light", f"clear_sky sun_elevation_deg=30 {words}"]
    start = ["light", "show"] if command == "show" else ["render", "grey.glb", "--eye", "bee.csv"]
    if command == "show":
        pytest.importorskip("matplotlib")
    code, _, err = run_omma(*start, *light, "-o", "out.png")
    assert code == 1
    assert said in err.splitlines()[-1]
    assert "--" not in err.splitlines()[-1].replace("--light: ", "", 1)


def test_words_of_a_light_stay_words_in_the_middle_of_a_message():
    options = {"--light", "--look-at", "--unit", "--ultraviolet"}
    of_light = 'light: height_m: expected unit="watts" and look_at'
    assert as_typed(of_light, options) == f"--{of_light}"
    assert as_typed(f"a/unit.glb: {of_light}", options) == f"a/unit.glb: --{of_light}"
    assert as_typed("baked light: expected look_at", options) == "baked light: expected --look-at"
    assert as_typed(of_light, {"--unit"}) == "light: height_m: expected --unit watts and look_at"


def test_calls_of_python_stay():
    options = {"--look-at", "--unit", "--standard-error"}
    call = 'omma.f.g(a, numpy.load(look_at), standard_error=True, unit="mm")'
    message = f"unit: expected standard_error=True, {call} or {call} and look_at"
    assert as_typed(message, options) == (
        f"--unit: expected --standard-error, {call} or {call} and --look-at"
    )
