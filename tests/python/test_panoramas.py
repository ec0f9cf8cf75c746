"""Pictures all around, seen without rays: gratings against the modulation transfer of every
acceptance, layouts against each other and against rays, seams, poles and rims."""

import warnings

import numpy as np
import pytest
from picture_files import write_exr
from PIL import Image

import omma
from omma import Acceptance, Eye
from omma.job.picture_info import describe_picture
from omma.rendering import CubeFaces, Equirectangular, Fisheye, PanoramaView, see_panorama
from omma.rendering.picture_layouts import pixels_of

WIDTH = np.radians(4.0)
KINDS = {
    "gaussian": Acceptance.gaussian(WIDTH),
    "elongated": Acceptance.gaussian(WIDTH, WIDTH / 2, np.radians(30)),
    "pillbox": Acceptance.pillbox(WIDTH),
    "airy": Acceptance.airy(20e-6, 500),
    "lens_rhabdom": Acceptance.lens_rhabdom(25e-6, 60e-6, 2e-6, 500),
    "table": Acceptance.table(np.radians([0, 1, 2, 3, 4]), [1.0, 0.7, 0.3, 0.1, 0.0]),
}
LAYOUTS = [
    Equirectangular(180, 360),
    CubeFaces(90),
    Fisheye(240, 240, 360),
    Fisheye(300, 320, 180, "orthographic"),
    Fisheye(200, 200, 200, "equisolid"),
    Fisheye(300, 320, 200, "stereographic", circle_px=280),
]


def test_pictures_that_are_no_whole_sphere_are_told(tmp_path, recwarn):
    """Of a file, and of an array where nothing but a panorama is meant; small ones are made up."""
    eye = omma.eye.generate_eye(20)
    strip = np.full((40, 120, 3), 128, np.uint8)
    Image.fromarray(strip).save(tmp_path / "strip.png")
    for look in (
        lambda: omma.rendering.see_panorama(strip, eye),
        lambda: omma.rendering.see_panorama(tmp_path / "strip.png", eye),
        lambda: omma.Background.image(tmp_path / "strip.png"),
        lambda: omma.light.panorama(strip, ultraviolet="dark"),
    ):
        with pytest.warns(UserWarning, match="120 x 40 pixels are stretched over the whole sphere"):
            look()
    omma.rendering.see_panorama(strip[:8], eye)
    omma.rendering.see_panorama(np.ones((61, 120, 3), np.float32), eye)
    fisheye = omma.rendering.Fisheye(40, 120, field_deg=180)
    omma.rendering.see_panorama(tmp_path / "strip.png", eye, layout=fisheye)
    assert not [one for one in recwarn if issubclass(one.category, UserWarning)]


def test_backgrounds_that_are_no_whole_sphere_are_told(tmp_path, recwarn):
    """Of files and of arrays, where they are read: once."""
    strip = np.full((40, 120, 3), 128, np.uint8)
    world = omma.World(omma.Scene())
    Image.fromarray(strip).save(tmp_path / "strip.png")
    for picture in (strip, strip[..., 0], tmp_path / "strip.png"):
        with pytest.warns(UserWarning, match="120 x 40 pixels") as told:
            world.with_background(omma.Background.image(picture))
        assert [str(one.message) for one in told] == [
            "image: 120 x 40 pixels are stretched over the whole sphere, of which an "
            "equirectangular picture is twice as wide as high"
        ]
        assert told[0].filename == __file__
    world.with_background(omma.Background.image(strip[:8]))
    world.with_background(omma.Background.image(np.ones((61, 120, 3), np.float32)))
    assert not [one for one in recwarn if issubclass(one.category, UserWarning)]


def test_alpha_of_arrays_is_told(tmp_path, recwarn):
    """A file's alpha is left out; an array's would be a fourth band without a word."""
    eye = omma.eye.generate_eye(20)
    rgba = np.full((20, 40, 4), 128, np.uint8)
    Image.fromarray(rgba).save(tmp_path / "rgba.png")
    seen = see_panorama(tmp_path / "rgba.png", eye)
    np.testing.assert_array_equal(seen, see_panorama(rgba[..., :3], eye))
    see_panorama(np.ones((20, 40, 4), np.float32), eye)
    see_panorama(np.full((20, 40, 5), 128, np.uint8), eye)
    assert not [one for one in recwarn if issubclass(one.category, UserWarning)]
    with pytest.warns(UserWarning, match=r"pictures: found four bands in 8 bits, as of RGBA"):
        assert see_panorama(rgba, eye).shape == (20, 4)


