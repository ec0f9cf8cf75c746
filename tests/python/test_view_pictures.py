"""Pictures and shapes of the window: colours, bands, receptors, projections, the scene in 3D."""

import json
import struct

import numpy as np
import pytest
from conftest import make_eye
from view_checks import LEVEL

import omma
from omma.view.command import Sources, render_command
from omma.view.painting import (
    PROJECTIONS,
    channels_of,
    eye_ids,
    paint_eye,
    shown_values,
    unseen_in,
    white_of,
)
from omma.view.picture_ids import PictureIds, without_margins
from omma.view.scene_mesh import drawn_scene
from omma.view.state import Look, Looker


def test_pictures_show_what_was_rendered(looker):
    seen = looker.see(Look(LEVEL, samples=4))
    channels = {one.name: one for one in channels_of(looker.world, looker.eye)}
    assert list(channels) == ["colours", "red", "green", "blue"]
    ids = eye_ids(looker.eye, "Mollweide", 400)
    colours = shown_values(looker.world, looker.eye, seen, channels["colours"])
    hidden = unseen_in(ids, "Mollweide")
    pixels = paint_eye(ids, colours, 1.0, 0.0, hidden=hidden)
    assert np.array_equal(
        pixels, omma.picture.project(looker.eye, seen.responses, "mollweide", 400)
    )
    in_green = shown_values(looker.world, looker.eye, seen, channels["green"])
    green = paint_eye(ids, in_green, 1, 0, hidden=hidden)
    assert np.array_equal(green[..., 0], pixels[..., 1])
    assert np.array_equal(green[..., 0], green[..., 2])
    brighter = paint_eye(ids, colours, 1.0, 1.0, hidden=hidden)
    assert np.array_equal(
        brighter, omma.picture.project(looker.eye, 2 * seen.responses, "mollweide", 400)
    )
    chosen = int(ids[100, 200])
    marked = (paint_eye(ids, colours, 1.0, 0.0, chosen, hidden) != pixels).any(axis=2)
    assert marked.any()
    assert not marked[ids == chosen].any()
    with pytest.raises(omma.Error, match="projection: expected one of"):
        eye_ids(looker.eye, "none", 400)


def test_worlds_that_are_lit_are_shown_by_band_and_in_colours(ground):
    light = omma.light.overcast_sky(40, bands=omma.light.Bands.equal(4, 400, 700))
    world = omma.World(
        omma.load_scene(ground / "ground.gltf"), light=light, lighting="path", depth=1
    )
    looker = Looker(world, make_eye(200))
    channels = {one.name: one for one in channels_of(world, looker.eye)}
    assert list(channels)[:2] == ["colours", "band 0, 438 nm"]
    assert len(channels) == 5
    seen = looker.see(Look(LEVEL, samples=4))
    colours = shown_values(world, looker.eye, seen, channels["colours"])
    assert np.array_equal(colours, omma.picture.bands_to_rgb(seen.responses, light))
    band = shown_values(world, looker.eye, seen, channels["band 0, 438 nm"])
    assert np.array_equal(band[:, 0], seen.responses[:, 0])
    # Radiance in photons, 1e17 and more, is shown by what nearly all of it stays below.
    white = white_of(world, channels["band 0, 438 nm"], band)
    assert 0.9 < np.mean(band[:, 0] <= white) < 1
    assert white > 1e10
    command, why = render_command(Sources("a", ("b",), lit=True), seen)
    assert (command, "made in Python" in why) == ("", True)


def test_receptors_are_shown_by_kind(ground):
    eye = omma.receptors.assign_receptors(make_eye(60), omma.receptors.honeybee_ommatidia())
    world = omma.World(omma.load_scene(ground / "ground.gltf"))
    looker = Looker(world, eye, ultraviolet=np.array([0, 0, 1.0]))
    channels = {one.name: one for one in channels_of(world, eye)}
    seen = looker.see(Look(LEVEL, samples=4, receptors=True))
    plain = omma.Renderer(world, eye, omma.Fixed(4))
    expected = plain.render_receptors(LEVEL.world_from_head, ultraviolet=(0, 0, 1))
    assert np.array_equal(seen.receptors, expected[0])
    false = shown_values(world, eye, seen, channels["receptors, false colours"])
    assert false.shape == (60, 3)
    for column, name in enumerate(("green", "blue", "ultraviolet")):
        one = shown_values(world, eye, seen, channels[f"receptor {name}"])
        assert np.allclose(one[:, 0], false[:, column])
        assert np.array_equal(one[:, 0], one[:, 2])
    assert np.ptp(false) > 0.01


