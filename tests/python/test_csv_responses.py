"""Responses in `.csv`: what their columns say of bands, unit and time, and what is read of them."""

import csv

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.job.info import describe_file
from omma.rendering import load_responses

POSE = omma.look_at((0, 0.5, 0), (0, 0.4, -5))
UNIT = "photons m-2 s-1 sr-1 nm-1"


def ground(light=None, **settings):
    scene = omma.scene.plane((40, 40), (0.3, 0.3, 0.3), name="land")
    dark = {} if light is None else {"light": light, "ultraviolet": "dark"}
    return omma.World(scene, **dark, **settings)


def sky(bands):
    return omma.light.uniform_sky(1e17, bands=bands)


def rows_of(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize(
    ("edges_nm", "names"),
    [
        ([300, 400, 500, 600], ["350 nm", "450 nm", "550 nm"]),
        ([300, 410, 500, 600, 700], ["355 nm", "455 nm", "550 nm", "650 nm"]),
    ],
)
def test_columns_of_a_lit_world_have_wavelengths_and_a_unit(tmp_path, edges_nm, names):
    """Three bands of a lit world are not red, green and blue."""
    world, eye = ground(sky(omma.light.Bands.from_edges(edges_nm))), make_eye(5)
    renderer = omma.Renderer(world, eye, omma.Fixed(4))
    seen, errors = renderer.render(POSE, standard_error=True)
    path = tmp_path / "lit.csv"
    omma.save_responses(path, seen, eye, errors, world=world)
    rows = rows_of(path)
    assert list(rows[0])[5:] == ["unit", *names, *(f"{name}_error" for name in names)]
    assert {row["unit"] for row in rows} == {UNIT}
    assert [np.float32(rows[3][name]) for name in names] == seen[0, 3].tolist()
    pytest.importorskip("xarray")
    found, expected = load_responses(path), renderer.dataset(POSE)
    assert np.array_equal(found.response, seen)
    assert np.array_equal(found.standard_error, errors)
    # As in every other file.
    assert found.band.values.tolist() == expected.band.values.tolist() == names
    assert found.wavelength.values == pytest.approx(expected.wavelength.values, abs=0.005)
    assert found.wavelength.attrs == {"units": "nm"}
    assert found.response.attrs["units"] == expected.response.attrs["units"] == UNIT
    lines = dict(describe_file(path))
    assert lines["bands"] == ", ".join(names)
    assert lines["range"].endswith(UNIT)


def test_columns_of_a_world_without_light(tmp_path):
    eye, path = make_eye(5), tmp_path / "a.csv"
    rgb = np.ones((5, 3), np.float32)

    def header(responses, **told):
        omma.save_responses(path, responses, eye, **told)
        return path.read_text().splitlines()[0].split("elevation_deg,")[1]

    assert header(rgb, world=ground()) == "r,g,b"
    three = omma.light.band_from_rgb([300, 400, 500, 600])
    assert header(rgb, world=ground(band_from_rgb=three)) == "band_0,band_1,band_2"
    # An array says nothing of its bands.
    assert header(rgb) == "band_0,band_1,band_2"
    with pytest.raises(omma.Error, match=r"world: expected one of 4 bands .*found 3"):
        header(np.ones((5, 4)), world=ground())


def test_units_that_are_not_told_are_not_made_up(tmp_path):
    pytest.importorskip("xarray")
    eye = make_eye(5)
    omma.save_responses(tmp_path / "a.csv", np.ones((5, 3)), eye)
    assert load_responses(tmp_path / "a.csv").response.attrs == {}
    # As files were before: r, g, b without a unit.
    old = "pose,ommatidium,eye_id,azimuth_deg,elevation_deg,r,g,b\n0,0,0,1,2,0.25,0.5,nan\n"
    (tmp_path / "old.csv").write_text(old)
    found = load_responses(tmp_path / "old.csv")
    assert found.band.values.tolist() == ["red", "green", "blue"]
    assert np.array_equal(found.response, [[[0.25, 0.5, np.nan]]], equal_nan=True)


def test_cells_without_a_number_are_empty(tmp_path):
    """Which R and pandas read as not available; R does not know "nan"."""
    eye, path = make_eye(5), tmp_path / "a.csv"
    values = np.arange(15, dtype=np.float32).reshape(1, 5, 3)
    values[0, 2] = np.nan
    omma.save_responses(path, values, eye, values, world=ground())
    assert path.read_text().splitlines()[3].endswith(",,,,,,")
    assert "nan" not in path.read_text()
    omma.study.save_variance_map(tmp_path / "map.csv", np.full((1, 1), np.nan), (0, 0, 0), 1.0)
    assert (tmp_path / "map.csv").read_text() == "x_m,z_m,standard_deviation\n0,0,\n"
    pytest.importorskip("xarray")
    assert np.array_equal(load_responses(path).response, values, equal_nan=True)


@pytest.fixture
def lit_folder(tmp_path, monkeypatch):
    """land.obj, bug.csv with receptors and a track.csv with times and a gap."""
    monkeypatch.chdir(tmp_path)
    corners = "v -20 0 20\nv 20 0 20\nv 20 0 -20\nv -20 0 -20\n"
    (tmp_path / "land.obj").write_text(f"{corners}f 1 2 3\nf 1 3 4\n")
    kind = omma.receptors.OmmatidiumType(
        "one", (omma.receptors.ReceptorType("green", peak_wavelength_nm=544),)
    )
    omma.save_eye("bug.csv", omma.receptors.assign_receptors(make_eye(5), kind))
    (tmp_path / "track.csv").write_text("t_s,x_m,z_m\n0.1,0,0\n0.2,NA,NA\n0.4,0.1,-0.2\n")
    return tmp_path


@pytest.mark.filterwarnings("ignore:.*left out")
@pytest.mark.parametrize("receptors", [False, True])
def test_the_command_line_writes_bands_unit_and_times(lit_folder, run_omma, receptors):
    given = ["land.obj", "--eye", "bug.csv", "--path", "track.csv", "--on-ground", "0.003"]
    given += ["--lost", "leave_out", "--samples", "4", "--standard-error", "--ultraviolet", "dark"]
    given += ["--light", "uniform_sky radiance=1e17 bands=3"] + ["--receptors"] * receptors
    code, _, err = run_omma("render", *given, "-o", "a.csv", "-o", "a.npy")
    assert code == 0, err
    names = ["response"] if receptors else ["366.67 nm", "500 nm", "633.33 nm"]
    rows = rows_of("a.csv")
    sites = 7 if receptors else 6
    assert list(rows[0])[sites - 1 :] == [
        *("time_s", "unit", *names), *(f"{name}_error" for name in names)
    ]  # fmt: skip
    assert {row["unit"] for row in rows} == {UNIT}
    assert [row["time_s"] for row in rows] == ["0.1"] * 5 + ["0.4"] * 5
    pytest.importorskip("xarray")
    found, expected = load_responses("a.csv"), load_responses("a.npy")
    assert found.response.dims == expected.response.dims
    assert np.array_equal(found.time, expected.time)
    for name in ("response", "standard_error"):
        assert np.array_equal(found[name], expected[name])
    assert found.response.attrs["units"] == expected.response.attrs["units"]
