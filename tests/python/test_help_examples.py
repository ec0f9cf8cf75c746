"""The examples in the help of each command, run as they stand, on small files of those names."""

import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
import typer
from capture_files import write_colmap_text
from conftest import make_eye, write_gltf
from oces_builder import OcesFile
from test_eye_files_import import grid, oda_file

import omma
from omma.cli import main

EXAMPLES_FOLDER = Path(__file__).resolve().parents[2] / "examples"

# Beginnings of examples that are not run, and why.
NOT_RUN = {
    "omma render arena.gltf --camera 2": "118 million rays; test_cameras.py has smaller pictures",
    "omma render-cameras arena.gltf -o": "ten seconds; test_cameras.py has smaller pictures",
    "omma measure": "minutes each; test_sampling_tools.py and test_speed_test.py have smaller ones",
    "omma dataset": "of a job that is to be made first; test_datasets.py makes and reads one",
    "omma view": "goes on until Ctrl-C; test_view_command.py ends it",
    "omma eye make 5000": "twelve seconds; test_cli_eye_make.py has fewer ommatidia",
    "omma eye make --dphi 2": "ten seconds; test_cli_eye_make.py has fewer ommatidia",
    "omma eye plot --species": "ten seconds; test_eye_plots.py draws posters",
}


def examples():
    """All commands in backquotes in the help, each on one line and once."""

    def of(command):
        command = command.load() if isinstance(command, main.Later) else command
        yield from re.findall(r"`(omma [^`]+)`", command.help or "")
        for below in getattr(command, "commands", {}).values():
            yield from of(below)

    found = [" ".join(text.split()) for text in of(typer.main.get_command(main.app))]
    return list(dict.fromkeys(found))


@pytest.fixture(scope="module")
def named_files(tmp_path_factory):
    """A folder with small files of the names that the help uses."""
    folder = tmp_path_factory.mktemp("help")
    eye = make_eye(200)
    receptors = omma.receptors.assign_receptors(eye, omma.receptors.honeybee_ommatidia())
    for name in ("honeybee", "left", "right", "1000", "bee", "ant", "honeybee_worker_left"):
        omma.save_eye(folder / f"{name}.eye", eye)
    omma.save_eye(folder / "honeybee_worker_right.eye", eye)
    omma.save_eye(folder / "eye-in-micrometres.eye", eye, "um")
    for name in ("honeybee", "right", "eye"):
        omma.save_eye(folder / f"{name}.csv", eye)
    lines = (folder / "honeybee.csv").read_text().splitlines()
    header, first, *rest = [line for line in lines if not line.startswith("#")]
    cells, names = first.split(","), header.split(",")
    cells[next(k for k, one in enumerate(names) if one.startswith("acceptance_angle_"))] = ""
    (folder / "measured.csv").write_text("\n".join([header, ",".join(cells), *rest]))
    omma.save_eye(folder / "bee.csv", receptors)
    across = omma.receptors.ReceptorType(
        "rim", peak_wavelength_nm=345, polarisation_sensitivity=6.3
    )
    rim = omma.receptors.OmmatidiumType("rim", (across,))
    omma.save_eye(folder / "rim.csv", omma.receptors.assign_receptors(eye, rim))
    halves = omma.eye.split_eye(eye, 0.5e-3)
    omma.save_eye(folder / "head.eye", halves, lossy=True)
    old = np.column_stack([eye.position_m * 1e3, eye.axis, np.full(len(eye), 5.0)])
    np.savetxt(folder / "old-in-degrees.eye", old, fmt="%.9g")
    lens, normal = grid(8)
    oda_file(folder / "ommatidial_data.csv", lens, normal)
    for name, points in (("lenses", lens), ("cones", lens - 60 * normal)):
        np.savetxt(folder / f"{name}.csv", points / 1e3, delimiter=",", fmt="%.9g")
    oces_head(folder / "eyes.glb")
    write_gltf(
        folder / "arena.gltf",
        cameras=[
            ("plain", None, {}),
            (
                "insect-eye",
                {"compound-eye": "true", "compound-structure": "bee.eye"},
                {"translation": [0, 1, 0]},
            ),
            ("panoramic", {"panoramic": "true"}, {"translation": [0, 1, 0]}),
        ],
    )
    shutil.copy(EXAMPLES_FOLDER / "meadow.glb", folder)
    sward = omma.scene.plane((40, 40)).meshes[0].replace(material=0)
    of_sward = [omma.scene.natural_material("green sward")]
    omma.scene.save_scene(folder / "meadow_lit.glb", omma.Scene(meshes=[sward], materials=of_sward))
    few = (EXAMPLES_FOLDER / "flight.csv").read_text().splitlines()[:4]
    (folder / "flight.csv").write_text("\n".join(few) + "\n")
    (folder / "track.csv").write_text("t_s,x_m,z_m\n0,0,3\n0.1,0,2.9\n")
    (folder / "positions_and_axes.csv").write_text(
        "position_x_mm,position_y_mm,position_z_mm,axis_x,axis_y,axis_z\n"
        "0,0,-1,0,0,-1\n0.1,0,-1,0.1,0,-1\n0,0.1,-1,0,0.1,-1\n"
    )
    sphere(folder / "eye.stl")
    sphere(folder / "scan.stl")
    (folder / "forest.xyz").write_text("0 0 0\n0 0 1\n1 0 0\n")
    np.savetxt(folder / "scan.xyz", np.random.default_rng(1).uniform(-1, 1, (300, 3)) * (1, 1, 0))
    omma.scene.save_splats(
        folder / "garden.spz",
        omma.scene.SplatCloud(
            [(0, 0, -1)], [(0.1, 0.1, 0.1)], [(0, 0, 0, 1)], [0.5], np.zeros((1, 1, 3))
        ),
    )
    around = [omma.look_at((x, 1, 3), (0, 0, 0)) for x in (-1, 0, 1)]
    write_colmap_text(folder / "garden" / "sparse" / "0", around)
    (folder / "moved").mkdir()
    for name in ("arena.gltf", "bee.eye"):
        shutil.copy(folder / name, folder / "moved")
    for name in ("flight.npy", "bee.npy"):
        omma.render_file(
            folder / "arena.gltf",
            folder / name,
            omma.Fixed(1),
            eyes=folder / "bee.eye",
            path=folder / "flight.csv",
        )
    return folder