def test_things_in_many_places_are_stored_once():
    box = omma.scene.box((0.1, 0.1, 0.1))
    mesh = box.meshes[0]
    places = []
    for k in range(10):
        matrix = np.eye(4)
        matrix[:3, 3] = (k, 0, 0)
        places.append(omma.scene.Instance(0, matrix))
    scene = omma.Scene(meshes=[mesh.replace(material=None)], instances=places)
    still = drawn_scene(omma.World(scene)).still
    length = struct.unpack_from("<I", still, 12)[0]
    document = json.loads(still[20 : 20 + length])
    roots = document["scenes"][0]["nodes"]
    assert len(roots) == 1
    given = document["nodes"][roots[0]]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
    accessor = document["accessors"][given["TRANSLATION"]]
    view = document["bufferViews"][accessor["bufferView"]]
    start = 20 + length + 8 + view["byteOffset"]
    found = np.frombuffer(still[start : start + view["byteLength"]], "<f4").reshape(-1, 3)
    assert np.array_equal(np.sort(found[:, 0]), np.arange(10))


def test_what_shines_is_drawn_without_a_light(tmp_path):
    """glTF's unlit materials have no emission: base colour and emission are one colour there."""
    material = omma.scene.Material
    picture, other = omma.scene.TextureUse(0), omma.scene.TextureUse(1)
    given = [
        (material("sum", base_color=(0.2, 0.3, 0.9, 1), emissive=(0.5, 0, 0.4)), (0.7, 0.3, 1)),
        (material("matt", base_color=(0.2, 0.3, 0.4, 1)), (0.2, 0.3, 0.4)),
        (
            material("screen", base_color=(0, 0, 0, 1), emissive=(2, 2, 1), emissive_texture=other),
            (1, 1, 1),
        ),
        (
            material("cut", base_color_texture=picture, emissive=(5, 5, 5), alpha_mode="mask"),
            (1, 1, 1),
        ),
    ]
    box = omma.scene.box((0.1, 0.1, 0.1)).meshes[0]
    scene = omma.Scene(
        meshes=[
            box.replace(material=k, texture_coordinates=box.positions_m[:, :2])
            for k in (*range(len(given)), None)
        ],
        materials=[one for one, _ in given],
        images=[omma.scene.Image(np.ones((2, 2, 4))), omma.scene.Image(np.ones((2, 2, 3)))],
        textures=[omma.scene.Texture(0), omma.scene.Texture(1)],
    )
    (tmp_path / "drawn.glb").write_bytes(drawn_scene(omma.World(scene)).still)
    scene = omma.load_scene(tmp_path / "drawn.glb")
    *drawn, plain = (scene.materials[mesh.material] for mesh in scene.meshes)
    assert (plain.unlit, plain.base_color) == (True, (1, 1, 1, 1))
    for one, (material_given, color) in zip(drawn, given, strict=True):
        assert one.unlit
        assert one.emissive == (0, 0, 0)
        assert one.base_color[:3] == pytest.approx(color)
        assert one.alpha_mode == material_given.alpha_mode
    assert drawn[2].base_color_texture is not None


def test_lit_by_lamps_alone(ground):
    """The page lights what its own lamps light, in words, and the sky is black."""
    eye = omma.load_eye(ground / "plain.csv")
    disc = omma.scene.disc(0.1)
    glow = disc.replace(materials=[one.replace(emissive=(1, 0.5, 0.2)) for one in disc.materials])
    world = omma.World(glow, light=omma.light.lamps(), ultraviolet="dark")
    with omma.view.show(world, eye, port=0) as window:
        assert "lit by the page" in window._page.scene.note


@pytest.mark.parametrize("projection", PROJECTIONS)
@pytest.mark.parametrize("size", [(800, 800), (1500, 700), (300, 900)])
def test_the_picture_fills_the_room_that_it_has(projection, size):
    eye = omma.species.honeybee_worker().eye
    ids = PictureIds(eye).fitted(projection, *size)
    high, wide = ids.shape
    # One side is that of the room but for the rounding of margins; none is larger by more.
    share = max(wide / size[0], high / size[1])
    assert 0.95 < share < 1.05
    seen = ids >= 0
    # Nothing is left out, and what is grey is at most a narrow rim on each side.
    assert set(np.unique(ids[seen])) <= set(range(len(eye)))
    for axis in (0, 1):
        lines = np.flatnonzero(seen.any(axis=axis))
        assert lines[0] <= 0.02 * max(wide, high)
        assert seen.shape[1 - axis] - 1 - lines[-1] <= 0.02 * max(wide, high)
    if projection == "facets on the eye":
        # 39 % of the whole drawing shows something (the page of one day had 60 % grey).
        whole = eye_ids(eye, projection, 800) >= 0
        assert whole.mean() < 0.45
        assert seen.mean() > 0.65


def test_strips_between_directions_stay():
    ids = np.full((10, 400), -1, np.int32)
    ids[3:6, 50:60] = 1
    ids[3:6, 300:310] = 2
    for between in (False, True):
        found = without_margins(ids, between)
        assert np.count_nonzero(found == 1) == np.count_nonzero(found == 2) == 30
    assert without_margins(ids).shape[1] > 260
    assert without_margins(ids, True).shape[1] < 40
    assert without_margins(np.full((4, 4), -1, np.int32)).shape == (4, 4)
