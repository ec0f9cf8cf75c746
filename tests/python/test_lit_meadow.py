"""The lit meadow: the bundled meadow's triangles with materials that have spectra, and a pond."""

import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest

import omma

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LIT, UNLIT = EXAMPLES / "meadow_lit.glb", EXAMPLES / "meadow.glb"
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
COMPONENTS = {5121: np.dtype("u1"), 5123: np.dtype("<u2"), 5126: np.dtype("<f4")}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Glb:
    def __init__(self, path):
        data = path.read_bytes()
        length = int.from_bytes(data[12:16], "little")
        self.document = json.loads(data[20 : 20 + length])
        self.blob = data[28 + length :]

    def accessor(self, index):
        entry = self.document["accessors"][index]
        view = self.document["bufferViews"][entry["bufferView"]]
        dtype, width = COMPONENTS[entry["componentType"]], WIDTHS[entry["type"]]
        offset = view["byteOffset"] + entry.get("byteOffset", 0)
        strides = (view.get("byteStride", dtype.itemsize * width), dtype.itemsize)
        return np.ndarray((entry["count"], width), dtype, self.blob, offset, strides)

    def corners(self, primitive):
        """(T, 9): the corners of its triangles."""
        position = self.accessor(primitive["attributes"]["POSITION"])
        return position[self.accessor(primitive["indices"])[:, 0]].reshape(-1, 9)

    def picture(self, name):
        """Linear RGB and alpha of an image."""
        image = pytest.importorskip("PIL.Image", reason="Pillow decodes the textures here")
        entry = next(i for i in self.document["images"] if i["name"] == name)
        view = self.document["bufferViews"][entry["bufferView"]]
        data = self.blob[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        pixels = np.asarray(image.open(io.BytesIO(data)).convert("RGBA")) / 255
        rgb = pixels[..., :3]
        linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        return linear, pixels[..., 3]


@pytest.fixture(scope="module")
def lit():
    return Glb(LIT)


@pytest.fixture(scope="module")
def unlit():
    return Glb(UNLIT)


def materials(glb):
    return {material["name"]: material for material in glb.document["materials"]}


def said(material):
    return material["extras"]["omma"]


def at(spectrum, nm):
    return np.interp(nm, spectrum["wavelength_nm"], spectrum["value"])


NM = np.arange(300, 701, 5)


def test_it_has_the_triangles_of_the_unlit_one_and_a_pond(lit, unlit):
    nodes = {node["name"]: node for node in lit.document["nodes"]}
    others = {node["name"]: node for node in unlit.document["nodes"]}
    assert set(nodes) - set(others) == {"pond"}  # the mesh and its camera have one name
    assert set(others) <= set(nodes)
    pairs = set()
    for name, other in others.items():
        for key in ("translation", "rotation", "scale", "camera"):
            assert nodes[name].get(key) == other.get(key)
        if "mesh" in other:
            pairs.add((nodes[name]["mesh"], other["mesh"]))
    for mesh, other in pairs:
        parts = [lit.corners(p) for p in lit.document["meshes"][mesh]["primitives"]]
        whole = unlit.corners(unlit.document["meshes"][other]["primitives"][0])
        parts = np.concatenate(parts)
        assert parts.shape == whole.shape
        order, other_order = (np.lexsort(one.T) for one in (parts, whole))
        np.testing.assert_array_equal(parts[order], whole[other_order])


def test_every_material_has_spectra(lit):
    natural = omma.scene.natural_materials()
    for name, material in materials(lit).items():
        assert "KHR_materials_unlit" not in material["extensions"]
        spectra = said(material)
        assert set(spectra) <= {"reflectance", "transmittance", "spectral_luminance"}
        for key in ("reflectance", "transmittance"):
            if key in spectra:
                nm, value = spectra[key]["wavelength_nm"], spectra[key]["value"]
                assert (nm[0], nm[-1], len(nm)) == (300, 700, len(value))
                assert (np.diff(nm) > 0).all()
                assert 0 <= min(value) <= max(value) <= 1
        kind = {"stem": "green leaf", "verge": "green sward"}.get(name, name.split(" on ")[0])
        # Every 10 nm and with four digits.
        kept = at(spectra["reflectance"], NM[::2])
        np.testing.assert_allclose(kept, natural[kind].reflectance[::2], atol=5.1e-5)
        ior = material["extensions"]["KHR_materials_ior"]["ior"]
        assert ior == natural[kind].ior


def test_thin_things_let_light_through(lit):
    through = {name for name, one in materials(lit).items() if "transmittance" in said(one)}
    solid = {"stem", "green sward", "verge", "light soil", "rock", "bark", "birch bark"}
    solid |= {"pond water", "dark petal"}
    assert through == set(materials(lit)) - solid
    for name, one in materials(lit).items():
        assert one["doubleSided"]
        assert ("KHR_materials_diffuse_transmission" in one["extensions"]) == (name in through)


PICTURES = {
    "grass blade on cards": ("grass", 0, 1),
    "dry grass on cards": ("grass", 0, 1),
    "green leaf on cards": ("leaves", 0, 1),
    "green sward": ("ground", 0, 1),
    "verge": ("ground", 0, 1),
    "light soil": ("ground", 0, 1),
    "rock": ("ground", 0, 1),
    "bark": ("bark", 0, 0.5),
    "birch bark": ("bark", 0.5, 1),
}


def base_colours(lit, name):
    """(K, 3): linear base colours that a material has, those of its picture's pixels."""
    material = materials(lit)[name]
    factor = np.array(material["pbrMetallicRoughness"]["baseColorFactor"][:3])
    if name not in PICTURES:
        return factor[None]
    picture, low, high = PICTURES[name]
    rgb, alpha = lit.picture(picture)
    columns = slice(int(low * rgb.shape[1]), int(high * rgb.shape[1]))
    return rgb[:, columns][alpha[:, columns] >= 0.5] * factor


def brightness_of_land(lit):
    mesh = next(m for m in lit.document["meshes"] if m["name"] == "land")
    return lit.accessor(mesh["primitives"][0]["attributes"]["COLOR_0"])[:, 0] / 255


def test_on_average_materials_have_their_spectra_and_nothing_sends_back_more_than_it_gets(lit):
    textured = {n for n, m in materials(lit).items() if "baseColorTexture" in str(m)}
    assert textured == set(PICTURES)
    for name, material in materials(lit).items():
        luminance = base_colours(lit, name) @ LUMINANCE
        spectra = said(material)
        mean, most = luminance.mean(), luminance.max()
        if name == "green sward":
            # Fields are brighter and darker; what has the spectrum is in the middle of them.
            land = brightness_of_land(lit)
            assert land.min() < 0.6 < land.max()
            mean, most = 0.6 * mean, most * land.max()
        # The written luminance has five decimals.
        assert mean == pytest.approx(spectra["spectral_luminance"], rel=1e-3, abs=1e-5)
        back = at(spectra["reflectance"], NM)
        if "transmittance" in spectra:
            back = back + at(spectra["transmittance"], NM)
        assert back.max() * most / spectra["spectral_luminance"] <= 1


def test_albedo_is_plausible(lit):
    """Mean reflectance from 400 to 700 nm, with what passes where things are thin."""
    ranges = {
        "grass blade on cards": (0.03, 0.2),
        "green leaf on cards": (0.03, 0.2),
        "green sward": (0.02, 0.1),
        "dry grass on cards": (0.2, 0.6),
        "light soil": (0.1, 0.3),
        "rock": (0.15, 0.35),
        "bark": (0.08, 0.25),
        "birch bark": (0.4, 0.7),
        "white petal": (0.7, 0.95),
        "pond water": (0.003, 0.02),
    }
    for name, (least, most) in ranges.items():
        spectra = said(materials(lit)[name])
        both = at(spectra["reflectance"], NM[20:]).mean()
        if "transmittance" in spectra:
            both += at(spectra["transmittance"], NM[20:]).mean()
        assert least < both < most, name


def test_pictures_of_plants_hold_no_light(lit, unlit):
    for name in ("grass", "leaves"):
        (rgb, alpha), (other, other_alpha) = lit.picture(name), unlit.picture(name)
        np.testing.assert_array_equal(alpha, other_alpha)
        values = [one[alpha >= 0.5] @ LUMINANCE for one in (rgb, other)]
        spread, baked = (value.std() / value.mean() for value in values)
        assert spread < 0.25 < baked
    # And no plant has colours at its vertices.
    for mesh in lit.document["meshes"]:
        for primitive in mesh["primitives"]:
            assert ("COLOR_0" in primitive["attributes"]) == (mesh["name"] == "land")


def test_buttercups_have_a_guide_that_is_there_in_the_ultraviolet_alone(lit):
    names = [material["name"] for material in lit.document["materials"]]
    outer, foot = "yellow petal with ultraviolet", "yellow petal"
    reflectance = {n: said(materials(lit)[n])["reflectance"] for n in (outer, foot)}
    assert at(reflectance[outer], 360) > 5 * at(reflectance[foot], 360)
    assert at(reflectance[outer], 560) == pytest.approx(at(reflectance[foot], 560))
    mesh = next(m for m in lit.document["meshes"] if m["name"] == "buttercups 0")
    # Five heads of five petals of four triangles: as many at their feet as further out.
    counts = {names[p["material"]]: len(lit.corners(p)) for p in mesh["primitives"]}
    assert counts[outer] == 50
    assert counts[foot] == 50 + 5 * 5  # and the eyes
    poppies = next(m for m in lit.document["meshes"] if m["name"] == "poppies 0")
    assert "red petal with ultraviolet" in {names[p["material"]] for p in poppies["primitives"]}


def test_the_pond_lies_in_a_hollow(lit):
    from scipy.interpolate import LinearNDInterpolator

    meshes = {mesh["name"]: mesh["primitives"][0] for mesh in lit.document["meshes"]}
    land = lit.accessor(meshes["land"]["attributes"]["POSITION"])
    ground = LinearNDInterpolator(land[:, [0, 2]], land[:, 1])
    water = lit.accessor(meshes["pond"]["attributes"]["POSITION"])
    assert np.ptp(water[:, 1]) == 0
    triangles = lit.corners(meshes["pond"]).reshape(-1, 3, 3).astype(float)
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert (across[:, 1] > 0).all()  # it faces up
    assert 50 < across[:, 1].sum() / 2 < 200
    level, centre = water[0, 1], water[0, [0, 2]]
    assert (ground(water[1:, [0, 2]]) > level).all()  # the rim is under the shore
    assert level - ground(centre) > 0.2
    # Nothing of the unlit meadow's cameras is near.
    assert np.hypot(*centre) > 30


def test_it_loads_with_its_cameras():
    scene = omma.load_scene(LIT)
    assert [w for w in scene.warnings if not w.startswith("without a light")] == []
    assert [c.name for c in scene.cameras] == ["bee", "bee-low", "overview", "pond"]
    assert scene.triangle_count == omma.load_scene(UNLIT).triangle_count + 40
    pond = scene.camera("pond").world_from_camera[:3, 3]
    assert -0.2 < pond[1] < 1.0
    for material in scene.materials:
        assert material.reflectance is not None


def test_it_is_bundled():
    assert omma.examples.lit_meadow().read_bytes() == LIT.read_bytes()
    assert LIT.stat().st_size < 2_500_000


def test_the_script_makes_its_materials_and_its_pond(lit, monkeypatch):
    # All of the file takes the script half a minute; these are what goes stale with the tables.
    pytest.importorskip("PIL.Image", reason="Pillow draws the textures")
    monkeypatch.syspath_prepend(str(EXAMPLES))
    from meadow.glb import new_glb
    from meadow.lit import add_plant_materials, pond

    glb = new_glb("test", "test", [])
    add_plant_materials(glb)
    made = json.loads(json.dumps(glb.document["materials"]))
    assert len(made) == 10
    for material in made:
        assert material == materials(lit)[material["name"]]
    mesh = next(m for m in lit.document["meshes"] if m["name"] == "pond")
    water = lit.accessor(mesh["primitives"][0]["attributes"]["POSITION"])
    np.testing.assert_array_equal(water, pond().position.astype("<f4"))
    for name in [name for name in sys.modules if name.split(".")[0] == "meadow"]:
        del sys.modules[name]
