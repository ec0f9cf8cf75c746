"""Units that LAS files state, across and of heights, and what is told where they are not metres."""

import re
import struct
import warnings

import numpy as np
import pytest
from point_clouds import PLACES, turned, write_las

import omma
from omma.job.points_info import describe_points
from omma.scene import load_points
from omma.scene.las_units import wkt_units

SURVEY_FOOT = 0.3048006096
GEOGCS = (
    'GEOGCS["g",DATUM["d",SPHEROID["s",6378137,298]],PRIMEM["G",0],UNIT["degree",0.0174532925]]'
)


def projected(unit):
    return f'PROJCS["p",{GEOGCS},PROJECTION["tm"],PARAMETER["x",1],{unit},AXIS["X",EAST]]'


def vertical(unit):
    return f'VERT_CS["v (ftUS)",VERT_DATUM["n",2005],{unit},AXIS["Up",UP]]'


METRE, FOOT = 'UNIT["metre",1]', 'UNIT["foot",0.3048]'
FOOT_US = 'UNIT["US survey foot",0.304800609601219,AUTHORITY["EPSG","9003"]]'
BASE = (
    'BASEGEOGCRS["b",DATUM["d",ELLIPSOID["e",6378137,298,LENGTHUNIT["metre",1]]]],'
    'CONVERSION["c",PARAMETER["False easting",2000000,LENGTHUNIT["US survey foot",0.3048006096]]]'
)
ANGLE = 'ANGLEUNIT["degree",0.0174532925199433]'


@pytest.mark.parametrize(
    ("wkt", "words"),
    [
        (projected(METRE), "metres"),
        (projected(FOOT_US), "US survey feet"),
        (projected('UNIT["yard",0.9144]'), "units of 0.9144 m"),
        (projected(METRE).replace("[", "(").replace("]", ")"), "metres"),
        (GEOGCS, "degrees"),
        (f'COMPD_CS["c",{projected(METRE)},{vertical(METRE)}]', "metres"),
        (f'COMPD_CS["c",{projected(METRE)},{vertical(FOOT_US)}]', "metres, heights in US survey "),
        (f'COMPD_CS["c",{projected(FOOT)},{vertical(METRE)}]', "feet, heights in metres"),
        (f'COMPD_CS["c",{GEOGCS},{vertical(METRE)}]', "degrees, heights in metres"),
        # Esri's has two systems beside each other.
        (f'{projected(METRE)},VERTCS["v",VDATUM["d"],PARAMETER["x",0],{FOOT}]', "metres, heights"),
        (f'GEOGCRS["w",DATUM["d"],CS[ellipsoidal,2],AXIS["lat",north],{ANGLE}]', "degrees"),
        (
            f'GEODCRS["w",CS[ellipsoidal,3],AXIS["lat",north,{ANGLE}],AXIS["lon",east,{ANGLE}],'
            'AXIS["h",up,LENGTHUNIT["foot",0.3048]]]',
            "degrees, heights in feet",
        ),
        ('GEODCRS["w",CS[Cartesian,3],AXIS["X",x],LENGTHUNIT["metre",1]]', "not said by the file"),
        (f'PROJCRS["p",{BASE},CS[Cartesian,2],AXIS["E",east],LENGTHUNIT["metre",1]]', "metres"),
        (
            f'PROJCRS["p",{BASE},CS[Cartesian,2],AXIS["E",east,LENGTHUNIT["foot",0.3048]],'
            'AXIS["N",north,LENGTHUNIT["foot",0.3048]]]',
            "feet",
        ),
        (
            f'COMPOUNDCRS["c",PROJCRS["p",{BASE},CS[Cartesian,2],AXIS["E",east],AXIS["N",north],'
            'LENGTHUNIT["metre",1]],VERTCRS["v",VDATUM["d"],CS[vertical,1],AXIS["H",up,'
            'LENGTHUNIT["US survey foot",0.3048006096]]]]',
            "metres, heights in US survey feet",
        ),
        (
            f"BOUNDCRS[SOURCECRS[{projected(FOOT)}],TARGETCRS[{projected(METRE)}]]",
            "feet",
        ),
        # What is cut off or says no length says no unit.
        (projected('UNIT["metre"]'), "not said by the file"),
        (projected('UNIT["metre",none]'), "not said by the file"),
        ('PROJCS["p', "not said by the file"),
        ("]])),[", "not said by the file"),
        ("PROJCS[" * 5000, "not said by the file"),
    ],
)
def test_units_of_wkt(wkt, words):
    assert str(wkt_units(wkt)).startswith(words)
    assert words == "not said by the file" or str(wkt_units(wkt)) != "not said by the file"


def with_record(path, number, content):
    laspy = pytest.importorskip("laspy")
    las = laspy.read(write_las(path))
    las.header.vlrs.append(laspy.VLR("LASF_Projection", number, "", content))
    las.write(path)
    return path


def wkt_file(path, wkt):
    return with_record(path, 2112, wkt.encode() + b"\0")


