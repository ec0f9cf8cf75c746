"""What Omma knows of cameras and scenes in Blender, as properties that are saved with the file."""

import bpy

from .preferences import known

# The same names as omma.picture.PROJECTIONS, held to it by a test.
PROJECTIONS = (
    *("single_dimension", "single_dimension_fast", "spherical_orientationwise"),
    *("spherical_positionwise", "spherical_split_orientationwise", "cylindrical"),
    *("mollweide", "lambert", "hemisphere", "facets"),
)
FIELD = "field"
# That a path may begin with "//", beside the .blend file, has to be said since 5.0.
_PATH = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (5, 0) else set()


def _words(name: str) -> str:
    return name.replace("_", " ").capitalize()


def _species(self: object, context: bpy.types.Context, text: str) -> list[str]:
    return [name for name in known("species") if text.lower() in name]


def _eye_changed(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    self.ommatidia = 0


class OmmaEye(bpy.types.PropertyGroup):
    """Of a camera: the compound eye that looks from there."""

    is_compound: bpy.props.BoolProperty(
        name="Compound eye",
        description="Omma sees from this camera through an eye",
    )
    eye_file: bpy.props.StringProperty(
        name="Eye file",
        description=".eye, .csv, or .gltf and .glb of the Open Compound Eye Standard",
        subtype="FILE_PATH",
        options=_PATH,
        update=_eye_changed,
    )
    species: bpy.props.StringProperty(
        name="Species",
        description="Where no file is named: an animal whose eyes Omma knows",
        search=_species,
        update=_eye_changed,
    )
    unit: bpy.props.EnumProperty(
        name="Unit",
        description="Unit of lengths in an .eye file; other files say theirs themselves",
        items=[
            ("mm", "Millimetres", ""),
            ("um", "Micrometres", ""),
            ("m", "Metres", "Also of eyes of CompoundRay's, which are in the scene's unit"),
        ],
        default="mm",
        update=_eye_changed,
    )
    kernel: bpy.props.EnumProperty(
        name="Acceptance",
        description="The angular sensitivity of the ommatidia",
        items=[
            ("own", "Own", "As the eye says"),
            ("gaussian", "Gaussian", "Of the acceptance angle, per unit solid angle"),
            ("pillbox", "Pillbox", "1 within half the acceptance angle"),
            ("compoundray", "CompoundRay's", "To compare with work done with it"),
        ],
        default="own",
    )
    samples: bpy.props.IntProperty(
        name="Rays", description="Rays of each ommatidium", default=64, min=1, max=1 << 20
    )
    projection: bpy.props.EnumProperty(
        name="Projection",
        description="How the eye is shown in a picture",
        items=[
            (FIELD, "Field of view", "Azimuth and elevation, empty where no ommatidium looks"),
            *((name, _words(name), "") for name in PROJECTIONS),
        ],
        default=FIELD,
    )
    ommatidia: bpy.props.IntProperty(
        name="Ommatidia", description="How many there are in the eye that is shown"
    )


class OmmaRender(bpy.types.PropertyGroup):
    """Of a scene: how it is rendered, and where numbers go."""

    width: bpy.props.IntProperty(
        name="Width", description="Of the picture, in pixels", default=1024, min=1, max=16384
    )
    camera_samples: bpy.props.IntProperty(
        name="Rays a pixel",
        description="Of cameras without an eye",
        default=16,
        min=1,
        max=1 << 20,
    )
    seed: bpy.props.IntProperty(
        name="Seed", description="The same seed gives the same bits", default=0, min=0
    )
    standard_error: bpy.props.BoolProperty(
        name="Standard errors", description="Write them beside the numbers, for 8 times the rays"
    )
    light: bpy.props.EnumProperty(
        name="Light",
        description="What lights the scene",
        items=[
            ("none", "None", "Colours and what shines as they are, as `omma render` does"),
            ("world", "Lamps and world", "Blender's; from 400 to 700 nm"),
            ("sky", "Clear sky and lamps", "Sun and sky from 300 to 700 nm, as outdoors"),
        ],
        default="none",
    )
    sun_elevation_deg: bpy.props.FloatProperty(
        name="Sun's elevation", description="Degrees", default=40, min=-8, max=90
    )
    sun_azimuth_deg: bpy.props.FloatProperty(
        name="Sun's azimuth", description="Degrees, from +y (0) to +x (90)", default=135
    )
    numbers: bpy.props.StringProperty(
        name="Numbers",
        description="Folder to keep the responses, the scene and the eye in. Empty: they go when "
        "the picture is there",
        subtype="DIR_PATH",
        options=_PATH,
    )


_register, _unregister = bpy.utils.register_classes_factory((OmmaEye, OmmaRender))


def register() -> None:
    _register()
    bpy.types.Camera.omma_eye = bpy.props.PointerProperty(type=OmmaEye)
    bpy.types.Scene.omma_render = bpy.props.PointerProperty(type=OmmaRender)


def unregister() -> None:
    del bpy.types.Scene.omma_render
    del bpy.types.Camera.omma_eye
    _unregister()