def eye_of(axes, acceptance=None, width_rad=WIDTH):
    axes = np.asarray(axes, float).reshape(-1, 3)
    if acceptance is not None:
        return Eye(np.zeros_like(axes), axes, acceptance=acceptance)
    return Eye(np.zeros_like(axes), axes, width_rad)


def ahead(azimuths_deg):
    angles = np.radians(azimuths_deg)
    return np.stack([np.sin(angles), np.zeros_like(angles), -np.cos(angles)], axis=-1)


def smooth(directions):
    """Radiance (..., 2) that changes little within a pixel."""
    x, y, z = np.moveaxis(directions, -1, 0)
    return np.stack([1 + 0.3 * x + 0.5 * y * z, 2 + np.sin(3 * z) + 0.2 * x * y], axis=-1)


def picture_of(layout):
    directions, _ = layout.at(*pixels_of(layout))
    return smooth(directions).reshape(*layout.shape, 2)


@pytest.mark.parametrize("name", KINDS)
def test_gratings_lose_what_the_modulation_transfer_says(name):
    """Vertical stripes along the horizon, within what a sphere is no plane: of Airy's pattern 2 %
    lie beyond 10 degrees."""
    cycles = 40
    columns = 1440
    azimuth = 2 * np.pi * ((np.arange(columns) + 0.5) / columns - 0.5)
    picture = np.broadcast_to(
        (1 + np.cos(cycles * azimuth))[None, :, None], (columns // 2, columns, 1)
    )
    phases = np.array([0.0, 360 / cycles / 2])
    seen = see_panorama(picture, eye_of(ahead(phases), KINDS[name]))[:, 0]
    # To the right is an azimuth of 90 degrees. Pixels themselves lose sinc(cycles / columns).
    expected = KINDS[name].mtf(cycles / (2 * np.pi), np.pi / 2) * np.sinc(cycles / columns)
    assert (seen[0] - seen[1]) / 2 == pytest.approx(
        expected, abs=0.002 if name == "airy" else 0.001
    )
    assert (seen[0] + seen[1]) / 2 == pytest.approx(1, abs=0.002)


@pytest.fixture(scope="module")
def seen_finely():
    """An eye all round, and what it sees of a fine picture."""
    eye = omma.eye.generate_eye(100)
    fine = Equirectangular(360, 720)
    return eye, PanoramaView(eye, fine).see(picture_of(fine))


@pytest.mark.parametrize("layout", LAYOUTS, ids=repr)
def test_each_layout_shows_the_same(layout, seen_finely):
    eye, expected = seen_finely
    view = PanoramaView(eye, layout)
    seen = view.see(picture_of(layout))
    shown = view.coverage > 0.999
    assert shown.sum() > 20
    # A pixel of 1.5 degrees has the radiance of its middle: in each of two directions by h² / 24
    # times a second derivative of at most 9 another than its mean. What lies beyond the rim is
    # left out, and differs by at most the picture's range.
    allowed = 2 * np.radians(1.5) ** 2 / 24 * 9 + (1 - view.coverage) * np.ptp(expected)
    assert (np.abs(seen - expected)[shown] < allowed[shown, None]).all()
    # All of the sphere, or the share of it within the rim.
    _, solid_angle = layout.at(*pixels_of(layout))
    rim = np.radians(layout.field_deg / 2) if isinstance(layout, Fisheye) else np.pi
    assert solid_angle.sum() == pytest.approx(2 * np.pi * (1 - np.cos(rim)), rel=0.01)


def test_a_uniform_picture_has_its_radiance_everywhere():
    eye = omma.eye.generate_eye(500)
    assert np.abs(see_panorama(np.full((90, 180, 4), 3.0), eye) - 3).max() < 1e-4


def test_the_same_as_many_rays():
    eye = omma.eye.generate_eye(50)
    layout = Equirectangular(180, 360)
    picture = np.concatenate([picture_of(layout), np.ones((180, 360, 1))], axis=-1)
    nothing = omma.scene.box((1e-6, 1e-6, 1e-6), center_m=(0, -50, 0))
    world = omma.World(nothing, background=omma.Background.image(picture.astype(np.float32)))
    rays = omma.Renderer(world, eye, omma.Fixed(4096), footprints=False).render(np.eye(4))[0]
    assert np.abs(see_panorama(picture, eye) - rays).max() < 2e-3


@pytest.mark.parametrize("pixels", [4, 6, 10])
def test_rays_see_backgrounds_smoothed_between_pixels(pixels):
    """A bias, as docs/scenes.md has it: sinc² of pixels in a wavelength, sinc of flat ones."""
    cycles = 180 // pixels
    around = np.radians(np.arange(180) * 2 + 1)
    stripes = np.tile(0.5 + 0.4 * np.cos(cycles * around), (90, 1))
    picture = np.repeat(stripes[..., None], 3, axis=2).astype(np.float32)
    azimuths = np.arange(16 * 180) / 8 + 1 / 16  # sixteen in each pixel
    eye, nothing = eye_of(ahead(azimuths), width_rad=0.0), omma.Scene()

    def kept(responses):
        wave = np.exp(-1j * cycles * np.radians(azimuths))
        return 2 * abs(np.mean(responses[:, 0] * wave)) / 0.4

    def by_rays(shown):
        world = omma.World(nothing, background=omma.Background.image(shown))
        return kept(omma.Renderer(world, eye, omma.Fixed(1)).render(np.eye(4))[0])

    flat, finer = np.sinc(1 / pixels), np.repeat(np.repeat(picture, 4, 0), 4, 1)
    assert by_rays(picture) == pytest.approx(flat**2, abs=1e-3)
    assert kept(see_panorama(picture, eye)) == pytest.approx(flat, abs=1e-3)
    assert by_rays(finer) == pytest.approx(flat * np.sinc(1 / pixels / 4), abs=1e-3)


def test_turning_the_head_is_turning_the_picture():
    """Over the seam behind, and at the poles."""
    rng = np.random.default_rng(1)
    picture = rng.random((60, 120, 3))
    eye = eye_of([[0, 1, 0.01], [0, -1, 0.01], [0, 0, 1], [0.1, 0.2, 1], [1, 0, 0]])
    turned = omma.poses_from_angles([[0, 0, 0]], [[90, 0, 0]])[0]  # to the right
    by_head = see_panorama(picture, eye, turned)
    by_picture = see_panorama(np.roll(picture, -30, axis=1), eye)
    assert np.abs(by_head - by_picture).max() < 1e-5
    assert np.abs(by_head - see_panorama(picture, eye)).max() > 0.01
    assert np.array_equal(see_panorama(picture, eye, turned[:3, :3]), by_head)


def test_an_edge_is_half_of_each_side():
    picture = np.zeros((180, 360, 1))
    picture[:, 180:] = 1
    for acceptance in KINDS.values():
        assert see_panorama(picture, eye_of(ahead([0.0]), acceptance))[0, 0] == pytest.approx(
            0.5, abs=1e-3
        )


def test_without_width_it_is_the_pixel_at_the_axis():
    rng = np.random.default_rng(2)
    picture = rng.random((18, 36, 1))
    eye = eye_of(ahead([5.0, 95.0]), width_rad=0.0)
    assert see_panorama(picture, eye)[:, 0] == pytest.approx(
        [picture[9, 18, 0], picture[9, 27, 0]], rel=1e-6
    )


def test_beyond_the_rim_nothing_is_made_up():
    eye = eye_of(ahead([0, 88, 90, 92, 180]))
    layout = Fisheye(180, 180)
    view = PanoramaView(eye, layout)
    seen = view.see(np.ones((180, 180, 1)))[:, 0]
    assert view.coverage == pytest.approx([1, 0.88, 0.5, 0.12, 0], abs=0.02)
    assert np.isnan(seen[3:]).all()
    assert seen[:2] == pytest.approx(1)
    all_or_none = PanoramaView(eye, layout, allow_missing=0.01)
    assert np.isnan(all_or_none.see(np.ones((180, 180, 1)))[1:]).all()
    with pytest.raises(omma.Error, match="it shows at most 0% of what"):
        PanoramaView(eye_of(ahead([180.0])), layout)


def test_pictures_of_files_are_srgb_and_linear(tmp_path):
    bright = np.full((20, 40, 3), 0.5, np.float32)
    eye = eye_of(ahead([0.0]))
    grey = np.full((20, 40, 3), 188, np.uint8)  # 0.5029 of linear white
    assert see_panorama(grey, eye)[0] == pytest.approx([0.5029] * 3, abs=1e-4)
    assert see_panorama(bright, eye)[0] == pytest.approx([0.5] * 3)
    Image.fromarray(grey).save(tmp_path / "grey.png")
    assert np.array_equal(see_panorama(tmp_path / "grey.png", eye), see_panorama(grey, eye))


def test_a_film_is_seen_picture_by_picture():
    rng = np.random.default_rng(3)
    film = rng.random((5, 30, 60, 3)).astype(np.float32)
    eye = omma.eye.generate_eye(50)
    view = PanoramaView(eye, Equirectangular(30, 60))
    together = view.see(film)
    assert together.shape == (5, 50, 3)
    assert np.array_equal(np.stack(list(view.see_each(film))), together)
    assert np.allclose(view.weights @ film[2].reshape(-1, 3), together[2], atol=1e-6)


def test_bad_pictures_are_refused():
    eye = omma.eye.generate_eye(20)
    view = PanoramaView(eye, CubeFaces(8))
    with pytest.raises(omma.Error, match=r"pictures: expected shape \(..., 6, 8, 8, bands\)"):
        view.see(np.ones((8, 8, 3)))
    with pytest.raises(omma.Error, match=r"pictures: expected uint8 \(sRGB\) or float .* uint16"):
        view.see(np.ones((6, 8, 8, 3), np.uint16))
    with pytest.raises(omma.Error, match="picture: expected shape"):
        see_panorama(np.ones((8, 8)), eye)
    with pytest.raises(omma.Error, match=r"none\.png"):
        see_panorama("none.png", eye)
    with pytest.raises(omma.Error, match="world_from_head: expected a rotation"):
        PanoramaView(eye, CubeFaces(8), 2 * np.eye(3))
    # A path is no pose; a path of one is.
    path = omma.poses_from_angles(np.zeros((2, 3)), [[0, 0, 0], [90, 0, 0]])
    with pytest.raises(omma.Error, match=r"world_from_head: expected one pose \(4, 4\), found 2"):
        see_panorama(np.ones((8, 16, 3)), eye, path)
    picture = np.random.default_rng(0).random((8, 16, 3))
    one, alone = (see_panorama(picture, eye, pose) for pose in (path[1:], path[1]))
    assert np.array_equal(one, alone)
    with pytest.raises(omma.Error, match="field_deg: expected 1 to 180"):
        Fisheye(8, 8, 200, "orthographic")
    with pytest.raises(omma.Error, match="lens: expected one of"):
        Fisheye(8, 8, lens="round")
    with pytest.raises(omma.Error, match="height: expected 1 to"):
        Equirectangular(0, 8)


def test_pixels_that_are_no_radiance_are_refused():
    eye = omma.eye.generate_eye(20)
    view = omma.rendering.PanoramaView(eye, omma.rendering.Equirectangular(8, 16))
    picture = np.full((8, 16, 3), 0.5, np.float32)
    bands = omma.light.Bands.equal(1, 400, 700)
    for value, words in ((-1, "-1"), (np.inf, "inf")):
        wrong = picture.copy()
        wrong[3, 4, 1] = wrong[5, 6, 0] = value
        told = rf"found {words} in band 1 of pixel \(3, 4\), of 2"
        for see in (view.see, lambda one: omma.rendering.see_panorama(one, eye)):
            with pytest.raises(omma.Error, match=f"pictures: .*{told}"):
                see(wrong)
    with pytest.raises(omma.Error, match="pictures: expected shape"):
        view.see(np.inf)
    wrong[3, 4, 1] = wrong[5, 6, 0] = -1
    with pytest.raises(omma.Error, match=r"image: .*pixel \(3, 4\)"):
        omma.light.panorama(wrong, ultraviolet="dark")
    with pytest.raises(omma.Error, match=r"radiance: .*-1 in band 0 of pixel \(3, 4\)"):
        omma.light.panorama_bands(wrong[:, :, 1:2], bands=bands)
    with pytest.warns(UserWarning, match=r"background: .*pixel \(3, 4\)"):
        omma.World(omma.scene.plane(), background=omma.Background.image(wrong))
    # Differences of pictures go through the matrix, and what is not known stays so.
    assert view.weights @ wrong.reshape(-1, 3) is not None
    wrong[wrong < 0] = np.nan
    assert np.isnan(view.see(wrong)).any()


def test_files_whose_pixels_are_no_radiance_are_named(tmp_path):
    """What is not known comes as an array; a background alone may be a difference of pictures."""
    eye = omma.eye.generate_eye(20)
    path = tmp_path / "sky.exr"
    see = {
        "background": lambda: omma.Background.image(path),
        "see_panorama": lambda: see_panorama(path, eye),
        "light": lambda: omma.light.panorama(path, ultraviolet="dark"),
        "paint": lambda: omma.scene.plane(paint=path),
        "info": lambda: describe_picture(path),
    }
    pixels = np.full((8, 16, 3), 0.5, np.float32)
    write_exr(path, pixels)
    for read in see.values():
        read()
    for value in (np.nan, np.inf):
        pixels[3, 4, 1] = value
        write_exr(path, pixels)
        for read in see.values():
            with pytest.raises(
                omma.Error, match=r"sky\.exr: .*expected finite pixels, found .* in row 3, column 4"
            ):
                read()
    pixels[3, 4, 1] = -1
    write_exr(path, pixels)
    for name in ("see_panorama", "light", "paint"):
        with pytest.raises(omma.Error, match=r"sky\.exr: .*-1 in band 1 of pixel \(3, 4\), of 1"):
            see[name]()
    pixels[3, 4, 1] = np.nan
    bands = omma.light.Bands.equal(3, 400, 700)
    for read in (
        lambda: omma.light.panorama(pixels, ultraviolet="dark"),
        lambda: omma.light.panorama_bands(pixels, bands=bands),
    ):
        with pytest.raises(omma.Error, match=r"nan in band 1 of pixel \(3, 4\), of 1"):
            read()


def test_floats_of_pictures_in_8_bits_are_told():
    rng = np.random.default_rng(4)
    bytes_ = rng.integers(0, 256, (8, 16, 3)).astype(np.uint8)
    eye = omma.eye.generate_eye(20)
    plane = omma.scene.plane(paint=bytes_)
    world = omma.World(plane)
    ways = {
        "pictures": lambda one: omma.rendering.see_panorama(one, eye),
        "image": lambda one: omma.light.panorama(one, ultraviolet="dark"),
        "background": lambda one: world.with_background(omma.Background.image(one)),
        "picture": lambda one: world.set_image(0, one),
        "paint": lambda one: omma.scene.plane(paint=one),
        "wall": lambda one: omma.scene.drum(1, 1, one),
    }
    board = np.where(bytes_ > 100, np.float32(255), np.float32(0))
    for name in ("picture", "paint", "wall"):
        for image in (omma.scene.Image(board), omma.scene.Image(bytes_.astype(np.float32))):
            with pytest.warns(UserWarning, match=f"^{name}: .*whole numbers up to 255"):
                ways[name](image)
    for name, way in ways.items():
        with pytest.warns(UserWarning, match=f"^{name}: .*whole numbers up to 25.*uint8"):
            way(bytes_.astype(np.float32))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            way(bytes_)
            way((bytes_ / np.float32(255)).astype(np.float32))
            way(np.full((8, 16, 3), 100, np.float32))
            way(rng.gamma(1, 30, (8, 16, 3)).astype(np.float32))


def test_pictures_of_less_than_no_light_are_refused_at_every_door():
    """Backgrounds alone may be differences of pictures, and are warned of (above)."""
    rng = np.random.default_rng(5)
    good = rng.uniform(0, 1, (8, 16, 3)).astype(np.float32)
    wrong = good.copy()
    wrong[3, 4, 1] = -0.2
    world = omma.World(omma.scene.drum(1, 1, good))
    box = omma.scene.box(paint=good)
    ways = {
        "picture": lambda one: world.set_image(0, one),
        "wall": lambda one: omma.scene.drum(1, 1, one),
        "left": lambda one: omma.scene.corridor(2, 1, 1, one, good),
        "paint": lambda one: omma.scene.plane(paint=one),
    }
    for name, way in ways.items():
        for one in (wrong, omma.scene.Image(wrong), wrong.astype(np.float64)):
            with pytest.raises(omma.Error, match=rf"^{name}: .*-0\.2 in band 1 of pixel \(3, 4\)"):
                way(one)
        way(good)
    scene = box.replace(images=[omma.scene.Image(wrong)])
    with pytest.raises(omma.Error, match=r"^images\[0\]: .*pixel \(3, 4\)"):
        omma.World(scene)
    seen = omma.Renderer(world, omma.eye.generate_eye(20)).render(np.eye(4))
    assert seen.min() >= 0
