"""Files as others have published them: their headers and structures, word for word, around numbers
of our own. Where each is from stands beside it."""

import base64
import json

import numpy as np
import pytest

import omma


def cap(count=400):
    """Points (N, 3) on a sphere of 300 and directions out of it."""
    height = 1 - 0.8 * (np.arange(count) + 0.5) / count
    turn, radius = np.pi * (3 - np.sqrt(5)) * np.arange(count), np.sqrt(1 - height**2)
    out = np.stack([radius * np.cos(turn), radius * np.sin(turn), -height], axis=1)
    return 300 * out, out


# jpcurrea/ODA, tests/d_mauritiana_ct_stack: ommatidial_data.csv, "ommatidial_data (1).csv" and
# old_data/ommatidial_data.csv. Each begins with a row of noise, label 0.
ODA_OLD = (
    "label,x,y,z,theta,phi,radius,size,lens_area,anatomical_axis,approx_axis,skewness,"
    "spherical_IOA,neighbors"
)
ODA_NEWER = ODA_OLD + ",cross_section_area,cross_section_height"
ODA_NEWEST = ODA_NEWER + ",lens_diameter,lens_diameter_adj,x_,y_,z_,dx_,dy_,dz_,dx,dy,dz"


@pytest.mark.parametrize("header", [ODA_OLD, ODA_NEWER, ODA_NEWEST])
def test_oda(tmp_path, header):
    points, out = cap()
    names = header.split(",")
    area = 2.0 * np.sqrt(3) * 5**2  # of facets 10 across: of the circle as large, a little more
    lines = [header]
    noise = {name: "" for name in names} | {
        **{"label": "0", "x": "250.1", "y": "15.5", "z": "1.5", "neighbors": "[]"},
        **{"anatomical_axis": '"[nan, nan, nan]"', "approx_axis": '"[-0.4, -0.01, -0.03]"'},
    }
    lines.append(",".join(noise[name] for name in names))
    for i, (point, axis) in enumerate(zip(points, out), start=1):
        text = '"' + str([float(-v) for v in axis]) + '"'
        row = {name: "1.5" for name in names} | dict(zip("xyz", map(str, point)))
        row |= {"label": str(i), "anatomical_axis": text, "approx_axis": text}
        row |= {"neighbors": "[ 6  2 17 11  5 25]", "lens_area": str(area), "lens_diameter": "10"}
        lines.append(",".join(row[name] for name in names))
    (tmp_path / "ommatidial_data.csv").write_text("\n".join(lines) + "\n")
    found = omma.eye.scans.import_oda(tmp_path / "ommatidial_data.csv")
    assert len(found.eye) == len(points)
    assert found.eye.axis == pytest.approx(out, abs=1e-6)
    assert found.eye.position_m == pytest.approx(points * 1e-6, rel=1e-6, abs=1e-12)
    diameter = 10 if "lens_diameter" in names else 2 * np.sqrt(area / np.pi)
    assert found.eye.facet_diameter_m == pytest.approx(diameter * 1e-6)


def test_the_forerunner_of_oda(tmp_path):
    """jpcurrea/compound_eye_tools, compound_eye_tools/__init__.py: pandas writes a number ahead of
    each row, arrays over several lines in quotes, and axes that may point out of the eye."""
    points, out = cap()
    header = (
        ",x_center,y_center,z_center,theta_center,phi_center,r_center,children_pts,"
        "children_polar,n,lens_area,anatomical_axis,approx_axis,skewness"
    )
    lines = [header]
    for i, (point, axis) in enumerate(zip(points, out)):
        inward, outward = ('"' + str([float(s * v) for v in axis]) + '"' for s in (-1, 1))
        place = ",".join(map(str, point))
        children = '"[[ 1.  2.  3.]\n [ 4.  5.  6.]]"'
        lines.append(f"{i},{place},1,2,3,{children},{children},2,78.5,{outward},{inward},3.5")
    (tmp_path / "cone_cluster_data.csv").write_text("\n".join(lines) + "\n")
    found = omma.eye.scans.import_oda(tmp_path / "cone_cluster_data.csv")
    assert found.eye.axis == pytest.approx(out, abs=1e-6)
    assert found.eye.facet_diameter_m == pytest.approx(2e-6 * np.sqrt(78.5 / np.pi))
    assert found.eye.columns["children_pts"][0] == "[[ 1.  2.  3.]\n [ 4.  5.  6.]]"
    assert any(note.startswith("Turned round: 400") for note in found.notes)


