"""What is in a file of a scene, an eye or responses, in words: what ``omma info`` prints."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Eye, Scene, SplatCloud
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.files import PathLike, metres_per_unit
from omma.base.progress import Progress
from omma.eye.files import eye_file_heads, load_eye
from omma.job.animated import animation_words
from omma.job.capture_info import describe_capture
from omma.job.extents import describe_scene_extent
from omma.job.picture_info import PICTURE_FILES, describe_picture, is_picture_file
from omma.job.places import place_words
from omma.job.points_info import describe_points
from omma.job.results_info import Lines, describe_responses, is_response_file
from omma.job.tables_info import describe_table
from omma.scene.capture_cameras import is_capture
from omma.scene.device_list import devices
from omma.scene.files import SCENE_FILES, read_scene
from omma.scene.gltf_text import begins_as_gltf
from omma.scene.mesh_files import MESH_FILES
from omma.scene.point_files import is_point_file
from omma.scene.splat_files import SPLAT_FILES, refuse_other_splats

# Of eyes; other files are tried as such too, but said to be unknown where they are none.
_EYE_FILES = (".eye", ".csv", ".txt")


def is_scene_file(path: PathLike) -> bool:
    """Whether a file is to be read as a scene: by its ending, else, as glTF, by how it begins."""
    name = Path(os.fsdecode(path))
    if name.suffix.lower() in SCENE_FILES:
        return True
    if name.suffix.lower() == ".eye":
        return False
    return begins_as_gltf(os.fsdecode(path))


def describe_devices() -> Lines:
    """What there is to trace rays with, and the backends that use it."""
    return [
        (
            "graphics card" if "cuda" in device.backends else "processor",
            f"cannot be used: {device.why_not}"
            if device.why_not
            else f"{device.name}: backend {', '.join(device.backends)}",
        )
        for device in devices()
    ]


def describe_file(
    path: PathLike,
    unit: str | float | None = None,
    up: str | None = None,
    progress: Progress | None = None,
    *,
    voxel_m: float | None = None,
) -> Lines:
    """What is in a file of a scene, points, splats, cameras of a capture, an eye, a picture, a
    track, poses, spectra or responses.

    ``unit`` is of lengths in `.eye` files ("mm" where it is None) and in files of scenes ("m"),
    ``up`` what is up in these; ``voxel_m`` is the side of the cells of a grid, by which points of a
    scan are thinned. ``progress`` is told how much of a scene is read.

    Raises:
        omma.Error: the file cannot be read.
    """
    refuse_other_splats(path)
    is_points = is_point_file(os.fsdecode(path))
    if voxel_m is not None and not is_points:
        raise Error(f"voxel_m: expected none, as {os.fsdecode(path)} holds no points of a scan")
    if is_capture(path):
        return describe_capture(path, unit, up)
    if is_response_file(path):
        return describe_responses(path)
    if os.path.isdir(path):
        raise Error(
            f"{os.fsdecode(path)}: is a directory, expected a file, or a folder of responses or a "
            "data set (.zarr) or of a capture (COLMAP's, with cameras and images)"
        )
    if is_picture_file(path):
        return describe_picture(path)
    if is_points:
        name = os.fsdecode(path)
        return describe_points(name, unit, up, progress, voxel_m=voxel_m)
    if Path(os.fsdecode(path)).suffix.lower() in (*MESH_FILES, *SPLAT_FILES):
        return describe_scene(
            read_scene(path, unit=unit, up=up, progress=progress),
            unit_is_told=unit is not None,
            up=up,
        )
    if is_scene_file(path):
        scene = read_scene(path, unit=unit, up=up, progress=progress)
        lines = describe_scene(scene, unit_is_told=unit is not None, up=up)
        # A glTF file may hold a scene, eyes of the Open Compound Eye Standard, or both.
        heads = eye_file_heads(path)
        if len(heads) == 1:
            lines += [("head", heads[0] or "(no name)"), *describe_eye(load_eye(path))[1:]]
        elif heads:
            lines.append(("heads", ", ".join(head or "(no name)" for head in heads)))
        return lines
    if up is not None:
        raise Error(f"up: expected none, as {os.fsdecode(path)} is no file of a scene")
    table = describe_table(path)
    if table is not None:
        if unit is not None:
            raise Error(f"unit: expected none, as {os.fsdecode(path)} says its units")
        return table
    return describe_eye(_eye_by_any_name(path, "mm" if unit is None else unit))


def _eye_by_any_name(path: PathLike, unit: str | float) -> Eye:
    """The eye of a file whose name tells nothing else; what it may be, where it is none."""
    metres_per_unit(unit)
    name = os.fsdecode(path)
    ending = Path(name).suffix.lower()
    try:
        return load_eye(path, unit)
    except Error:
        if ending in _EYE_FILES or not os.path.isfile(name):
            raise
    raise Error(
        f"{name}: expected a scene, points or splats ({', '.join(SCENE_FILES)}), an eye (.eye, "
        f".csv), a picture ({', '.join(PICTURE_FILES)}), responses (.npy, .csv, .parquet, .nc, "
        ".zarr), cameras of photographs (.json or a folder of COLMAP), or a track, poses or "
        f"spectra (.csv), found {'the ending ' + ending if ending else 'no ending'} and no eye in "
        "it"
    )


def describe_scene(scene: Scene, *, unit_is_told: bool = False, up: str | None = None) -> Lines:
    """Counts, size, background, cameras, animations and warnings of a scene."""
    lines = [
        ("scene", scene.path or "in memory"),
        ("nodes", f"{scene.node_count:,}"),
        ("triangles", f"{scene.triangle_count:,}"),
        ("meshes", f"{scene.mesh_count:,} in {scene.instance_count:,} instances"),
        ("materials", f"{scene.material_count:,}"),
        ("textures", f"{scene.texture_count:,} of {scene.image_count:,} images"),
    ]
    for cloud in scene.splats:
        lines.append(("splats", describe_splats(cloud)))
    bounds = scene.bounds
    if bounds is None:
        lines.append(("bounds", "empty: nothing but background"))
    else:
        of = ", of splats their middles" if scene.splat_count else ""
        lines.append(("bounds", f"{place_words(bounds[0])} to {place_words(bounds[1])} m{of}"))
        size_m = bounds[1] - bounds[0]
        lines.append(("extent", describe_scene_extent(scene, size_m, unit_is_told, up) + of))
    background = scene.background
    color = f" {_point(np.array(background.color))}" if background.type == "constant" else ""
    lines.append(("background", background.type.replace("_", " ") + color))
    if scene.lights:
        kinds = Counter(one.type for one in scene.lights)
        lines.append(("lamps", ", ".join(f"{count:,} {kind}" for kind, count in kinds.items())))
    if len(scene.scene_names) > 1:
        lines.append(("scenes", ", ".join(scene.scene_names)))
    for index, camera in enumerate(scene.cameras):
        matrix = camera.world_from_camera
        scale = np.cbrt(abs(np.linalg.det(matrix[:3, :3])))
        text = f"{index} {camera.name}: {camera.type} at {place_words(matrix[:3, 3])} m"
        if abs(scale - 1) > 1e-6:
            text += f", scale {scale:.4g}"
        if camera.compound_structure:
            text += f", eye {camera.compound_structure}"
        if camera.compound_projection:
            text += f" as {camera.compound_projection}"
        lines.append(("camera", text))
    lines += [("animation", words) for words in animation_words(scene)]
    for name in scene.hit_box_names:
        box = scene.hit_box_bounds(name)
        corners = "empty" if box is None else f"{place_words(box[0])} to {place_words(box[1])} m"
        lines.append(("hit box", f"{name}: {corners}"))
    lines += [("warning", warning) for warning in scene.warnings]
    return lines


def describe_splats(cloud: SplatCloud) -> str:
    """How many Gaussian splats there are, how large and how opaque."""
    count, terms = cloud.harmonics.shape[:2]
    if count == 0:
        return f"none in {cloud.name or 'a cloud'}"
    metres = float(np.cbrt(abs(np.linalg.det(cloud.world_from_splats[:3, :3]))))
    sizes = np.percentile(cloud.scales_m.max(axis=1), (10, 50, 90)) * metres
    opaque = np.mean(cloud.opacities > 0.9)
    return (
        f"{count:,} Gaussian splats{f' of {cloud.name}' if cloud.name else ''}, harmonics of "
        f"degree {int(np.sqrt(terms)) - 1}, composited as {cloud.color_space}; largest axes "
        f"{sizes[0]:.2g}, {sizes[1]:.2g}, {sizes[2]:.2g} m (10, 50, 90 % are smaller), "
        f"{opaque:.0%} with opacities above 0.9"
    )


def describe_eye(eye: Eye) -> Lines:
    """What is in an eye file and where it looks. What an eye is like as an eye is measured by
    `measure_eye`, which ``omma eye info`` prints."""
    numbers, counts = np.unique(eye.eye_id, return_counts=True)
    azimuth, elevation = azimuth_elevation_deg_of(eye.axis)
    lines = [("eye", eye.path or "in memory"), ("ommatidia", f"{len(eye):,}")]
    if len(numbers) > 1:
        lines.append(("eyes", ", ".join(f"{c:,}" for c in counts)))
    if len(eye.receptor_type):
        names = [one.name for one in eye.receptor_types]
        lines.append(("receptors", f"{len(eye.receptor_type):,} of {', '.join(names)}"))
    if eye.columns:
        lines.append(("columns", ", ".join(eye.columns)))
    size = np.ptp(eye.position_m.astype(np.float64), axis=0) * 1e3
    return [
        *lines,
        (
            "azimuth",
            f"{_azimuths(azimuth[np.abs(elevation) < 60])} (axes within 60° of the horizon)",
        ),
        ("elevation", f"{elevation.min():.1f}° to {elevation.max():.1f}°"),
        ("size", f"{size[0]:.4g} x {size[1]:.4g} x {size[2]:.4g} mm"),
        ("more", f"omma eye info {eye.path}".rstrip()),
    ]


def azimuth_range_deg(azimuth: NDArray[np.float64]) -> tuple[float, float]:
    """The shortest range of azimuths with all of them in it: from, to, its middle in (-180, 180].

    An eye that sees across straight behind has an end outside (-180, 180].
    """
    if azimuth.size == 0:
        return 0.0, 0.0
    ordered = np.sort(azimuth)
    gaps = np.diff(ordered, append=ordered[0] + 360)
    widest = int(gaps.argmax())
    low = float(ordered[(widest + 1) % len(ordered)])
    high = low + 360 - float(gaps[widest])
    turn = 360.0 if (low + high) / 2 > 180 else 0.0
    return low - turn, high - turn


def _azimuths(azimuth: NDArray[np.float64]) -> str:
    """From where to where axes look, right positive; nothing is said of gaps of a few degrees."""
    low, high = azimuth_range_deg(azimuth)
    if high - low > 350:
        return "all round"
    behind = " through straight behind" if low <= -180 or high > 180 else ""
    low, high = ((end + 180) % 360 - 180 for end in (low, high))
    return f"{low:.1f}° to {high:.1f}°{behind}, right is +"


def _point(values: NDArray[np.float64]) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"
