"""The add-on for Blender: inside of Blender as a module (bpy), beside Omma and Cycles.

bpy wants an older NumPy than the other tests, so it has an environment of its own,
`scripts/blender_addon --tests`; blender_side.py is what runs there. What needs no Blender, the
process that the add-on starts and the files that it adds to, is tested everywhere.
"""

import importlib.util
import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import omma

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "blender" / "omma_blender"
SIDE = Path(__file__).with_name("blender_side.py")
EYE = ROOT / "examples" / "honeybee_worker_left.eye"
# A point of Blender's, x right, y ahead, z up, in the frame of glTF: x right, y up, -z ahead.
GLTF_FROM_BLENDER = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float)


def module(name):
    """A file of the add-on that needs no Blender."""
    spec = importlib.util.spec_from_file_location(f"omma_blender_{name}", SOURCE / f"{name}.py")
    made = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = made  # dataclasses look there
    spec.loader.exec_module(made)
    return made


@pytest.fixture(scope="session")
def package():
    return module("package")


@pytest.fixture(scope="session")
def archive():
    made = subprocess.run(
        ["bash", "scripts/blender_addon"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    return ROOT / made.stdout.split()[-1]


# Without Blender.


def test_the_zip_is_an_extension_of_the_packages_version(archive):
    with zipfile.ZipFile(archive) as zipped:
        names = zipped.namelist()
        manifest = zipped.read("blender_manifest.toml").decode()
    assert archive.name == f"omma_blender-{omma.__version__}.zip"
    assert f'version = "{omma.__version__}"' in manifest
    assert {"__init__.py", "LICENSE", "worker.py"} <= set(names)
    assert sorted(one for one in names if one.endswith(".py")) == sorted(
        one.name for one in SOURCE.glob("*.py")
    )
    first = archive.read_bytes()
    subprocess.run(["bash", "scripts/blender_addon"], cwd=ROOT, check=True, capture_output=True)
    assert archive.read_bytes() == first


def test_the_package_answers_what_it_offers(package):
    known = package.ask(sys.executable, "facts")
    assert known["version"] == omma.__version__
    assert known["species"] == omma.species.names()
    assert known["projections"] == list(omma.picture.PROJECTIONS)
    assert known["materials"] == list(omma.scene.natural_materials())


def test_projections_offered_are_those_there_are():
    text = (SOURCE / "properties.py").read_text(encoding="utf-8")
    listed = text[text.index("PROJECTIONS = (") : text.index("FIELD =")]
    offered = {word.strip('"') for word in listed.replace(",", " ").replace(")", " ").split('"')}
    # Samples are no responses: there is no picture of responses in raw_ommatidial_samples.
    assert set(omma.picture.PROJECTIONS) - offered == {"raw_ommatidial_samples"}


@pytest.mark.parametrize("name", ["honeybee_worker_left.eye", "from a species"])
def test_an_eye_is_handed_over_with_its_bits_and_copied_for_scenes(package, tmp_path, name):
    if name.endswith(".eye"):
        source, wanted = {"file": str(EYE), "unit": "mm"}, omma.load_eye(EYE)
    else:
        source, wanted = {"species": "drosophila"}, omma.species.make("drosophila").eye
    arrays = tmp_path / "eye.npz"
    said = package.ask(
        sys.executable, "eye", arrays=str(arrays), copy=str(tmp_path / "copy"), **source
    )
    assert said["ommatidia"] == len(wanted)
    with np.load(arrays) as eye:
        for key in ("position_m", "axis", "acceptance_angle_rad", "eye_id"):
            np.testing.assert_array_equal(eye[key], getattr(wanted, key))
    copy = omma.load_eye(said["copy"], "m")
    assert Path(said["copy"]).suffix == (".eye" if name.endswith(".eye") else ".csv")
    np.testing.assert_array_equal(copy.position_m, wanted.position_m)
    np.testing.assert_array_equal(copy.axis, wanted.axis)


def test_the_extras_of_a_natural_material_are_read_as_that_material(package, tmp_path):
    said = package.ask(sys.executable, "material", name="grass blade")
    path = tmp_path / "grass.glb"
    omma.scene.save_scene(path, omma.scene.plane((1, 1)))
    gltf_file = module("gltf_file")
    opened = gltf_file.read_gltf(path)
    opened.document["materials"][0]["extras"] = {"omma": said["extras"]}
    gltf_file.write_gltf(path, opened)
    read = omma.load_scene(path).materials[0]
    wanted = omma.scene.natural_material("grass blade")
    for part in ("reflectance", "transmittance"):
        np.testing.assert_array_equal(getattr(read, part).value, getattr(wanted, part).value)
    assert read.spectral_luminance == wanted.spectral_luminance


def test_the_python_of_an_environment_is_found_by_any_of_its_names(package, tmp_path):
    binaries = tmp_path / "bin"
    binaries.mkdir()
    python = binaries / "python"
    python.symlink_to(sys.executable)
    script = binaries / "omma"
    script.write_text(f"#!{python}\n")
    for name in (tmp_path, python, script):
        assert package.python_of(str(name)) == str(python)
    script.write_text("#!/nowhere/python\n")  # as in an environment that was moved
    assert package.python_of(str(script)) == str(python)


def test_without_the_package_it_is_said_how_to_install_it(package, tmp_path, monkeypatch):
    with pytest.raises(package.OmmaError, match="there is no such file"):
        package.find_python(str(tmp_path / "nowhere"))
    with pytest.raises(package.OmmaError, match="found no Python there"):
        package.find_python(str(tmp_path))
    bare = tmp_path / "python"
    bare.write_text("#!/bin/sh\nexit 1\n")
    bare.chmod(0o755)
    with pytest.raises(package.OmmaError, match=r"no package omma in this Python.*pip install"):
        package.find_python(str(bare))
    monkeypatch.setattr(package, "candidates", lambda: [str(bare)])
    monkeypatch.setattr(package, "_found", {})
    with pytest.raises(package.OmmaError, match=r"no Python with the package.*Preferences"):
        package.find_python("")


def test_a_process_that_dies_is_told_by_its_last_words(package, tmp_path):
    dying = tmp_path / "python"
    dying.write_text("#!/bin/sh\necho it was the memory >&2\nexit 9\n")
    dying.chmod(0o755)
    with pytest.raises(package.OmmaError, match="code 9: it was the memory"):
        package.Work(str(dying), "facts").result()


def test_both_kinds_of_gltf_files_take_bytes_and_keep_what_they_had(tmp_path):
    gltf_file = module("gltf_file")
    box = omma.scene.box((1, 2, 3))
    binary = tmp_path / "box.glb"
    omma.scene.save_scene(binary, box)
    text = tmp_path / "box.gltf"  # as Blender writes it, with its bytes in a file
    gltf_file.write_gltf(text, gltf_file.read_gltf(binary))
    assert (tmp_path / "box.bin").stat().st_size > 0
    for path in (binary, text):
        opened = gltf_file.read_gltf(path)
        view = gltf_file.add_bytes(opened, b"12345")
        gltf_file.default_scene(opened)["extras"]["background-color"] = [1, 2, 3]
        gltf_file.write_gltf(path, opened)
        again = gltf_file.read_gltf(path)
        place = again.document["bufferViews"][view]
        assert again.binary[place["byteOffset"] :][:5] == b"12345"
        read = omma.load_scene(path)
        np.testing.assert_array_equal(read.meshes[0].positions_m, box.meshes[0].positions_m)
        np.testing.assert_array_equal(read.background.color, [1, 2, 3])


# Inside of Blender.


def blender_python():
    """A Python that has bpy."""
    named = os.environ.get("OMMA_BLENDER_PYTHON")
    for python in (named, ROOT / ".venv-blender" / "bin" / "python"):
        if python and Path(python).is_file():
            return str(python)
    return None


@pytest.fixture(scope="session")
def blender(archive, tmp_path_factory):
    """Runs a function of blender_side.py; its folder and what it answered."""
    python = blender_python()
    if python is None:
        pytest.skip("there is no Blender: scripts/blender_addon --tests makes .venv-blender")

    def run(function, **arguments):
        folder = tmp_path_factory.mktemp(function)
        home = tmp_path_factory.mktemp("home")
        told = {"package": str(archive), "program": sys.executable, **arguments}
        ran = subprocess.run(
            [python, str(SIDE), function, str(folder), json.dumps(told)],
            env={**os.environ, "BLENDER_USER_RESOURCES": str(home)},
            capture_output=True,
            text=True,
        )
        assert ran.returncode == 0, ran.stdout[-2000:] + ran.stderr[-4000:]
        return folder, json.loads((folder / "answer.json").read_text())

    return run


def test_it_registers_and_goes_without_residue(blender):
    _, said = blender("registers")
    classes, drawn = said["first"]
    assert classes > 10
    menus_without = [number - 1 for number in drawn]
    assert said["states"] == 2 * [[[], False, menus_without], [classes, True, drawn]]


@pytest.fixture(scope="session")
def rendered(blender):
    return blender("renders", eye=str(EYE))


@pytest.mark.parametrize(("camera", "samples"), [("bee eye", 8), ("back", 4)])
def test_blender_renders_what_its_exported_files_give(rendered, tmp_path, camera, samples):
    folder, _ = rendered
    numbers = np.load(folder / f"Scene-{camera.replace(' ', '_')}.npy")
    assert numbers.shape == (1, 5380, 3)
    assert np.unique(numbers.round(3), axis=1).shape[1] > 20  # it sees something
    for scene in (f"Scene-{camera.replace(' ', '_')}.glb", "whole.glb", "parts.gltf"):
        out = tmp_path / "view.npy"
        command = ["render", str(folder / scene), "--camera", camera, "--samples", str(samples)]
        subprocess.run(
            [sys.executable, "-m", "omma", *command, "-o", str(out)],
            check=True,
            capture_output=True,
        )
        np.testing.assert_array_equal(np.load(out), numbers)


def test_the_picture_in_blender_is_that_of_the_numbers(rendered):
    folder, _ = rendered
    head = omma.load_eye(EYE)
    for camera, projection in (("bee eye", None), ("back", "mollweide")):
        numbers = np.load(folder / f"Scene-{camera.replace(' ', '_')}.npy")[0]
        picture = np.load(folder / f"{camera}.picture.npy")
        wanted = omma.picture.project(head, numbers, projection, 128, linear=True)
        looked_at = np.isfinite(wanted[..., 0])
        assert 0.2 < looked_at.mean() < 0.9
        np.testing.assert_array_equal(picture[..., 3], looked_at)
        np.testing.assert_array_equal(picture[looked_at, :3], wanted[looked_at])


def test_rendering_leaves_the_scene_as_it_was(rendered):
    _, said = rendered
    assert said["before"] == said["after"]
    assert said["frame"] == 1


def test_the_file_says_what_the_scene_has(rendered):
    folder, _ = rendered
    scene = omma.load_scene(folder / "parts.gltf")
    assert any(re.match("without a light .* 2 lamps", one) for one in scene.warnings)
    grass = next(one for one in scene.materials if one.name == "grass")
    np.testing.assert_array_equal(grass.reflectance.wavelength_nm, [300, 500, 550, 700])
    assert grass.spectral_luminance == np.float32(0.3)
    np.testing.assert_allclose(scene.background.color, [0.24, 0.4, 0.72], rtol=1e-6)
    lights = {one.name: one for one in scene.lights}
    # A watt of Blender's is a lumen: 3 W/m² of a sun, 100 W of a bulb over 4 pi.
    assert lights["sun"].intensity == pytest.approx(3)
    assert lights["bulb"].intensity == pytest.approx(100 / (4 * np.pi))
    assert {one.name: one.type for one in scene.cameras} == {
        "bee eye": "compound",
        "back": "compound",
        "around": "panoramic",
    }
    assert scene.camera("back").compound_projection == "mollweide"
    # The modifier has been applied: three boxes in a row.
    high = next(one for one in scene.instances if one.name == "high")
    assert len(scene.meshes[high.mesh].triangles) == 36
    assert not any("eye" in one.name for one in scene.instances)  # what shows an eye is no thing


def test_left_is_left_and_up_is_up(rendered):
    folder, _ = rendered
    head = omma.load_eye(EYE)
    scene = omma.load_scene(folder / "whole.glb")
    pose = scene.camera("back").world_from_camera
    np.testing.assert_allclose(pose[:3, 3], 0, atol=1e-6)  # where Blender's cursor was
    np.testing.assert_allclose(pose[:3, 2], [0, 0, -1], atol=1e-6)  # it looks along -y, glTF's +z
    # Seen from there, the blue box at (3, 4) is behind it on its left.
    numbers = np.load(folder / "Scene-back.npy")[0]
    blue = (numbers[:, 2] > 0.6) & (numbers[:, 1] < 0.2)
    assert blue.any()
    to_box = np.array([3, 0.5, -4.0]) / np.linalg.norm([3, 0.5, -4.0])
    axes = head.axis[blue] @ pose[:3, :3].T
    # A box of 1 m at 5 m: within 12 degrees of its middle, and half an acceptance angle.
    assert np.degrees(np.arccos((axes @ to_box).min())) < 14
    assert (head.axis[blue][:, 0] < 0).all()


def test_animations_go_through_the_frames_of_blender(blender):
    folder, said = blender("animates", eye=str(EYE))
    scene = omma.load_scene(folder / "flight.glb")
    with pytest.warns(UserWarning, match="without a light"):
        world = omma.World(scene)
    assert len(scene.animations) == 1
    assert scene.animations[0].duration_s == pytest.approx(24 / said["fps"], abs=1e-6)
    back = GLTF_FROM_BLENDER.T
    bent = []
    for i, frame in enumerate(said["frames"]):
        time_s = (frame - 1) / said["fps"]
        world.at(time_s)
        for name in ("bee", "wing", "abdomen"):
            wanted = GLTF_FROM_BLENDER @ np.array(said[name][i]) @ back
            found = world.instances[world.index(name)].world_from_node
            np.testing.assert_allclose(found, wanted, atol=1e-5)
        # Cameras look along their own -z in both: only the world's frame differs.
        wanted = GLTF_FROM_BLENDER @ np.array(said["bee eye"][i])
        np.testing.assert_allclose(world.camera_at("bee eye", time_s), wanted, atol=1e-5)
        mesh = scene.instances[world.index("abdomen")].mesh
        bent.append(world.vertices(mesh)[:, 1].max())
    # The shape key rises from 0 to 1 over the frames, by Blender's own smooth curve.
    assert bent[0] == pytest.approx(0.05, abs=1e-6)
    assert bent[-1] == pytest.approx(0.25, abs=1e-6)
    assert np.all(np.diff(bent) > 0)


def test_an_imported_eye_has_the_points_and_axes_of_the_file(blender):
    _, said = blender("imports", eye=str(EYE))
    eye = omma.load_eye(EYE)
    points = np.array(said["points"], np.float32)
    np.testing.assert_array_equal(points[: len(eye)], eye.position_m)
    towards = points[len(eye) :] - points[: len(eye)]
    towards /= np.linalg.norm(towards, axis=1)[:, None]
    # Axes of a millimetre's fraction, as differences of single precision.
    np.testing.assert_allclose(towards, eye.axis, atol=1e-4)
    np.testing.assert_array_equal(np.array(said["axis"], np.float32)[: len(eye)], eye.axis)
    wanted = np.asarray(eye.acceptance_angle_rad)
    np.testing.assert_array_equal(np.array(said["acceptance"], np.float32)[: len(eye)], wanted)
    assert said["edges"] == [[i, i + len(eye)] for i in range(len(eye))]
    np.testing.assert_allclose(said["ahead"], [0, 1, 0], atol=1e-6)  # level, along Blender's +y
    assert said["hidden"]


def both(folder, name):
    """Linear pictures of Omma and of Cycles."""
    return (np.load(folder / f"{name}.{which}.npy") for which in ("omma", "cycles"))


def test_silhouettes_are_those_of_blenders_own_renderer(blender):
    folder, _ = blender("silhouettes")
    for name in ("perspective", "tall", "orthographic"):
        ours, theirs = both(folder, name)
        assert ours.shape == theirs.shape
        for color in range(3):
            a, b = ours[..., color] > 0.5, theirs[..., color] > 0.5
            assert a.sum() > 1000
            assert (a & b).sum() / (a | b).sum() > 0.99


def test_backgrounds_are_where_blender_has_them(blender):
    folder, _ = blender("worlds")
    for name in ("floats", "turned", "bytes"):
        ours, theirs = both(folder, name)
        # Between pixels both interpolate, Omma also where the picture was turned; the picture
        # changes by 0.01 (0.025 where it is 2.5 times as bright) from pixel to pixel.
        np.testing.assert_allclose(ours, theirs, atol=0.01)
        assert np.ptp(ours, axis=(0, 1)).min() > 0.2


def test_lamps_worlds_and_what_shines_keep_their_proportions(blender):
    folder, _ = blender("lit")
    for name in ("lamp", "sun", "world", "panel"):
        ours, theirs = both(folder, name)
        luminance = np.array([0.2126, 0.7152, 0.0722])
        a, b = (ours @ luminance).mean(), (theirs @ luminance).mean()
        # Red, green and blue are spectra in Omma and three numbers in Cycles, which multiply
        # otherwise where light or surfaces are coloured; noise is below a percent.
        assert a == pytest.approx(b, rel=0.02), name


def test_what_goes_wrong_is_said_and_work_goes_on(blender):
    _, said = blender("fails", eye=str(EYE))
    expected = {
        "no camera": "no camera to see from",
        "unknown camera": "no camera nobody",
        "no such program": "there is no such file",
        "no package": "no package omma in this Python",
        "no package to import": "pip install omma",
        "missing eye": "missing.eye: there is no such eye file",
        "empty eye": "empty.eye: expected at least one ommatidium",
        "broken eye": "broken.eye, line 1",
        "unknown species": "expected one of honeybee_worker",
        "eye gone": "gone.eye: there is no such eye file",
        "no eye": "names no eye: choose an eye file or a species",
        "no folder": "expected a folder, found a file",
        "other ending": "expected a name that ends in .glb or .gltf",
        "no folder for numbers": "expected a folder, found a file",
        "not saved": "which is not saved yet",
        "all hidden": "has nothing to export",
        "wrong spectrum": 'material 0 "wrong spectrum": reflectance',
        "wrong spectrum file": "expected two or more ascending wavelengths",
        "unknown material": "expected one of green leaf",
    }
    for name, text in expected.items():
        assert said[name][0] == ""
        assert text in said[name][1]
        assert "Traceback" not in said[name][1]
    assert said["left over"] == ["panel of light"]
    assert said["sky"] == [["FINISHED"], ""]  # a warning, not an end
    assert said["files"] == ["broken.eye", "empty.eye", "file", "spectrum.csv"]


def test_a_render_that_is_stopped_leaves_no_numbers(blender):
    _, said = blender("stops", eye=str(EYE))
    assert said["ended"] != 0
    # Some of them are over before anybody looks.
    assert {"Reading the scene", "Building the acceleration structure"} & set(said["stages"])
    assert said["files"] == ["Scene-bee_eye-bee_eye.eye", "Scene-bee_eye.glb"]


def test_what_the_page_says_to_run_in_blender_runs(blender):
    _, said = blender("runs_the_page", page=str(ROOT / "docs" / "blender.md"))
    numbers = np.load(said["numbers"])
    assert numbers.shape == (1, 10760, 16)
    # By day, in photons: white ground in the sun has some 1e18 (docs/light.md).
    assert 1e16 < np.median(numbers[0, :, 9]) < 1e19
    assert 0.05 < said["shown"] < 2
    # What anybody gets of the file that was kept.
    scene = omma.load_scene(Path(said["numbers"]).with_suffix(".glb"))
    light = omma.light.clear_sky(40, sun_azimuth_deg=200)
    world = omma.World(scene, light=light, lighting="path", ultraviolet="dark")
    eye = omma.picture.camera_eye(scene, "bee")
    wanted = omma.Renderer(world, eye, omma.Fixed(1)).render("bee")
    np.testing.assert_array_equal(numbers, wanted)
    assert said["leaf"]["spectral_luminance"] == 0.3


def test_panels_draw_and_a_render_waits_for_its_end_or_for_escape(blender):
    _, said = blender("draws_and_waits", eye=str(EYE))
    assert {"eye_file", "kernel", "samples", "projection", "numbers", "program"} <= set(
        said["drawn"]
    )
    assert "Given: reflectance, spectral_luminance" in said["drawn"]
    assert said["ends"] == [["FINISHED"], ["CANCELLED"]]
    assert any(line.startswith("5,380 ommatidia, 43,040 rays") for line in said["told"])
    assert "Omma: stopped" in said["told"]
    assert said["told"].count("removed timer") == 2
    assert any(line and "Esc: stop" in line for line in said["statuses"])
    assert said["statuses"][-1] is None
