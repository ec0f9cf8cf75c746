"""What an animal with compound eyes sees.

    import omma

    scene = omma.load_scene("meadow.glb")
    eye = omma.load_eye("honeybee.eye", unit="mm")
    renderer = omma.Renderer(scene, eye, samples=16)
    responses = renderer.render(omma.look_at((0, 1, 0), (0, 1, -5)))  # float32 (1, N, 3), linear
    omma.save_png("view.png", omma.equirectangular(eye, responses[0]))

The response of ommatidium i in band b is the radiance around it, weighted by its angular
sensitivity: an evenly lit surround of radiance 1 gives exactly 1. Linear, never clipped. Poses are
``world_from_head``: the head looks along its -Z, +X is its right, +Y up; lengths are metres, angles
radians, where a name does not say otherwise.

Besides: `render_camera` and `project` make pictures, `generate_eye` and `draw_eye` eyes and their
drawings, `minimum_samples` says how many rays a scene needs, `compoundray_library` is for the
scripts of CompoundRay.
"""

import inspect

from omma import species
from omma._core import (
    Acceptance,
    Background,
    Camera,
    Error,
    Eye,
    ReceptorType,
    Scene,
    WorldInstance,
    __version__,
    encode_ids,
    look_at,
    merge_eyes,
    paint,
    save_png,
)
from omma.acceptance_files import load_acceptance
from omma.all_cameras import AllCamerasReport, CameraReport, render_all_cameras
from omma.arguments import checked
from omma.cameras import camera_eye, display, render_camera
from omma.compat import compoundray_library
from omma.confidence import confidence_interval
from omma.eye_angles import acute_angle, angle_table, load_angle_table, outline, window
from omma.eye_design import AcuteZone, acute_zones, generate_eye
from omma.eye_drawing import draw_eye
from omma.eye_facets import acceptance_from_facets, facet_diameters_m, set_facets
from omma.eye_import import ImportedEye, LensConeEye, import_lens_cone, import_oda
from omma.eye_lattice import (
    Lattice,
    LatticeCheck,
    azimuth_elevation_deg_of,
    check_lattice,
    direction,
    lay_directions,
)
from omma.eye_maps import plot_eye_maps
from omma.eye_measures import EyeMeasures, measure_eye
from omma.eye_plots import plot_acceptance
from omma.eye_poster import plot_poster, plot_species
from omma.eye_properties import PROPERTIES as EYE_PROPERTIES
from omma.eye_report import eye_summary, eye_table, save_eye_table
from omma.eye_surface import (
    eye_on_surface,
    lay_on_surface,
    skew_rad,
    squeeze_for_skew,
    squeezed,
)
from omma.eye_tools import (
    ConvertedEye,
    convert_eye,
    join_eyes,
    mirror_eye,
    pair_of_eyes,
    place_on_head,
    rescale_eye,
    set_acceptance,
    split_eye,
)
from omma.files import (
    eye_file_heads,
    eye_file_losses,
    load_eye,
    load_scene,
    save_eye,
    save_responses,
)
from omma.pictures import equirectangular, equirectangular_ids, field_ids, side_by_side
from omma.poses import load_poses, poses_from_angles, poses_from_quaternions
from omma.projections import PROJECTIONS, project, projection_ids
from omma.receptor_mosaic import (
    OmmatidiumType,
    assign_receptors,
    honeybee_ommatidia,
    up_towards,
)
from omma.receptors import (
    band_from_rgb,
    govardovskii,
    microvillus_direction,
    ommatidium_of_receptor,
    optical_sensitivity,
    primary_spectra,
    receptor_axis,
    receptor_matrix,
    receptor_optical_sensitivity,
    spectral_sensitivity,
)
from omma.renderer import Renderer
from omma.rendering import RenderReport, render_file
from omma.sampling_plots import (
    save_alias_curves,
    save_minimum_samples,
    save_speed_test,
    save_variance_map,
)
from omma.sampling_report import SamplingReport
from omma.sampling_search import Box, Cylinder, MinimumSamples, minimum_samples
from omma.sampling_tools import (
    Method,
    alias_curve,
    icosahedral_eye,
    rays_per_ommatidium,
    response_variances,
    solid_angles_sr,
    variance_map,
)
from omma.speed_test import SpeedTest, measure_speed
from omma.superposition import (
    Wiring,
    fly_receptors,
    neural_superposition_wiring,
    pool,
    superposition_facets,
)
from omma.surfaces import ellipsoid, load_surface, mesh_surface, sphere
from omma.world import World

