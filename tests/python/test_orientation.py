"""Which way up pictures of files are, beside Pillow."""

import numpy as np
import pytest
from PIL import Image, ImageOps

import omma
from omma.base.orientation import load_upright, orientation_of
from omma.job.picture_info import describe_picture
from omma.rendering import see_panorama
from omma.scene.backgrounds import parse_background
from omma.scene.solids import plane


@pytest.mark.parametrize("kind", ["jpg", "png", "webp"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_pictures_of_files_are_turned_as_their_exif_says(tmp_path, kind, orientation):
    """Cameras keep pixels as their sensor read them; Pillow knows how they are to be turned."""
    kept = np.zeros((8, 16, 3), np.uint8)
    kept[:, :8, 0], kept[:4, :, 1] = 255, 200
    exif = Image.Exif()
    exif[271], exif[274] = "a camera", orientation
    path = tmp_path / f"all_around.{kind}"
    Image.fromarray(kept).save(path, exif=exif)
    with Image.open(path) as file:
        upright = np.asarray(ImageOps.exif_transpose(file).convert("RGB"))
    assert orientation_of(path) == orientation
    near = {"rtol": 0, "atol": 0 if kind == "png" else 3}
    found = load_upright(path).pixels[..., :3]
    np.testing.assert_allclose(found.astype(int), upright.astype(int), **near)
    for background in (parse_background(str(path)), omma.Background.image(path)):
        np.testing.assert_array_equal(background.pixels[..., :3], found)
    wall = plane((1, 1), paint=path)
    np.testing.assert_array_equal(wall.images[0].pixels[..., :3], found)
    if orientation < 5:
        eye = omma.eye.generate_eye(20)
        np.testing.assert_array_equal(see_panorama(path, eye), see_panorama(found, eye))
        bands = omma.light.Bands.equal(4, 400, 700)
        lights = [omma.light.panorama(one, bands=bands) for one in (path, found)]
        assert lights[0] == lights[1]
    assert ("orientation" in dict(describe_picture(path))) == (orientation != 1)


def test_exif_that_says_nothing_turns_nothing(tmp_path):
    path = tmp_path / "broken.jpg"
    Image.new("RGB", (4, 2)).save(path)
    plain = path.read_bytes()
    beyond = b"\xff" * 4
    for tiff in (b"", b"II", b"XX*\0\x08\0\0\0", b"MM\0*" + beyond, b"MM\0*\0\0\0\x08" + beyond):
        block = b"Exif\0\0" + tiff
        path.write_bytes(
            plain[:2] + b"\xff\xe1" + (len(block) + 2).to_bytes(2, "big") + block + plain[2:]
        )
        assert orientation_of(path) == 1
        assert load_upright(path).pixels.shape == (2, 4, 4)
    for rest in (b"", b"\xff", b"\xff\xe1\0", b"\xff\xe1\0\0"):
        path.write_bytes(plain[:2] + rest)
        assert orientation_of(path) == 1
    assert orientation_of(tmp_path) == 1
    assert orientation_of(tmp_path / "none.jpg") == 1