def test_oces(tmp_path):
    """BrainBeatsBrawn/antpov, data/eyes/velox-head.gltf: one eye of an ant and its mirror image. A
    head with a mesh and a scale, focal offsets as single numbers, a plane by its name, "$comment"s,
    no dataStride, accessors of which some have no bounds."""
    points, out = cap(915)
    parts = [points / 300, out, np.full(915, -0.04), np.full(915, 0.02)]
    data = [part.astype("<f4").tobytes() for part in parts]
    start = np.cumsum([0, *map(len, data)])
    views = [
        {"$comment": "of each facet", "buffer": 0, "byteLength": len(d), "byteOffset": int(s)}
        for d, s in zip(data, start)
    ]
    accessors = [
        {"$comment": "of each facet", "bufferView": i, "componentType": 5126, "count": 915}
        | {"type": "VEC3" if i < 2 else "SCALAR"}
        for i in range(4)
    ]
    accessors[0] |= {"min": [-1.0, -1.0, -1.0], "max": [1.0, 1.0, 1.0]}
    uri = "data:application/octet-stream;base64," + base64.b64encode(b"".join(data)).decode()
    document = {
        "asset": {"generator": "Khronos glTF Blender I/O v4.2.70", "version": "2.0"},
        "scene": 0,
        "scenes": [{"name": "Scene", "nodes": [0]}],
        "nodes": [
            {
                "mesh": 0,
                "name": "head",
                "children": [1],
                "extensions": {"OCES_eyes": {"head": True}},
                "scale": [0.000001, 0.000001, 0.000001],
            },
            {
                "name": "right-eye",
                "extensions": {"OCES_eyes": {"eye": 0, "mirrorPlanes": [0]}},
            },
        ],
        "meshes": [
            {"name": "head-mask-mesh", "primitives": [{"attributes": {"POSITION": 0}}]},
        ],
        "extensionsUsed": ["OCES_eyes"],
        "extensions": {
            "OCES_eyes": {
                "generator": {"program": "manual", "version": "0.0.0"},
                "creationDatetime": "2026-05-13 19:56:00.0",
                "version": "0.0.0",
                "mirrorPlanes": [{"normal": "FRONTAL"}],
                "eyes": [
                    {
                        "name": "velox-eye",
                        "type": "POINT_OMMATIDIAL",
                        "ommatidialProperties": {
                            **{"POSITION": 0, "ORIENTATION": 1, "FOCAL_OFFSET": 2, "DIAMETER": 3}
                        },
                    }
                ],
                "ommatidialProperties": [{"type": "ACCESSOR", "value": i} for i in range(4)],
            }
        },
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": int(start[-1]), "uri": uri}],
    }
    (tmp_path / "velox-head.gltf").write_text(json.dumps(document, indent="\t"))
    eye = omma.load_eye(tmp_path / "velox-head.gltf")
    assert (eye.eye_id == np.repeat([0, 1], 915)).all()
    # The head looks along +z there, along -z here; the second eye is the mirror image in x.
    assert eye.axis[:915] == pytest.approx(out * [-1, 1, -1], abs=1e-6)
    assert eye.axis[915:] == pytest.approx(out * [1, 1, -1], abs=1e-6)
    assert eye.acceptance_angle_rad == pytest.approx(2 * np.arctan(0.02 / 2 / 0.04))


def test_eye_with_long_numbers(tmp_path):
    """Numbers of 8 columns as Python writes them (KrishKanwar/CompoundRayTest,
    CylinderEyeTests/cylinderical_eye_data.eye) and axes that are not of length 1
    (optseb/compound-ray, data/eyes/cyl.eye)."""
    (tmp_path / "cyl.eye").write_text(
        "0.0 -100.0 0.001 0.0 0 1.0 0.17453292519943295 0.0\n"
        "1.2246467991473531e-19 -100.0 -0.001 1.2246467991473532e-16 0 -1.0 0.1745329 0.0\n"
        "-1.74846e-08 0 -0.2 -8.74228e-08 -0.742014 -1 0.0314159 0.298336\n"
    )
    eye = omma.load_eye(tmp_path / "cyl.eye")
    assert eye.axis == pytest.approx(
        np.array([[0, 0, -1], [0, 0, 1], np.array([0, -0.742014, 1]) / np.hypot(1, 0.742014)]),
        abs=1e-6,
    )
