"""Eyes as objects: points and axes of ommatidia, and cameras that carry them.

The frame of an eye, x right, y up, looking along -z, is that of Blender's cameras. So the points
of an eye stand in its camera's own frame, in metres, as Omma reads them.
"""

import math
import tempfile
from pathlib import Path

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper

from . import package
from .package import OmmaError
from .preferences import program, tell
from .properties import OmmaEye

# An eye whose camera stands unturned looks down: as all cameras. This turns it to +y, level.
LEVEL = (math.pi / 2, 0, 0)
SHOWN_OF = "omma_eye_of"  # on the object that shows an eye: the name of its camera
ENDINGS = "*.eye;*.csv;*.gltf;*.glb"
_UNITS_OF_AXES = 0.25  # how long axes are drawn, of the eye's greatest extent


def eye_source(eye: OmmaEye) -> dict[str, str]:
    """The file or species that an eye's properties name, as `eye` in worker.py takes it.

    Raises:
        OmmaError: neither is named, or there is no such file.
    """
    if eye.eye_file:
        path = bpy.path.abspath(eye.eye_file)
        if not Path(path).is_file():
            raise OmmaError(f"{path}: there is no such eye file")
        return {"file": path, "unit": eye.unit}
    if not eye.species:
        camera = eye.id_data.name
        raise OmmaError(
            f"The camera {camera} names no eye: choose an eye file or a species "
            "(Properties > Camera > Omma)"
        )
    return {"species": eye.species}


def read_eye(**source: str) -> dict[str, np.ndarray]:
    """What omma reads there, by name: see `eye` in worker.py.

    Raises:
        OmmaError: there is no omma, or it does not read that.
    """
    with tempfile.TemporaryDirectory(prefix="omma-eye-") as folder:
        arrays = Path(folder, "eye.npz")
        package.ask(program(), "eye", arrays=str(arrays), **source)
        with np.load(arrays) as read:
            return dict(read)


def eye_mesh(name: str, eye: dict[str, np.ndarray]) -> bpy.types.Mesh:
    """Points of N ommatidia, vertices 0 to N - 1, and the tips of their axes, N to 2 N - 1.

    Attributes of both: acceptance_angle_rad, facet_diameter_m, eye_id, axis.
    """
    position, axis = eye["position_m"], eye["axis"]
    count = len(position)
    extent = float(np.ptp(position, axis=0).max()) or 0.001
    tips = position + axis * (_UNITS_OF_AXES * extent)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(2 * count)
    mesh.vertices.foreach_set("co", np.concatenate([position, tips]).astype(np.float32).ravel())
    mesh.edges.add(count)
    ends = np.stack([np.arange(count), np.arange(count) + count], axis=1)
    mesh.edges.foreach_set("vertices", ends.astype(np.int32).ravel())
    for key, type_, member in (
        ("acceptance_angle_rad", "FLOAT", "value"),
        ("facet_diameter_m", "FLOAT", "value"),
        ("eye_id", "INT", "value"),
        ("axis", "FLOAT_VECTOR", "vector"),
    ):
        attribute = mesh.attributes.new(key, type_, "POINT")
        attribute.data.foreach_set(member, np.concatenate([eye[key], eye[key]]).ravel())
    mesh.update()
    return mesh


def show_eye(camera: bpy.types.Object) -> bpy.types.Object:
    """Gives a camera the points and axes of its eye, in place of those that it had.

    Raises:
        OmmaError: what `eye_source` and `read_eye` raise.
    """
    eye = camera.data.omma_eye
    read = read_eye(**eye_source(eye))
    mesh = eye_mesh(f"{camera.name} eye", read)
    shown = next((one for one in camera.children if SHOWN_OF in one), None)
    if shown is None:
        shown = bpy.data.objects.new(mesh.name, mesh)
        shown.parent = camera
        shown[SHOWN_OF] = camera.name
        shown.hide_render = True  # it is no thing of the world: neither seen nor exported
        shown.hide_select = True
        for collection in camera.users_collection:
            collection.objects.link(shown)
    else:
        old, shown.data = shown.data, mesh
        bpy.data.meshes.remove(old)
    eye.is_compound = True
    eye.ommatidia = len(read["axis"])
    return shown