def key_file(path, **keys):
    rows = [struct.pack("<4H", int(name[1:]), 0, 1, value) for name, value in keys.items()]
    return with_record(path, 34735, struct.pack("<4H", 1, 1, 0, len(rows)) + b"".join(rows))


def told(path, **arguments):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        load_points(path, **arguments)
    return [str(one.message).partition(": ")[2] for one in found]


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"k3072": 32633}, None),
        ({"k1024": 1, "k3076": 9001, "k4099": 9001}, None),
        ({"k1024": 2}, "in degrees, they are read as metres: project them to metres first"),
        ({"k3076": 9002, "k4099": 9002}, "in feet, they are read as metres: give unit=0.3048 "),
        ({"k3076": 9003}, "feet, of heights it says none, .* give unit=0.3048006096 "),
        ({"k3076": 9001, "k4099": 9003}, "heights are in US survey feet, the rest is in metres: s"),
        ({"k3072": 2277, "k4099": 9003}, "says no unit, .* give unit=0.3048006096 .* if all is"),
    ],
)
def test_units_of_geotiff_keys(tmp_path, keys, words):
    found = told(key_file(tmp_path / "a.las", **keys))
    assert len(found) == (words is not None)
    assert words is None or re.search(words, found[0])


def test_a_geotiff_unit_of_its_own_length(tmp_path):
    laspy = pytest.importorskip("laspy")
    path = key_file(tmp_path / "a.las", k3076=32767)
    las = laspy.read(path)
    keys = struct.pack("<12H", 1, 1, 0, 2, 3076, 0, 1, 32767, 3077, 34736, 1, 1)
    las.header.vlrs = [
        laspy.VLR("LASF_Projection", 34735, "", keys),
        laspy.VLR("LASF_Projection", 34736, "", struct.pack("<2d", 7, 0.9144)),
    ]
    las.write(path)
    assert "in units of 0.9144 m, of heights it says none" in told(path)[0]


@pytest.mark.parametrize("up", [None, "y", "-y"])
def test_heights_alone_are_scaled_as_it_is_told(tmp_path, up):
    """The line that is told, typed: in metres across, heights in feet, and the other way round."""
    heights = PLACES * (1, 1, 1 / SURVEY_FOOT) + (0, 0, 100 / SURVEY_FOOT)
    wkt = f'COMPD_CS["c",{projected(METRE)},{vertical(FOOT_US)}]'
    path = wkt_file(write_las(tmp_path / "a.las", heights), wkt)
    las = pytest.importorskip("laspy").read(path)
    las.x, las.y, las.z = heights.T
    las.write(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = omma.load_scene(path, up=up)
    (said,) = [one for one in scene.warnings if "its heights" in one]
    assert "its heights are in US survey feet, the rest is in metres: scale" in said
    line = re.search(r"omma\.scene\.place_scene\(.*\)\)", said)[0]
    placed = eval(line, {"omma": omma, "numpy": np, "scene": scene})
    low, high = placed.bounds
    axis, sign = {None: (1, 1), "y": (2, 1), "-y": (2, -1)}[up]
    middle = sign * (low + high)[axis] / 2
    assert middle == pytest.approx(100, abs=0.1)
    assert (high - low)[axis] == pytest.approx(2, abs=0.5)


def test_feet_across_and_heights_in_metres(tmp_path):
    wkt = f'COMPD_CS["c",{projected(FOOT)},{vertical(METRE)}]'
    path = wkt_file(tmp_path / "a.las", wkt)
    assert "give unit=0.3048 (--unit, of a render --scene-unit) and scale" in told(path)[0]
    (found,) = told(path, unit=0.3048)
    assert "unit=" not in found
    assert "numpy.diag([1, 3.280839895, 1, 1])" in found
    lines = dict(describe_points(str(path)))
    assert lines["unit"] == "feet, heights in metres, read as m; up z"
    assert "numpy.diag([1, 3.280839895, 1, 1])" in lines["warning"]


def test_a_unit_that_is_given_is_not_told_again(tmp_path):
    path = wkt_file(tmp_path / "a.las", projected(FOOT_US))
    assert told(path, unit=SURVEY_FOOT) == []
    assert "warning" not in dict(describe_points(str(path), unit=SURVEY_FOOT))
    assert load_points(path, unit=SURVEY_FOOT).positions_m == pytest.approx(
        turned(PLACES) * SURVEY_FOOT, abs=3e-5
    )


def test_wkt_behind_the_points_counts_too(tmp_path):
    laspy = pytest.importorskip("laspy")
    las = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    las.x, las.y, las.z = PLACES.T.astype(float)
    wkt = laspy.vlrs.known.WktCoordinateSystemVlr(projected(FOOT))
    las.evlrs = laspy.vlrs.vlrlist.VLRList([wkt])
    las.write(tmp_path / "a.las")
    assert "in feet, of heights it says none" in told(tmp_path / "a.las")[0]
