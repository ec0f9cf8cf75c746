"""Spectra of materials and lamps: the custom property "omma", which Blender's exporter writes to
the extras where Omma reads it (docs/materials.md)."""

import csv
from pathlib import Path

import bpy
from bpy_extras.io_utils import ImportHelper

from . import package
from .package import OmmaError
from .preferences import known, program, tell

PROPERTY = "omma"
_KINDS = [
    ("reflectance", "Reflectance", "Of the diffuse part, 0 to 1, where the base colour is white"),
    ("transmittance", "Transmittance", "Of the diffuse part, 0 to 1, as reflectance"),
    ("emission", "Emission", "W per square metre, steradian and nm, where emission is white"),
    ("spectrum", "Lamp", "W per steradian and nm; of a sun W per square metre and nm"),
]


def read_spectrum(path: Path) -> dict[str, list[float]]:
    """Two columns, wavelength in nm and value, with or without a header.

    Raises:
        OmmaError: no such file, or one that is not that; it names the line.
    """
    wavelengths, values = [], []
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise OmmaError(f"{path}: cannot be read: {error}") from None
    for number, cells in enumerate(csv.reader(lines), 1):
        if not cells or cells[0].startswith("#"):
            continue
        try:
            wavelength, value = (float(cell) for cell in cells)
        except ValueError:
            if not wavelengths and number == 1:
                continue  # the header
            raise OmmaError(
                f"{path}: line {number}: expected a wavelength in nm and a value"
            ) from None
        wavelengths.append(wavelength)
        values.append(value)
    ascending = all(a < b for a, b in zip(wavelengths, wavelengths[1:]))
    if (
        len(wavelengths) < 2
        or not ascending
        or not 100 <= wavelengths[0] <= wavelengths[-1] <= 5000
    ):
        raise OmmaError(
            f"{path}: expected two or more ascending wavelengths from 100 to 5,000 nm, found "
            f"{len(wavelengths)} lines"
        )
    return {"wavelength_nm": wavelengths, "value": values}


def give(owner: bpy.types.ID, **spectra: object) -> None:
    """Adds to what Omma is told of a material or a lamp."""
    said = owner.get(PROPERTY)
    owner[PROPERTY] = {**(said.to_dict() if said is not None else {}), **spectra}


class OMMA_OT_spectrum_from_file(bpy.types.Operator, ImportHelper):
    """Give the active material or lamp a spectrum, of a CSV file of wavelengths (nm) and values"""

    bl_idname = "omma.spectrum_from_file"
    bl_label = "Spectrum from File"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: bpy.props.StringProperty(default="*.csv", options={"HIDDEN"})
    kind: bpy.props.EnumProperty(name="Of", items=_KINDS)

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            owner = _owner(context, is_lamp=self.kind == "spectrum")
            give(owner, **{self.kind: read_spectrum(Path(self.filepath))})
        except OmmaError as error:
            return tell(self, error)
        return {"FINISHED"}


def _materials(self: object, context: bpy.types.Context, text: str) -> list[str]:
    return [name for name in known("materials") if text.lower() in name]


class OMMA_OT_natural_material(bpy.types.Operator):
    """Give the active material the spectra and the colour of a natural one"""

    bl_idname = "omma.natural_material"
    bl_label = "Natural Material"
    bl_options = {"REGISTER", "UNDO"}

    name: bpy.props.StringProperty(name="Material", search=_materials)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            material = _owner(context, is_lamp=False)
            found = package.ask(program(), "material", name=self.name)
        except OmmaError as error:
            return tell(self, error)
        give(material, **found["extras"])
        color = (*found["base_color"][:3], 1)
        material.diffuse_color = color
        for node in material.node_tree.nodes if material.node_tree else ():
            if node.type == "BSDF_PRINCIPLED":
                node.inputs["Base Color"].default_value = color
                node.inputs["Metallic"].default_value = 0
                node.inputs["Roughness"].default_value = found["roughness"]
                node.inputs["IOR"].default_value = found["ior"]
        return {"FINISHED"}


def _owner(context: bpy.types.Context, is_lamp: bool) -> bpy.types.ID:
    one = context.view_layer.objects.active
    if is_lamp:
        if one is None or one.type != "LIGHT":
            raise OmmaError("A lamp's spectrum: make a lamp the active object")
        return one.data
    if one is None or getattr(one, "active_material", None) is None:
        raise OmmaError("A material's spectrum: make an object with a material active")
    return one.active_material


register, unregister = bpy.utils.register_classes_factory(
    (OMMA_OT_spectrum_from_file, OMMA_OT_natural_material)
)
