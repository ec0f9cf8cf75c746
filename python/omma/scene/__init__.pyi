from .files import Camera, load_scene, save_scene
from .joining import merge_scenes, place_scene
from .materials import (
    MaterialFact,
    NaturalMaterial,
    natural_material,
    natural_materials,
)
from .parts import HitBox, Image, Instance, Material, Mesh, Texture, TextureUse
from .solids import box, cylinder, disc, plane, sphere
from .trimesh_scenes import from_trimesh
from .walls import corridor, drum
from .world import WorldInstance

__all__ = [
    "Camera",
    "HitBox",
    "Image",
    "Instance",
    "Material",
    "MaterialFact",
    "Mesh",
    "NaturalMaterial",
    "Texture",
    "TextureUse",
    "WorldInstance",
    "box",
    "corridor",
    "cylinder",
    "disc",
    "drum",
    "from_trimesh",
    "load_scene",
    "merge_scenes",
    "natural_material",
    "natural_materials",
    "place_scene",
    "plane",
    "save_scene",
    "sphere",
]
