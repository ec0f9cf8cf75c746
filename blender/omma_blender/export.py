"""A scene as Omma reads it: Blender's own glTF exporter, and what glTF has no place for, added."""

import os
import re
import tempfile
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper

from . import package
from .backdrop import Backdrop, backdrop_of, write_backdrop
from .eye_objects import eye_source
from .gltf_file import GltfFile, default_scene, read_gltf, write_gltf
from .package import OmmaError
from .preferences import program, tell
from .properties import FIELD

# Of Blender's exporter. Lamps: COMPAT makes a lumen of a watt of Blender's, so that lamps, surfaces
# that shine and the world keep the proportions that they have in Blender (docs/blender.md).
_SETTINGS = {
    "use_active_scene": True,
    "use_renderable": True,
    "export_yup": True,
    "export_cameras": True,
    "export_lights": True,
    "export_extras": True,
    "export_import_convert_lighting_mode": "COMPAT",
    "export_rest_position_armature": False,
    "export_animation_mode": "SCENE",
    "export_anim_scene_split_object": False,
    "export_force_sampling": True,
    "export_frame_range": True,
    "export_anim_slide_to_zero": True,
    "export_optimize_animation_size": False,
}
# Properties of ours, which Blender before 5.0 hands out as if users had made them.
_OWN = ("omma_eye", "omma_render")


@dataclass
class Exported:
    """What was written, and what was not."""

    files: list[Path] = field(default_factory=list)  # the scene first
    warnings: list[str] = field(default_factory=list)


def export_scene(
    context: bpy.types.Context,
    path: Path,
    animations: bool = True,
    only: bpy.types.Camera | None = None,
) -> Exported:
    """Writes the context's scene to a .glb or .gltf file, and the eyes of its cameras beside it.

    Where one camera only is meant, the others are written without their eyes. Things are where the
    current frame has them; with animations, time 0 is the first frame of the
    scene's range.

    Raises:
        OmmaError: it cannot be exported or written; nothing is there then.
    """
    if path.suffix.lower() not in (".glb", ".gltf"):
        raise OmmaError(f"{path}: expected a name that ends in .glb or .gltf")
    path = path.absolute()  # omma looks from another folder
    _check_folder(path.parent)
    report = Exported()
    backdrop = _backdrop(context.scene, report)
    _warn_of_objects(context, report)
    with tempfile.TemporaryDirectory(prefix=".omma-", dir=path.parent) as folder:
        made = Path(folder, path.name)
        _run_exporter(context, made, animations, report)
        gltf = read_gltf(made)
        _add_cameras(gltf, made, only, report)
        for element in gltf.document.get("scenes", []):
            for own in _OWN:
                element.get("extras", {}).pop(own, None)
        write_backdrop(gltf, backdrop)
        if not default_scene(gltf).get("nodes"):
            raise OmmaError(
                f"The scene {context.scene.name} has nothing to export: all of it is hidden in "
                "renders"
            )
        write_gltf(made, gltf)
        others = sorted(one for one in Path(folder).iterdir() if one != made)
        for one in [*others, made]:  # the scene last, when all that it names is there
            os.replace(one, path.parent / one.name)
    report.files = [path, *(path.parent / one.name for one in others)]
    return report