__all__ = [
    "EYE_PROPERTIES",
    "PROJECTIONS",
    "Acceptance",
    "AcuteZone",
    "AllCamerasReport",
    "Background",
    "Box",
    "Camera",
    "CameraReport",
    "ConvertedEye",
    "Cylinder",
    "Error",
    "Eye",
    "EyeMeasures",
    "ImportedEye",
    "Lattice",
    "LatticeCheck",
    "LensConeEye",
    "Method",
    "MinimumSamples",
    "OmmatidiumType",
    "ReceptorType",
    "RenderReport",
    "Renderer",
    "SamplingReport",
    "Scene",
    "SpeedTest",
    "Wiring",
    "World",
    "WorldInstance",
    "__version__",
    "acceptance_from_facets",
    "acute_angle",
    "acute_zones",
    "alias_curve",
    "angle_table",
    "assign_receptors",
    "azimuth_elevation_deg_of",
    "band_from_rgb",
    "camera_eye",
    "check_lattice",
    "compoundray_library",
    "confidence_interval",
    "convert_eye",
    "direction",
    "display",
    "draw_eye",
    "ellipsoid",
    "encode_ids",
    "equirectangular",
    "equirectangular_ids",
    "eye_file_heads",
    "eye_file_losses",
    "eye_on_surface",
    "eye_summary",
    "eye_table",
    "facet_diameters_m",
    "field_ids",
    "fly_receptors",
    "generate_eye",
    "govardovskii",
    "honeybee_ommatidia",
    "icosahedral_eye",
    "import_lens_cone",
    "import_oda",
    "join_eyes",
    "lay_directions",
    "lay_on_surface",
    "load_acceptance",
    "load_angle_table",
    "load_eye",
    "load_poses",
    "load_scene",
    "load_surface",
    "look_at",
    "measure_eye",
    "measure_speed",
    "merge_eyes",
    "mesh_surface",
    "microvillus_direction",
    "minimum_samples",
    "mirror_eye",
    "neural_superposition_wiring",
    "ommatidium_of_receptor",
    "optical_sensitivity",
    "outline",
    "paint",
    "pair_of_eyes",
    "place_on_head",
    "plot_acceptance",
    "plot_eye_maps",
    "plot_poster",
    "plot_species",
    "pool",
    "poses_from_angles",
    "poses_from_quaternions",
    "primary_spectra",
    "project",
    "projection_ids",
    "rays_per_ommatidium",
    "receptor_axis",
    "receptor_matrix",
    "receptor_optical_sensitivity",
    "render_all_cameras",
    "render_camera",
    "render_file",
    "rescale_eye",
    "response_variances",
    "save_alias_curves",
    "save_eye",
    "save_eye_table",
    "save_minimum_samples",
    "save_png",
    "save_responses",
    "save_speed_test",
    "save_variance_map",
    "set_acceptance",
    "set_facets",
    "side_by_side",
    "skew_rad",
    "solid_angles_sr",
    "species",
    "spectral_sensitivity",
    "sphere",
    "split_eye",
    "squeeze_for_skew",
    "squeezed",
    "superposition_facets",
    "up_towards",
    "variance_map",
    "window",
]

for _name in __all__:
    if inspect.isfunction(globals()[_name]):
        _edge = globals()[_name] = checked(globals()[_name])
        _edge.__module__ = "omma"  # where it is found, so that it can be pickled
