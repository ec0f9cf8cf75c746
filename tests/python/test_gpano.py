"""What files of panoramas say of themselves in GPano: a part of the sphere is refused, how the
camera was held is told, by whatever the picture is read."""

import warnings

import numpy as np
import pytest
from picture_files import gpano_packet, write_with_xmp

import omma
from omma.base.gpano import gpano_of
from omma.job.picture_info import describe_picture
from omma.rendering import Equirectangular, Fisheye, see_panorama
from omma.scene.backgrounds import parse_background

PIXELS = np.random.default_rng(1).integers(0, 256, (16, 32, 3), dtype=np.uint8)
EYE = omma.eye.generate_eye(20)
BANDS = omma.light.Bands.equal(4, 400, 700)
WHOLE = {
    "ProjectionType": "equirectangular",
    "CroppedAreaImageWidthPixels": 32,
    "CroppedAreaImageHeightPixels": 16,
    "FullPanoWidthPixels": 32,
    "FullPanoHeightPixels": 16,
    "CroppedAreaLeftPixels": 0,
    "CroppedAreaTopPixels": 0,
}
PART = WHOLE | {
    "FullPanoWidthPixels": 64,
    "FullPanoHeightPixels": 32,
    "CroppedAreaLeftPixels": 16,
    "CroppedAreaTopPixels": 8,
}
POSE = {"PoseHeadingDegrees": 90, "PosePitchDegrees": 30, "PoseRollDegrees": 10}
READERS = {
    "see_panorama": lambda path: see_panorama(path, EYE),
    "see_panorama of a layout": lambda path: see_panorama(
        path, EYE, layout=Equirectangular(16, 32)
    ),
    "Background.image": omma.Background.image,
    "--background": lambda path: parse_background(str(path)),
    "light.panorama": lambda path: omma.light.panorama(path, bands=BANDS),
}
FORMS = {
    "a.jpg": {},
    "elements.jpg": {"as_elements": True},
    "prefix.jpg": {"prefix": "pano-1"},
    "a.png": {},
    "packed.png": {"as_elements": True},
    "a.webp": {},
}


def write(folder, said, name="a.jpg"):
    path = folder / name
    write_with_xmp(path, PIXELS, gpano_packet(said, **FORMS[name]), is_packed="packed" in name)
    return path


@pytest.mark.parametrize("name", FORMS)
def test_what_is_said_is_read_from_every_kind_of_file(tmp_path, name):
    said = gpano_of(write(tmp_path, PART | POSE, name))
    assert said.projection == "equirectangular"
    assert (said.size, said.full, said.corner) == ((32, 16), (64, 32), (16, 8))
    assert said.pose_deg == (90, 30, 10)


@pytest.mark.parametrize("reader", READERS)
def test_parts_of_the_sphere_are_refused(tmp_path, reader):
    with pytest.raises(
        omma.Error, match=r"a\.jpg: .*a part of it, .*: 32 x 16 of 64 x 32 pixels, from column 16"
    ):
        READERS[reader](write(tmp_path, PART))
    with pytest.raises(omma.Error, match=r"a\.jpg: .*an equirectangular picture.*'cylindrical'"):
        READERS[reader](write(tmp_path, WHOLE | {"ProjectionType": "cylindrical"}))


@pytest.mark.parametrize("reader", READERS)
def test_cameras_that_were_turned_are_told_of(tmp_path, reader):
    with pytest.warns(UserWarning, match="heading 90°, pitch 30°, roll 10°") as told:
        READERS[reader](write(tmp_path, WHOLE | POSE))
    assert [one.filename for one in told] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        READERS[reader](write(tmp_path, WHOLE))
        READERS[reader](write(tmp_path, {"PoseHeadingDegrees": 360, "PosePitchDegrees": 0.0}))


def test_what_is_no_panorama_is_not_asked(tmp_path):
    """A solid's picture, and a fisheye's, whatever they say; and a part that has been padded."""
    path = write(tmp_path, PART | POSE | {"ProjectionType": "fisheye"})
    padded = write(tmp_path, PART | {"FullPanoWidthPixels": 32, "FullPanoHeightPixels": 16,
                                     "CroppedAreaImageWidthPixels": 20}, "a.png")  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.scene.plane(paint=path)
        see_panorama(path, EYE, layout=Fisheye(16, 32, field_deg=180))
        for read in READERS.values():
            read(padded)


def test_broken_packets_say_nothing(tmp_path):
    words = gpano_packet(PART).decode()
    for packet in (
        b"",
        b"\xff\xfe\0",
        words.replace("http://ns.google", "http://ns.other").encode(),
        words[: words.index("GPano:Cropped")].encode(),
        gpano_packet({name: "many" for name in PART if name != "ProjectionType"}),
        gpano_packet({name: "nan" for name in POSE} | {"FullPanoWidthPixels": "1e999"}),
    ):
        for name in ("a.jpg", "a.png"):
            path = tmp_path / name
            write_with_xmp(path, PIXELS, packet)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                omma.Background.image(path)
    path = tmp_path / "packed.png"
    write_with_xmp(path, PIXELS, gpano_packet(PART), is_packed=True)
    data = path.read_bytes()
    at = data.index(b"XML:com.adobe.xmp\0") + 22
    path.write_bytes(data[:at] + b"\0\0" + data[at + 2 :])
    assert gpano_of(path) is None
    assert gpano_of(tmp_path) is None


def test_info_says_what_a_panorama_is(tmp_path):
    def told(said):
        return dict(describe_picture(write(tmp_path, said)))

    assert told(PART)["panorama"].startswith("a part of the sphere")
    assert told({"ProjectionType": "cylindrical"})["panorama"].startswith("none: 'cylindrical'")
    lines = told(WHOLE | POSE)
    assert lines["panorama"].startswith("of the whole sphere")
    assert lines["camera"].startswith("heading 90°, pitch 30°, roll 10°")
    assert "camera" not in told(WHOLE)


def test_heads_are_turned_into_a_picture_as_the_warning_says():
    """GPano: heading is clockwise from north, pitch lifts the middle, and as roll grows the horizon
    turns counterclockwise in the picture."""
    narrow = omma.Eye([[0, 0, 0]], [[0, 0, -1]], np.radians(3.0))
    world_from_picture = omma.poses_from_angles((0, 0, 0), (90, 30, 10))[0]
    picture_from_world = np.linalg.inv(world_from_picture)
    spot = np.zeros((90, 180, 3), np.float32)
    spot[44:46, 89:91] = 1
    # The picture's middle is 30° above east.
    toward = omma.poses_from_angles((0, 0, 0), (90, 30, 0))[0]
    assert see_panorama(spot, narrow, picture_from_world @ toward)[0, 0] > 0.3
    assert see_panorama(spot, narrow, picture_from_world)[0, 0] < 1e-6
    # A heading alone also turns columns, and light.
    east = omma.poses_from_angles((0, 0, 0), (90, 0, 0))[0]
    rolled = np.roll(spot, 180 * 90 // 360, axis=1)
    assert see_panorama(rolled, narrow, east)[0, 0] > 0.3
    lit = omma.light.panorama(spot, bands=BANDS).turned(90)
    assert lit.radiance([1, 0, 0]).max() > 0
    assert lit.radiance([0, 0, -1]).max() == 0
    # The horizon in a picture whose camera rolled to the right goes up on its right.
    to_the_right = omma.poses_from_angles((0, 0, 0), (0, 0, 10))[0]
    east_in_picture = np.linalg.inv(to_the_right)[:3, :3] @ (1, 0, 0)
    assert east_in_picture[1] > 0
