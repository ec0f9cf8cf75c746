"""``omma eye convert``, and eyes of every format in the other commands."""

import numpy as np
import pytest
from conftest import make_eye
from test_eye_files_import import grid, oda_file

import omma


def rich_eye():
    return make_eye(60).replace(facet_diameter_m=2e-5)


@pytest.mark.parametrize("suffix", ["csv", "gltf", "glb"])
def test_there_and_back(tmp_path, monkeypatch, run_omma, suffix):
    monkeypatch.chdir(tmp_path)
    omma.save_eye("a.csv", rich_eye())
    assert run_omma("eye", "convert", "a.csv", "-o", f"b.{suffix}")[0] == 0
    code, out, err = run_omma("eye", "convert", f"b.{suffix}", "-o", "c.csv")
    assert (code, err) == (0, "")
    assert "60 ommatidia" in out
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "c.csv").read_bytes()


def test_what_an_eye_file_would_lose(tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    omma.save_eye("a.csv", rich_eye())
    code, _, err = run_omma("eye", "convert", "a.csv", "-o", "a.eye")
    assert code == 1
    assert "facet diameters (60 of 60 ommatidia)" in err
    assert "--lossy" in err
    assert not (tmp_path / "a.eye").exists()
    with pytest.warns(UserWarning, match="a.eye: lost: facet diameters"):
        code, _, _ = run_omma("eye", "convert", "a.csv", "-o", "a.eye", "--lossy")
    assert code == 0
    assert len(omma.load_eye("a.eye")) == 60


def test_measurements(tmp_path, monkeypatch, run_omma):
    monkeypatch.chdir(tmp_path)
    lens, normal = grid(8)
    oda_file(tmp_path / "oda.csv", lens, normal)
    code, out, err = run_omma(
        "eye", "convert", "oda.csv", "--from", "oda", "-o", "fly.csv", "--acceptance-deg", "5"
    )
    assert code == 0, err
    assert "acceptance 5°" in out
    np.savetxt("lenses.csv", lens, delimiter=",")
    np.savetxt("cones.csv", lens - 60 * normal, delimiter=",")
    command = ["eye", "convert", "lenses.csv", "--from", "lens-cone", "-o", "bee.glb"]
    code, _, err = run_omma(*command, "--cones", "cones.csv", "--ahead=0,1,0", "--up=0,0,1")
    assert code == 0, err
    assert f"Matched {len(lens)} lenses" in err
    eye = omma.load_eye("bee.glb")
    expected = np.stack([normal[:, 0], normal[:, 2], -normal[:, 1]], axis=1)
    assert eye.axis == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(
    "options",
    [
        ["--cones", "b.csv"],
        ["--from", "lens-cone"],
        ["--from", "oda", "--cones", "b.csv"],
        ["--from", "oda", "--degrees"],
        ["--from", "oda", "--ahead=1,2"],
        ["--from", "oda", "--acceptance-deg", "1", "--acceptance-ratio", "1"],
        ["--up=0,0,1"],
        ["--degrees"],
        ["--head", "x"],
    ],
)
def test_options_that_do_not_go_together(tmp_path, monkeypatch, run_omma, options):
    monkeypatch.chdir(tmp_path)
    omma.save_eye("a.csv", rich_eye())
    code, _, err = run_omma("eye", "convert", "a.csv", "-o", "b.csv", *options)
    assert code == 1
    assert err.startswith("omma: error: ")
    assert not (tmp_path / "b.csv").exists()


@pytest.mark.parametrize("suffix", ["csv", "gltf", "glb"])
def test_every_command_takes_every_format(tmp_path, monkeypatch, run_omma, files, suffix):
    monkeypatch.chdir(tmp_path)
    omma.save_eye(f"a.{suffix}", rich_eye())
    code, out, err = run_omma("info", f"a.{suffix}")
    assert code == 0, err
    assert "60" in out
    for name in (f"a.{suffix}", "a.eye"):
        omma.save_eye(name, rich_eye(), lossy=True)
        code, _, err = run_omma(
            "render", files / "scene.gltf", "--eye", name, "-o", f"{name}.npy", "--seed", "1"
        )
        assert code == 0, err
    # The .eye file's positions are rounded to nine digits, which are all of a float32.
    assert (np.load(f"a.{suffix}.npy") == np.load("a.eye.npy")).all()
