"""Where people find all that: panels of cameras, scenes' renders, materials and lamps."""

import bpy

from .spectra import PROPERTY


class OMMA_PT_camera(bpy.types.Panel):
    bl_label = "Omma"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.camera is not None

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.camera.omma_eye, "is_compound", text="")

    def draw(self, context: bpy.types.Context) -> None:
        eye = context.camera.omma_eye
        layout = self.layout
        layout.use_property_split = True
        column = layout.column()
        column.active = eye.is_compound
        column.prop(eye, "eye_file")
        if not eye.eye_file:
            column.prop(eye, "species")
        elif eye.eye_file.lower().endswith(".eye"):
            column.prop(eye, "unit")
        for name in ("kernel", "samples", "projection"):
            column.prop(eye, name)
        row = layout.row()
        row.operator("omma.show_eye")
        if eye.ommatidia:
            row.label(text=f"{eye.ommatidia:,} ommatidia")
        layout.operator("omma.render", icon="RENDER_STILL")


class OMMA_PT_render(bpy.types.Panel):
    bl_label = "Omma"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "output"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.omma_render
        layout = self.layout
        layout.use_property_split = True
        layout.prop(settings, "light")
        if settings.light == "sky":
            layout.prop(settings, "sun_elevation_deg")
            layout.prop(settings, "sun_azimuth_deg")
        for name in ("width", "camera_samples", "seed", "standard_error", "numbers"):
            layout.prop(settings, name)
        layout.operator("omma.render", icon="RENDER_STILL")
        layout.operator("omma.export_scene", icon="EXPORT")


def _draw_spectra(layout: bpy.types.UILayout, owner: bpy.types.ID) -> None:
    said = owner.get(PROPERTY)
    layout.label(text=f"Given: {', '.join(sorted(said.keys()))}" if said else "No spectrum")
    layout.operator("omma.spectrum_from_file")


class OMMA_PT_material(bpy.types.Panel):
    bl_label = "Omma"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "material"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None

    def draw(self, context: bpy.types.Context) -> None:
        _draw_spectra(self.layout, context.material)
        self.layout.operator("omma.natural_material")


class OMMA_PT_light(bpy.types.Panel):
    bl_label = "Omma"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "data"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.light is not None

    def draw(self, context: bpy.types.Context) -> None:
        _draw_spectra(self.layout, context.light)


CLASSES = (OMMA_PT_camera, OMMA_PT_render, OMMA_PT_material, OMMA_PT_light)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
