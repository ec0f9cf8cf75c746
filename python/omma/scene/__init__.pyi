from .baking import Bake, BakedInfo
from .capture_cameras import CaptureCameras, load_capture_cameras
from .device_list import Device, devices
from .files import Camera, load_scene, save_scene
from .joining import merge_scenes, place_scene
from .layers import LayerStack, refractive_index
from .parts import (
    Animation,
    BoundaryTable,
    ExtraReflectance,
    HitBox,
    Image,
    Instance,
    Material,
    Mesh,
    PunctualLight,
    Rig,
    SplatCloud,
    Texture,
    TextureUse,
)
from .materials import (
    MaterialFact,
    NaturalMaterial,
    natural_material,
    natural_materials,
)
from .reflectances import with_reflectance
from .points import PointCloud, load_points
from .splat_culling import cull_splats
from .splat_files import load_splats, save_splats
from .splat_light import calibrate
from .solids import box, cylinder, disc, plane, sphere
from .surfel_scenes import surfels
from .trimesh_scenes import from_trimesh
from .walls import corridor, drum
from .water_surfaces import water, water_volume, wave_roughness
from .world import WorldInstance

__all__ = [
    "Animation",
    "Bake",
    "BakedInfo",
    "BoundaryTable",
    "Camera",
    "CaptureCameras",
    "Device",
    "ExtraReflectance",
    "HitBox",
    "Image",
    "Instance",
    "LayerStack",
    "Material",
    "MaterialFact",
    "Mesh",
    "PointCloud",
    "PunctualLight",
    "NaturalMaterial",
    "Rig",
    "SplatCloud",
    "Texture",
    "TextureUse",
    "WorldInstance",
    "box",
    "calibrate",
    "corridor",
    "cull_splats",
    "cylinder",
    "devices",
    "disc",
    "drum",
    "from_trimesh",
    "load_capture_cameras",
    "load_points",
    "load_scene",
    "load_splats",
    "merge_scenes",
    "natural_material",
    "natural_materials",
    "place_scene",
    "plane",
    "refractive_index",
    "save_scene",
    "save_splats",
    "sphere",
    "surfels",
    "water",
    "water_volume",
    "wave_roughness",
    "with_reflectance",
]