class OMMA_OT_add_compound_camera(bpy.types.Operator):
    """Add a camera with a compound eye, which looks ahead along +y"""

    bl_idname = "omma.add_compound_camera"
    bl_label = "Compound Eye"
    bl_options = {"REGISTER", "UNDO"}

    species: bpy.props.StringProperty(name="Species", default="honeybee_worker")
    eye_file: bpy.props.StringProperty(
        name="Eye file", description="In place of a species", subtype="FILE_PATH"
    )
    unit: bpy.props.StringProperty(name="Unit", default="mm", options={"HIDDEN"})
    magnify: bpy.props.FloatProperty(
        name="Show larger",
        description="How much larger the points and axes are drawn than the eye is",
        default=100,
        min=1,
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        data = bpy.data.cameras.new("Compound eye")
        camera = bpy.data.objects.new("Compound eye", data)
        camera.location = context.scene.cursor.location
        camera.rotation_euler = LEVEL
        data.display_size = 0.1
        data.omma_eye.eye_file = self.eye_file
        data.omma_eye.species = "" if self.eye_file else self.species
        data.omma_eye.unit = self.unit
        context.collection.objects.link(camera)
        try:
            shown = show_eye(camera)
        except OmmaError as error:
            bpy.data.cameras.remove(data)
            return tell(self, error)
        shown.scale = [self.magnify] * 3
        _select(context, camera)
        self.report({"INFO"}, f"{data.omma_eye.ommatidia:,} ommatidia")
        return {"FINISHED"}


class OMMA_OT_show_eye(bpy.types.Operator):
    """Show the points and axes of this camera's eye"""

    bl_idname = "omma.show_eye"
    bl_label = "Show Eye"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and context.object.type == "CAMERA"

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            show_eye(context.object)
        except OmmaError as error:
            return tell(self, error)
        self.report({"INFO"}, f"{context.object.data.omma_eye.ommatidia:,} ommatidia")
        return {"FINISHED"}


class OMMA_OT_import_eye(bpy.types.Operator, ImportHelper):
    """Import an eye as a cloud of points with axes"""

    bl_idname = "omma.import_eye"
    bl_label = "Compound Eye (.eye, .csv, .gltf, .glb)"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: bpy.props.StringProperty(default=ENDINGS, options={"HIDDEN"})
    unit: bpy.props.EnumProperty(
        name="Unit",
        description="Of lengths in an .eye file; other files say theirs themselves",
        items=[("mm", "Millimetres", ""), ("um", "Micrometres", ""), ("m", "Metres", "")],
    )
    magnify: bpy.props.FloatProperty(
        name="Show larger", description="The scale of the object", default=1, min=1e-6
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        path = Path(self.filepath)
        try:
            if not path.is_file():
                raise OmmaError(f"{path}: there is no such eye file")
            read = read_eye(file=str(path), unit=self.unit)
        except OmmaError as error:
            return tell(self, error)
        cloud = bpy.data.objects.new(path.stem, eye_mesh(path.stem, read))
        cloud.location = context.scene.cursor.location
        cloud.rotation_euler = LEVEL
        cloud.scale = [self.magnify] * 3
        cloud.hide_render = True
        context.collection.objects.link(cloud)
        _select(context, cloud)
        self.report({"INFO"}, f"{len(read['axis']):,} ommatidia")
        return {"FINISHED"}


def _select(context: bpy.types.Context, one: bpy.types.Object) -> None:
    for other in context.selected_objects:
        other.select_set(False)
    one.select_set(True)
    context.view_layer.objects.active = one


_register, _unregister = bpy.utils.register_classes_factory(
    (OMMA_OT_add_compound_camera, OMMA_OT_show_eye, OMMA_OT_import_eye)
)


def _draw_add(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.operator(OMMA_OT_add_compound_camera.bl_idname, icon="OUTLINER_OB_CAMERA")


def _draw_import(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.operator(OMMA_OT_import_eye.bl_idname)


def register() -> None:
    _register()
    bpy.types.VIEW3D_MT_camera_add.append(_draw_add)
    bpy.types.TOPBAR_MT_file_import.append(_draw_import)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_import.remove(_draw_import)
    bpy.types.VIEW3D_MT_camera_add.remove(_draw_add)
    _unregister()
