"""What commands say of slips: numbers that are none, folders that were missing, names of files."""

import pytest

RENDER = ("render", "scene.gltf", "--eye", "bug.eye", "--samples", "2", "-o")


@pytest.mark.parametrize(
    ("arguments", "expected", "found"),
    [
        (("render", "scene.gltf", "-o", "v.npy", "--samples", "four"), "--samples", "four"),
        (("render", "scene.gltf", "-o", "v.npy", "--gamma", "wide"), "--gamma", "wide"),
        (("render", "scene.gltf", "-o", "v.npy", "--error", "small"), "--error", "small"),
        (("eye", "make", "many", "-o", "a.eye"), "N", "many"),
    ],
)
def test_a_number_that_is_none_is_told_with_what_was_found(
    omma_command, arguments, expected, found
):
    code, _, err = omma_command(*arguments)
    assert code == 2
    assert expected in err
    assert repr(found) in err


def test_folders_that_were_made_are_told(omma_command, tmp_path):
    made = tmp_path / "nofolder" / "deep"
    code, out, err = omma_command(*RENDER, made / "v.npy", "-o", made / "v.csv")
    assert code == 0
    assert err == f"omma: made the folder {made}\n"
    assert str(made / "v.npy") in out
    code, _, err = omma_command(*RENDER, made / "v.npy")
    assert (code, err) == (0, "")
    picture = tmp_path / "pictures" / "p.png"
    code, _, err = omma_command(
        "render", "scene.gltf", "--camera", "plain", "--samples", "1", "--width", "4", "-o", picture
    )
    assert (code, err) == (0, f"omma: made the folder {picture.parent}\n")


def test_a_file_that_begins_with_a_dash_is_told_how_it_is_named(run_omma, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, err = run_omma("info", "-x.npy")
    assert code == 2
    assert "./-x.npy" not in err
    (tmp_path / "-x.npy").write_bytes(b"")
    code, _, err = run_omma("info", "-x.npy")
    assert code == 2
    assert err.endswith("for the file of that name: ./-x.npy\n")


def test_of_a_folder_it_is_told_which_may_be_given(run_omma, tmp_path):
    code, _, err = run_omma("info", tmp_path)
    assert code == 1
    assert f"{tmp_path}: is a directory, expected a file, or a folder of " in err


@pytest.mark.parametrize("command", [("info",), ("render-again", "-o", "again.npy")])
def test_a_missing_file_is_told_in_one_way(run_omma, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    first, *others = command
    assert run_omma(first, "v.npy", *others) == (
        1,
        "",
        "omma: error: v.npy: there is no such file\n",
    )