def oces_head(path):
    """Two heads, a queen's and a worker's, of one eye each."""
    file = OcesFile()
    for name in ("queen", "worker"):
        eye = file.node({"eye": file.simple_eye()})
        file.node({"head": True}, name=name, children=[eye])
    file.write(path.with_suffix(".gltf"))
    path.with_suffix(".gltf").rename(path)


def sphere(path):
    """A mesh of 0.1 mm, in millimetres, as text."""
    turn, up = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(-np.pi / 2, np.pi / 2, 13))
    points = 0.1 * np.stack([np.cos(up) * np.cos(turn), np.sin(up), np.cos(up) * np.sin(turn)], -1)
    lines = ["solid eye"]
    for i in range(12):
        for j in range(24):
            a, b, c, d = points[i, j], points[i + 1, j], points[i + 1, j + 1], points[i, j + 1]
            for corners in ((a, b, c), (a, c, d)):
                lines += ["facet normal 0 0 0", "outer loop"]
                lines += ["vertex " + " ".join(f"{v:.6e}" for v in corner) for corner in corners]
                lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid eye", ""]))


@pytest.mark.parametrize(
    "example", [text for text in examples() if not text.startswith(tuple(NOT_RUN))]
)
def test_example_runs(example, named_files, run_omma, monkeypatch):
    monkeypatch.chdir(named_files)
    if "--mesh" in example:
        pytest.importorskip("trimesh")
    if ".zarr" in example or "flight.npy" in example or "render-again" in example:
        pytest.importorskip("xarray")
        pytest.importorskip("zarr")
    if "eye plot" in example or "eye info" in example or "hull.png" in example:
        pytest.importorskip("matplotlib")
    code, _, err = run_omma(*shlex.split(example)[1:])
    assert code == 0, err


def test_what_is_not_run_is_an_example():
    for beginning in NOT_RUN:
        assert any(text.startswith(beginning) for text in examples()), beginning