def _check_folder(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise OmmaError(f"{folder}: expected a folder, found a file")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OmmaError(f"{folder}: cannot be written to: {error.strerror}") from None


def _backdrop(scene: bpy.types.Scene, report: Exported) -> Backdrop:
    try:
        return backdrop_of(scene.world)
    except OmmaError as error:
        report.warnings.append(f"{error}. The background is black")
        return Backdrop((0, 0, 0))


def _warn_of_objects(context: bpy.types.Context, report: Exported) -> None:
    """What Blender's exporter passes over without a word that anybody sees."""
    shown = [one for one in context.scene.objects if not one.hide_render]
    areas = [one.name for one in shown if one.type == "LIGHT" and one.data.type == "AREA"]
    if areas:
        report.warnings.append(
            f"Area lamps are not exported, as glTF has none: {', '.join(areas)}. A plane with an "
            "emitting material is"
        )
    others = [one.name for one in shown if one.type in ("VOLUME", "POINTCLOUD", "CURVES")]
    if others:
        report.warnings.append(f"Not exported, as it is no surface: {', '.join(others)}")
    if context.scene.unit_settings.scale_length != 1:
        report.warnings.append(
            "The scene's unit scale is not heeded: a unit of Blender's is exported as a metre"
        )


def _run_exporter(
    context: bpy.types.Context, path: Path, animations: bool, report: Exported
) -> None:
    operator = bpy.ops.export_scene.gltf
    try:
        there = operator.get_rna_type().properties.keys()
    except KeyError:
        raise OmmaError(
            'Blender\'s exporter of glTF is not switched on (Preferences > Add-ons > "glTF 2.0")'
        ) from None
    settings = {
        **_SETTINGS,
        "export_format": "GLB" if path.suffix.lower() == ".glb" else "GLTF_SEPARATE",
        "export_animations": animations,
        "export_apply": not _has_shaped_modified(context, report),
    }
    frame = context.scene.frame_current, context.scene.frame_subframe
    with _as_exporter_needs(context.scene):
        try:
            done = operator(
                filepath=str(path), **{key: settings[key] for key in settings if key in there}
            )
        except RuntimeError as error:
            raise OmmaError(f"Blender's exporter of glTF: {_last_line(error)}") from None
        finally:
            # Only where it went elsewhere: what was moved and not yet keyed would jump back.
            if (context.scene.frame_current, context.scene.frame_subframe) != frame:
                context.scene.frame_set(frame[0], subframe=frame[1])
    if "FINISHED" not in done or not path.is_file():
        raise OmmaError("Blender's exporter of glTF wrote nothing; its console says why")


def _last_line(error: Exception) -> str:
    lines = [line for line in str(error).splitlines() if line.strip()]
    return lines[-1].strip() if lines else type(error).__name__


def _has_shaped_modified(context: bpy.types.Context, report: Exported) -> bool:
    """Whether modifiers must stay unapplied, or a mesh would lose its shape keys."""
    both = [
        one.name
        for one in context.scene.objects
        if one.type == "MESH" and one.modifiers and one.data.shape_keys and not one.hide_render
    ]
    plain = [
        one.name
        for one in context.scene.objects
        if one.type == "MESH"
        and not one.hide_render
        and any(modifier.type != "ARMATURE" for modifier in one.modifiers)
    ]
    if both and plain:
        report.warnings.append(
            f"Modifiers are not applied (to {', '.join(plain)}), as shape keys would be lost "
            f"(of {', '.join(both)})"
        )
    return bool(both)


@contextmanager
def _as_exporter_needs(scene: bpy.types.Scene):
    """Makes perspective cameras of panoramic and compound ones, which the exporter passes over, and
    keeps the colours of lamps, which it may multiply in place; all is put back."""
    cameras = {
        one.data: one.data.type
        for one in scene.objects
        if one.type == "CAMERA" and (one.data.type == "PANO" or one.data.omma_eye.is_compound)
    }
    lamps = {one.data: tuple(one.data.color) for one in scene.objects if one.type == "LIGHT"}
    active = bpy.context.active_object
    mode = active.mode if active else "OBJECT"
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")  # what is being edited is not yet in the mesh
    try:
        for data in cameras:
            data.type = "PERSP"
        yield
    finally:
        for data, kind in cameras.items():
            data.type = kind
        for data, color in lamps.items():
            data.color = color
        if mode != "OBJECT":
            with suppress(RuntimeError):
                bpy.ops.object.mode_set(mode=mode)


def _add_cameras(
    gltf: GltfFile, path: Path, only: bpy.types.Camera | None, report: Exported
) -> None:
    """Says of cameras what CompoundRay's scenes say: in their extras, of compound and panoramic
    ones. Copies the eyes."""
    for camera in gltf.document.get("cameras", []):
        data = bpy.data.cameras.get(camera.get("name", ""))
        extras = camera.setdefault("extras", {})
        for own in _OWN:
            extras.pop(own, None)
        if data is not None and data.omma_eye.is_compound and only in (None, data):
            eye = data.omma_eye
            copy = path.parent / f"{path.stem}-{_file_name(data.name)}"
            written = package.ask(program(), "eye", copy=str(copy), **eye_source(eye))
            extras["compound-eye"] = "true"
            extras["compound-structure"] = Path(written["copy"]).name
            if eye.projection != FIELD:
                extras["compound-projection"] = eye.projection
        elif data is not None and data.type == "PANO":
            extras["panoramic"] = "true"
            if _panorama_type(data) != "EQUIRECTANGULAR":
                report.warnings.append(
                    f"The panoramic camera {data.name} is exported as an equirectangular one"
                )
        if not extras:
            del camera["extras"]


def _panorama_type(data: bpy.types.Camera) -> str:
    return getattr(data, "panorama_type", "") or getattr(data.cycles, "panorama_type", "")


def _file_name(name: str) -> str:
    return re.sub(r"[^\w.-]+", "_", name)


class OMMA_OT_export_scene(bpy.types.Operator, ExportHelper):
    """Write the scene as Omma reads it, with the eyes of its compound cameras beside it"""

    bl_idname = "omma.export_scene"
    bl_label = "Scene for Omma (.glb, .gltf)"

    filename_ext = ".glb"
    filter_glob: bpy.props.StringProperty(default="*.glb;*.gltf", options={"HIDDEN"})
    animations: bpy.props.BoolProperty(
        name="Animations", description="All that moves in the scene's range of frames", default=True
    )

    def check(self, context: bpy.types.Context) -> bool:
        return False  # it would make .glb of .gltf

    def execute(self, context: bpy.types.Context) -> set[str]:
        path = Path(self.filepath)
        try:
            report = export_scene(
                context, path if path.suffix else path.with_suffix(".glb"), self.animations
            )
        except OmmaError as error:
            return tell(self, error)
        for warning in report.warnings:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, f"Written: {', '.join(one.name for one in report.files)}")
        return {"FINISHED"}


_register, _unregister = bpy.utils.register_classes_factory((OMMA_OT_export_scene,))


def _draw_export(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.operator(OMMA_OT_export_scene.bl_idname)


def register() -> None:
    _register()
    bpy.types.TOPBAR_MT_file_export.append(_draw_export)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_export.remove(_draw_export)
    _unregister()
