"""Nonsense in calls: whatever is passed for an argument, the call works or is an omma.Error or a
TypeError; nothing from inside.

Each public function, constructor and method is called with arguments that do, of which one is
replaced by a piece of nonsense; which, is drawn, the same each time.
"""

import dataclasses
import json
import random
import re
import warnings
from datetime import date, datetime, timezone
from inspect import signature

import numpy as np
import pytest
import trimesh
from animated_scenes import swinging_box
from conftest import make_eye, write_gltf
from dataset_jobs import write_job
from public_names import public_things

import omma
from omma import species

# Calls of each function, and of those where one that works takes a second or more.
CALLS = 16
CALLS_OF_SLOW = 4
SLOW = {
    "plot_acceptance", "plot_capture_cameras", "plot_eye_maps", "plot_poster", "plot_responses",
    "plot_sky", "plot_species", "species.build",
}  # fmt: skip

# Known to let something else through, by function and parameter, and why. Whoever mends one takes
# it off the list.
_ARRAYS = "the engine hands it to NumPy and lets NumPy's ValueError through"
LEFT = {
    "Acceptance.eval(theta_rad)": _ARRAYS,
    "Acceptance.eval(azimuth_rad)": _ARRAYS,
    "Acceptance.pdf(theta_rad)": _ARRAYS,
    "Acceptance.pdf(azimuth_rad)": _ARRAYS,
    "Acceptance.mtf(cycles_per_rad)": _ARRAYS,
    "Acceptance.mtf(azimuth_rad)": _ARRAYS,
    "Eye.take(ommatidia)": _ARRAYS,
}

# Without a call that works: these want what only other parts of the tests make.
WITHOUT = {
    "compoundray_library": "the library of CompoundRay's interface, which is built on request",
    "jax_responses": "JAX (test_jax_responses)",
    "torch_dataset": "PyTorch (test_torch)",
    "torch_render_stream": "PyTorch (test_torch)",
    "torch_renders": "PyTorch (test_torch)",
    "torch_responses": "PyTorch (test_torch_responses)",
    "torch_stream": "PyTorch (test_torch)",
    "plot_species": "a species, which takes seconds to make",
    "Renderer.render_stokes": "a world that is polarised",
    "eye_env": "a loop (test_gym)",
    "eye_vector_env": "a loop (test_gym)",
    "FlyRetina": "a simulation of FlyGym",
    "PictureRetina": "FlyGym's map of hexagons (test_mujoco_retina)",
    "camera": "a model of MuJoCo (test_mujoco)",
    "fly_eye": "FlyGym's map of hexagons (test_mujoco_retina)",
    "head_pose": "a model of MuJoCo (test_mujoco)",
    "moving_things": "a model of MuJoCo (test_mujoco)",
    "scene_from_model": "a model of MuJoCo (test_mujoco)",
    "update": "a model of MuJoCo (test_mujoco)",
    "world_from_model": "a model of MuJoCo (test_mujoco)",
    "show": "a server with a page (test_view_window)",
    "Window": "a server with a page (test_view_window)",
    "Window.close": "a server with a page (test_view_window)",
    "Window.go_to": "a server with a page (test_view_window)",
    "CardArray": "a graphics card (test_card_arrays)",
    "World.set_color": "a world that was never lit",
    "World.set_image": "a world that was never lit, with an image",
}


NONSENSE = [
    None, -1, 0, True, 1.5, float("nan"), float("inf"), -1e300, 1e300, 2**31, 2**63, 2**70,
    -(10**30), 1j, "", "x", "\0", "a\udce4", b"x", [], [[]], [1, [2, 3]], ["a", None], (1, 2), {},
    {"x": None}, {1}, object(), int, lambda: None, np.empty(0), np.empty((0, 3)), np.zeros((2, 5)),
    np.full((3, 3), np.nan), np.zeros((4, 4)), np.zeros(3, complex), np.array(["a", "b", "c"]),
    np.array([None, 1, "x"]), np.datetime64("2020-01-01"), np.zeros((1, 1, 1, 1, 1)),
]  # fmt: skip


def parameters_of(function):
    """Names of the parameters, positional first; those of a compiled one from its signature."""
    compiled = getattr(function, "__init__", function)
    signatures = getattr(function, "__nb_signature__", getattr(compiled, "__nb_signature__", None))
    if signatures is None:
        return [name for name in signature(function).parameters if name != "self"]
    inside = re.search(r"\((.*)\) ->", signatures[0][0], re.S).group(1)
    names = re.findall(r"(?:^|, )(\w+)(?=[:=,]|$)", inside)
    return [name for name in names if name != "self"]


def public_calls(folder):
    scene_file = write_gltf(
        folder / "scene.gltf",
        cameras=[
            ("plain", None, {}),
            ("bug", {"compound-eye": True, "compound-structure": "bug.eye"}, {}),
        ],
    )
    document = json.loads(scene_file.read_text())
    box = {**document["meshes"][0], "name": "box", "extras": {"hitbox": "true"}}
    document["meshes"].append(box)
    document["nodes"].append({"name": "box", "mesh": 1})
    document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
    scene_file.write_text(json.dumps(document))
    eye = make_eye(24)
    omma.save_eye(folder / "bug.eye", eye)
    (folder / "poses.csv").write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0\n")
    (folder / "track.csv").write_text("x_m,z_m\n0,0\n0,-1\n")
    walked = np.array([(0.0, 0.0), (0.0, -1.0)])
    (folder / "s.csv").write_text("angle_deg,sensitivity\n0,1\n1,0.5\n2,0\n")
    (folder / "angles.csv").write_text(
        "azimuth_deg,elevation_deg,dphi_h_deg\n0,0,5\n1,0,5\n0,1,5\n1,1,5\n"
    )
    (folder / "columns.csv").write_text("side,p,q,x,y,z\nright,0,0,0,0,-1\nright,1,0,0,0.1,-1\n")
    (folder / "types.csv").write_text("column,column_type\nME_R_col_18_19,pale\n")
    spectra = folder / "spectra.csv"
    spectra.write_text("wl,a\n300,5\n700,6\n")
    (folder / "map.csv").write_text("p,q,x,y,z,theta,phi\n0,0,1,0,0,90,0\n")
    columns = omma.columns.hexal_columns(1, 0.1, (0, 0, -1))
    kinds = omma.columns.columns_of_eye(omma.species.drosophila().eye)[1][:7]
    few_columns = omma.species.drosophila().eye.take(kinds)
    scene = omma.load_scene(scene_file)
    renderer = omma.Renderer(scene, eye, omma.Fixed(1), threads=1)
    shown = scene.replace(
        images=[omma.scene.Image(np.ones((2, 2, 3)))],
        textures=[omma.scene.Texture(0)],
        materials=[*scene.materials, omma.scene.Material(base_color_texture=0)],
    )
    pose = np.eye(4)
    rgb = np.zeros((24, 3), np.float32)
    bee = omma.receptors.assign_receptors(eye, omma.receptors.honeybee_ommatidia())
    large = omma.eye.generate_eye(200, radius_m=1e-3)
    fly = omma.eye.superposition.fly_receptors(large)
    rows = [",".join(map(str, 1e3 * row)) for row in large.position_m]
    axes = ["[" + " ".join(map(str, row)) + "]" for row in large.axis]
    (folder / "oda.csv").write_text(
        "x,y,z,anatomical_axis,approx_axis\n"
        + "".join(f"{row},{axis},{axis}\n" for row, axis in zip(rows, axes, strict=True))
    )
    measures = omma.eye.measure_eye(eye)
    sphere = omma.eye.surfaces.sphere(1e-3)
    scan = np.random.default_rng(0).random((40, 3)) * (1, 0.01, 1)
    np.savetxt(folder / "scan.xyz", scan)
    capture = omma.scene.CaptureCameras([[0, 1, 0]], [np.eye(3)], [[30, 20]])
    frame = {"transform_matrix": np.eye(4).tolist()}
    (folder / "transforms.json").write_text(json.dumps({"frames": [frame]}))
    (folder / "face.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    splat = [(0, 0, -1)], [(0.1, 0.2, 0.3)], [(0, 0, 0, 1)], [0.5], np.zeros((1, 4, 3))
    omma.scene.save_splats(folder / "splat.ply", omma.scene.SplatCloud(*splat))
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    mesh = omma.scene.Mesh(corners, [[0, 1, 2]])
    swinging = swinging_box(folder / "swing.gltf")
    wedge = trimesh.Trimesh(corners, [[0, 1, 2]])
    directions = eye.axis.astype(float)
    curve = ([1, 2], {omma.study.Method(): ([1, 2], [0.2, 0.1])})
    found = omma.study.minimum_samples(renderer, pose[None], fraction=0.5, poses=1)
    speed = omma.study.measure_speed(scene, eye, pose, [1], frames=1, warm_up_s=0)
    png, csv = str(folder / "o.png"), str(folder / "o.csv")
    few = omma.light.Bands.equal(4)
    light = omma.light.clear_sky(30.0, bands=few)
    kept = str(folder / "kept.npy")
    omma.render_file(scene_file, kept, omma.Fixed(1), eyes=folder / "bug.eye")
    table = omma.Acceptance.table([0, 0.1, 0.2], [1, 0.5, 0])
    green = omma.receptors.ReceptorType("green", peak_wavelength_nm=540.0)
    drum = omma.stimuli.DrumGrating()
    impulse = omma.photoreceptors.ImpulseResponse
    frames = np.ones((4, len(eye)))
    # The shape of their first frame is that of all.
    started = omma.photoreceptors.FrameFilter(impulse.box(0.02), 100.0)
    adapted = omma.photoreceptors.VanHaterenSnippe(100.0)
    started.filter(frames[0])
    adapted.filter(frames[0])
    sensor = omma.photoreceptors.EventSensor()
    events = sensor.run([np.ones(24), np.full(24, 2.0)], [0.0, 1.0])
    job = write_job(folder / "job", count=3)
    omma.datasets.run(job)
    views = omma.datasets.open_views(folder / "job" / "job.zarr")
    good = {
        "World.bake_cost": (),  # of a lit world, below
        "HeadPose": ((0, 0, 0),),
        "Look": (omma.view.HeadPose(),),
        "AcuteZone": (0.0, 0.0, 0.5, 2.0),
        "Box": ((0, 0, 0), (1, 1, 1)),
        "Cylinder": ((0, 0, 0), 1.0, 1.0),
        "Method": (),
        "OmmatidiumType": ("a", (green,)),
        "Wiring": ([0, 1], [0], [1.0]),
        "Renderer": (scene, eye),
        "Population": (omma.World(scene), [eye, eye]),
        "Scene": {
            "meshes": (mesh,), "instances": (omma.scene.Instance(0),), "materials": (),
            "textures": (), "images": (), "cameras": (), "hit_boxes": (),
            "lights": (), "splats": (), "background": omma.Background.simple_sky(),
            "color_rule": "gltf", "rig": None,
        },
        "Camera": ("bee",),
        "BoundaryTable": ([300, 700], np.tile([0.5, 0.1, -0.4], (2, 3, 1))),
        "LayerStack": ([(100.0, 1.5)], 1.5, 0.01),
        "LayerStack.mueller": (500.0, 30.0),
        "LayerStack.boundary": ([300.0, 700.0],),
        "LayerStack.material": ("film", 0.2),
        "ExtraReflectance": (0, [omma.light.Spectrum([300, 400], [0.5, 0.5])]),
        "HitBox": ("zone", corners, [[0, 1, 2]]),
        "Image": (np.zeros((2, 2, 3), np.uint8),),
        "Instance": (0,),
        "Material": ("green",),
        "Mesh": {"positions_m": corners, "triangles": [[0, 1, 2]]},
        "PunctualLight": ("lamp",),
        "Spectrum": ([300, 400], [0.5, 0.5]),
        "SplatCloud": splat,
        "calibrate": {
            "scene": omma.Scene(splats=[omma.scene.SplatCloud(*splat)]),
            "gray_card": (0.5, 0.5, 0.5), "exposure": 12.0,
        },
        "cull_splats": {
            "splats": omma.scene.SplatCloud(*splat), "least_opacity": 0.1, "scan": scan,
            "distance_m": 9.0, "beyond_m": 9.0, "above_m": 9.0,
        },
        "load_splats": (folder / "splat.ply",),
        "save_splats": (str(folder / "saved.ply"), omma.scene.SplatCloud(*splat)),
        "Texture": (0,),
        "TextureUse": (0,),
        "scene.sphere": {"segments": 8},
        "corridor": {
            "length_m": 1.0, "width_m": 1.0, "height_m": 1.0, "left": (1, 1, 1),
            "right": (1, 1, 1),
        },
        "drum": (1.0, 1.0, (1, 1, 1)),
        "from_trimesh": (wedge,),
        "merge_scenes": ([scene],),
        "place_scene": (scene, pose),
        "with_reflectance": {
            "scene": scene.replace(materials=[omma.scene.Material("petal")]), "name": "petal",
            "reflectance": omma.light.Spectrum([300, 700], [0, 1]),
        },
        "save_scene": (str(folder / "saved.glb"), scene),
        "World": (scene,),
        "Eye": ([[0, 0, 0]], [[0, 0, -1]], 0.1),
        "ReceptorType": {"name": "green", "peak_wavelength_nm": 540.0},
        "Acceptance.table": ([0, 0.1, 0.2], [1, 0.5, 0]),
        "Acceptance.table_2d": ([-0.1, 0, 0.1], [-0.1, 0, 0.1], np.eye(3)[::-1] + 0.1),
        "Acceptance.gaussian": (0.1,),
        "Acceptance.pillbox": (0.1,),
        "Acceptance.compoundray": (0.1,),
        "Acceptance.lens_rhabdom": (25e-6, 60e-6, 2e-6, 500.0),
        "Acceptance.airy": (25e-6, 500.0),
        "Background.constant": ((1, 1, 1),),
        "Background.image": (np.zeros((2, 4, 3), np.float32),),
        "acceptance_from_facets": (omma.eye.set_facets(large),),
        "acute_angle": (0.1, lambda v: np.ones(len(v))),
        "acute_zones": ([omma.eye.AcuteZone(0.0, 0.0, 0.5, 2.0)],),
        "alias_curve": (renderer, eye, pose, [1]),
        "angle_table": ([0, 1], [0, 1], [[5, 5], [5, 5]]),
        "assign_receptors": (eye, omma.receptors.honeybee_ommatidia()),
        "azimuth_elevation_deg_of": (directions,),
        "camera_eye": (scene, "bug"),
        "check_lattice": (omma.eye.lay_directions(0.3).directions, 0.3),
        "confidence_interval": {
            "eye": eye, "responses": rgb, "standard_errors": rgb, "rays": 8,
        },
        "convert_eye": (folder / "bug.eye",),
        "direction": (0.0, 0.0),
        "display": (np.zeros((2, 2, 3), np.float32),),
        "draw_eye": (png, eye),
        "ellipsoid": ((1e-3, 1e-3, 2e-3),),
        "encode_ids": (np.zeros((2, 2), np.int32),),
        "equirectangular": (eye, rgb, 16, 8),
        "equirectangular_ids": (eye, 16, 8),
        "eye_file_heads": (folder / "scene.gltf",),
        "eye_file_losses": ("a.eye", eye),
        "eye_on_surface": (directions, sphere),
        "eye_summary": (eye, measures),
        "eye_table": (eye, measures),
        "facet_diameters_m": (eye,),
        "field_ids": (eye, 16, 8),
        "fly_receptors": (large,),
        "framed": (eye, rgb, 16, 8),
        "generate_eye": (20,),
        "govardovskii": (540.0, [500.0]),
        "ImpulseResponse": ("howard", 0.01, 0.3),
        "ImpulseResponse.howard": (0.01, 0.3),
        "ImpulseResponse.exponential": (0.01,),
        "ImpulseResponse.box": (0.01,),
        "ImpulseResponse.table": ([0, 0.01, 0.02], [0, 1, 0]),
        "EventSensor": (0.2, 0.2, 0.01, "log", 0.1),
        "event_counts": (events, [0.0, 1.0], (24,)),
        "EventState": (0.0, np.ones(3), np.ones(3), np.ones(3)),
        "FrameFilter": (impulse.howard(0.01, 0.3), 100.0),
        "VanHaterenSnippe": (100.0,),
        "displace_axes": (eye.axis, eye.up, np.full(len(eye), 0.01), 0.0),
        "frame_integration_time_s": (impulse.howard(0.01, 0.3), 100.0),
        "filter_frames": (frames, 100.0, impulse.box(0.02)),
        "intrinsic_noise": (frames, 0.1, 1),
        "large_monopolar": (frames, 100.0, np.full((len(eye), 6), -1)),
        "logarithmic": (frames, 1.0),
        "microsaccades_rad": {"light": frames, "frame_rate_hz": 100.0, "dark": 1.0},
        "naka_rushton": (frames, 1.0),
        "photon_noise": (frames, 1),
        "published_response": ("blowfly",),
        "van_hateren_snippe": (frames, 100.0),
        "import_lens_cone": (1e-4 * directions, 0.9e-4 * directions),
        "import_oda": (folder / "oda.csv",),
        "join_eyes": ([eye, eye],),
        "lay_directions": {
            "horizontal_rad": 0.3, "field_of_view": omma.eye.window((-30.0, 30.0), (-30.0, 30.0)),
        },
        "lay_on_surface": (sphere, 0.5e-3),
        "load_acceptance": (folder / "s.csv",),
        "load_angle_table": (folder / "angles.csv",),
        "load_eye": (folder / "bug.eye",),
        "ColumnRenderer": (scene, few_columns, columns),
        "ColumnRenderer.render": (pose,),
        "cartridge_wiring": (columns,),
        "find_columns": (columns, [("right", 0, 0)]),
        "flywire_names": (columns,),
        "flyvis_movie": {"light": np.zeros((2, len(columns))), "columns": columns, "radius": 1},
        "load_column_types": (folder / "types.csv",),
        "load_eye_map": (folder / "map.csv",),
        "malecns_names": (columns,),
        "measured_drosophila": (),
        "photoreceptor_table": {
            "world": scene, "poses": pose, "fly": few_columns, "columns": columns,
            "sampling": omma.Fixed(1),
        },
        "achromatic_distance": (0.2, 0.5, 0.1),
        "class_noise": (0.1, [1, 2, 2]),
        "d_prime": ([110.0, 90.0], [90.0, 90.0]),
        "DiscTarget": (0.02, 0.1, 0.3),
        "SceneTarget": (scene, scene, 0.1),
        "Observer": (),
        "detect": {
            "eye": bee.replace(facet_diameter_m=np.full(24, 2e-5)),
            "target": omma.colour_vision.DiscTarget(0.02, 0.1, 0.3), "light": light,
            "between_m": (0.01, 0.1), "sampling": omma.Fixed(1),
        },
        "excitations": ([0.5, 1.0, 2.0],),
        "plot_distances": (folder / "distances.png", [1.0, 2.0], ["a", "b"]),
        "plot_fly_categories": (folder / "categories.png", [1.0, 2.0, 2.0, 1.0]),
        "plot_hexagon": (folder / "hexagon.png", [0.1, 0.5, 0.9]),
        "plot_tetrahedron": (folder / "tetrahedron.png", [1.0, 2.0, 2.0, 1.0]),
        "plot_triangle": (folder / "triangle.png", [1.0, 2.0, 2.0]),
        "fly_category": ([1.0, 2.0, 2.0, 1.0],),
        "fly_opponents": ([1.0, 2.0, 2.0, 1.0],),
        "hexagon": ([0.1, 0.5, 0.9],),
        "hexagon_contrast": ([0.1, 0.5, 0.9], [0.5, 0.5, 0.5]),
        "hexagon_hue_deg": ([0.1, 0.2],),
        "hexagon_sector": ([0.1, 0.2],),
        "maxwell_triangle": ([0.1, 0.2, 0.3],),
        "michelson_contrast": (1.0, 2.0),
        "noise_limited_coordinates": ([0.2, 0.5, 0.5], [0.1, 0.1, 0.1]),
        "noise_limited_distance": {
            "first": [0.2, 0.5, 0.5], "second": [0.5, 0.5, 0.5], "noise": [0.1, 0.1, 0.1],
            "signal": "linear", "adapting": [1.0, 1.0, 1.0],
        },
        "proportion_correct": (1.0,),
        "tetrahedron": ([0.1, 0.2, 0.3, 0.4],),
        "von_kries": ([0.1, 0.2, 0.3], [0.5, 0.5, 0.5]),
        "weber_contrast": (1.0, 2.0),
        "column_pairs": (columns,),
        "columns_of_eye": (large,),
        "eye_of_columns": (columns, 0.1),
        "hex_from_pq": ([0, 1], [0, 1]),
        "hexal_columns": (2, 0.1, (0, 0, -1)),
        "hexals": (2,),
        "load_columns": (folder / "columns.csv",),
        "pq_from_hex": ([18, 19], [19, 20]),
        "pq_from_uv": ([0, 1], [0, 1]),
        "resample": (np.zeros((2, 24, 1)), omma.columns.resampling_matrix(eye, columns)),
        "resampling_matrix": (eye, columns),
        "seen_by": (eye, columns),
        "to_hexals": (np.zeros((2, len(columns), 1)), columns, 1),
        "uv_from_pq": ([0, 1], [0, 1]),
        "response_bounds": (omma.World(scene),),
        "ultraviolet_dependence": (
            omma.Renderer(
                omma.World(
                    scene, light=omma.light.uniform_sky(1e17), ultraviolet=0.1, lighting="path"
                ),
                bee,
                omma.Fixed(1),
            ),
            pose,
        ),
        "see_panorama": (np.ones((9, 18, 3)), eye),
        "PanoramaView": (eye, omma.rendering.Equirectangular(9, 18)),
        "Equirectangular": (9, 18),
        "CubeFaces": (8,),
        "Fisheye": (8, 8),
        "render_agents": ([omma.Renderer(scene, bee, omma.Fixed(1))], pose[None, None]),
        "load_poses": (folder / "poses.csv",),
        "load_scene": (folder / "scene.gltf",),
        "load_surface": (folder / "face.obj",),
        "CaptureCameras": ([[0, 1, 0]], [np.eye(3)]),
        "load_capture_cameras": (folder / "transforms.json",),
        "plot_capture_cameras": (png, capture),
        "load_points": (folder / "scan.xyz",),
        "surfels": (omma.scene.PointCloud(scan),),
        "look_at": ((0, 0, 0), (0, 0, -1)),
        "measure_eye": (eye,),
        "measure_speed": {
            "scene": scene, "eye": eye, "pose": pose, "rays": [1], "frames": 1, "warm_up_s": 0.0,
        },
        "merge_eyes": ([eye, eye],),
        "mesh_surface": ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
        "microvillus_direction": (bee,),
        "minimum_samples": {"scene": renderer, "where": pose[None], "fraction": 0.5, "poses": 1},
        "mirror_eye": (eye,),
        "neural_superposition_wiring": (fly,),
        "ommatidium_of_receptor": (bee,),
        "optical_sensitivity": (25e-6, 0.02, 1e-4, 1e4),
        "outline": ([[-90, -45], [90, -45], [90, 45], [-90, 45]],),
        "paint": (np.zeros((2, 2), np.int32), rgb),
        "pair_of_eyes": (omma.eye.place_on_head(eye, (1e-3, 0, 0)),),
        "place_on_head": (eye,),
        "plot_acceptance": (png, eye),
        "plot_eye_maps": (png, eye),
        "plot_poster": (png, eye),
        "pool": (np.zeros(1, np.float32), omma.eye.superposition.Wiring([0, 1], [0], [1.0])),
        "poses_from_angles": ((0, 0, 0), (0, 0, 0)),
        "poses_from_quaternions": ((0, 0, 0), (0, 0, 0, 1)),
        "Bands": ([400.0, 500.0], [[1.0, 1.0]]),
        "Bands.equal": (4,),
        "Bands.from_edges": ([400.0, 500.0],),
        "Bands.from_sensitivities": ([400.0, 500.0], [[1.0, 1.0]]),
        "Disc": ((0, 1, 0), 0.004, [1.0]),
        "Light": (few,),
        "band_error": (light, [green]),
        "natural_material": ("sand",),
        "refractive_index": ("gold",),
        "water": {"kind": "IB", "wind_m_per_s": 2.0, "depth_m": 1.0, "bottom": "sand"},
        "water_volume": {"kind": "IB"},
        "wave_roughness": (2.0,),
        "bands_to_rgb": (np.ones((5, len(light.bands))), light),
        "cie_relative_luminance": (1, 30.0, [10.0, 90.0]),
        "cie_sky": {"sky_type": 12, "sun_elevation_deg": 30.0, "bands": few},
        "cloud_transmittance": ([1.0, 10.0], 0.5),
        "clouded": (light, 0.5, "cumulus"),
        "with_air": (light, 500.0),
        "under_water": (light, 2.0, "II"),
        "cloudy_sky": {"sun_elevation_deg": 30.0, "bands": few},
        "clear_sky": {"sun_elevation_deg": 30.0, "bands": few},
        "clear_sky_at": {
            "date_time": datetime(2026, 6, 21, 12, tzinfo=timezone.utc), "latitude_deg": 50.0,
            "longitude_deg": 10.0, "bands": few,
        },
        "moonlit_sky": {
            "moon_elevation_deg": 30.0, "phase_angle_deg": 60.0, "bright_limb_deg": 90.0,
            "bands": few,
        },
        "stars": {
            "date_time": datetime(2026, 6, 21, 12, tzinfo=timezone.utc), "latitude_deg": 50.0,
            "longitude_deg": 10.0, "faintest_magnitude": 0.5, "bands": few,
        },
        "MoonPosition": (135.0, 30.0, 0.0, 1.0),
        "moon_position": (datetime(2026, 6, 21, 12, tzinfo=timezone.utc), 50.0, 10.0),
        "natural_sky": {"sun_elevation_deg": -10.0, "bands": few},
        "natural_sky_at": {
            "date_time": datetime(2026, 6, 21, 12, tzinfo=timezone.utc), "latitude_deg": 50.0,
            "longitude_deg": 10.0, "bands": few,
        },
        "night_sky": {"bands": few},
        "night_sky_at": {
            "date_time": datetime(2026, 6, 21, 0, tzinfo=timezone.utc), "latitude_deg": 50.0,
            "longitude_deg": 10.0, "bands": few,
        },
        "overcast_sky": {"sun_elevation_deg": 30.0, "bands": few},
        "panorama": {"image": np.ones((2, 4, 3), np.float32), "ultraviolet": "dark", "bands": few},
        "panorama_bands": {"radiance": np.ones((2, 4, 4)), "bands": few},
        "load_spectra": {"path": spectra, "unit": "percent", "columns": ["a"]},
        "measured_sky": {
            "irradiance": omma.light.Spectrum([300, 700], [1, 1]), "irradiance_unit": "watts",
            "bands": few,
        },
        "photon_catch": {
            "eye": bee.replace(facet_diameter_m=2e-5), "responses": np.ones(len(bee.receptor_type)),
            "light": light, "integration_time_s": 0.01,
        },
        "photons_from_watts": (1.0, 500.0),
        "plot_sky": {"paths": png, "light": light, "wavelengths_nm": [500.0], "size_mm": 40.0},
        "polarisation_weights": (bee,),
        "SunPosition": (135.0, 30.0),
        "sun_position": (datetime(2026, 6, 21, 12, tzinfo=timezone.utc), 50.0, 10.0),
        "dawn": (date(2026, 6, 21), 40.0, 10.0, "civil"),
        "dusk": (date(2026, 6, 21), 40.0, 10.0, "civil"),
        "solar_noon": (date(2026, 6, 21), 40.0, 10.0),
        "sunrise": (date(2026, 6, 21), 40.0, 10.0),
        "sunset": (date(2026, 6, 21), 40.0, 10.0),
        "uniform_sky": {"radiance": 1.0, "bands": few},
        "watts_from_photons": (1.0, 500.0),
        "band_from_rgb": ([400.0, 500.0, 700.0],),
        "primary_spectra": ([500.0],),
        "project": (eye, rgb, "spherical_orientationwise", 16, 8),
        "projection_ids": (eye, "spherical_orientationwise", 16, 8),
        "rays_per_ommatidium": (eye, 1000.0),
        "receptor_axis": (bee,),
        "receptor_matrix": (bee,),
        "receptor_optical_sensitivity": (bee,),
        "receptor_solid_angle_sr": (bee,),
        "receptor_wiring": (bee, omma.eye.superposition.Wiring([0, 1], [0], [1.0])),
        "rhabdom_share": (bee,),
        "solid_angle_sr": (0.05,),
        "render_all_cameras": {
            "scene": scene_file, "folder": folder / "all", "width": 8, "height": 4,
            "sampling": omma.Fixed(1),
        },
        "render_camera": {"scene": renderer, "camera": 0, "width": 8, "height": 4, "samples": 1},
        "batches": (views, 2),
        "contact_sheet": (png, views.store, 2),
        "describe": (views.store,),
        "load_job": (job,),
        "open_views": (views.store, ["response"]),
        "run": (job,),
        "to_webdataset": (views.store, folder / "tars"),
        "torch_dataset": (views,),
        "torch_render_stream": (renderer, lambda rng, count: np.tile(pose, (count, 1, 1))),
        "torch_renders": (renderer, pose),
        "torch_stream": (views, 2),
        "verify": (views.store,),
        "render_file": {
            "scene": scene_file, "outputs": [csv], "eyes": [folder / "bug.eye"],
            "sampling": omma.Fixed(1),
        },
        "rescale_eye": (eye, 2.0),
        "response_variances": {
            "scene": renderer, "eye": eye, "poses": pose, "rays": 1, "repeats": 2,
        },
        "save_alias_curves": (png, *curve),
        "save_eye": (csv, eye),
        "save_eye_table": (csv, eye, measures),
        "save_minimum_samples": (png, [found]),
        "save_png": (png, np.zeros((2, 2, 3), np.uint8)),
        "save_responses": (csv, rgb, eye),
        "save_speed_test": (png, speed),
        "velocities_from_poses": ([pose, pose], [0.0, 1.0]),
        "save_variance_map": (csv, np.ones((2, 2)), (0, 0, 0), 1.0),
        "set_acceptance": {"eye": eye, "angle_rad": 0.1},
        "set_facets": (eye,),
        "side_by_side": (eye, rgb, 16, 8),
        "skew_rad": (eye,),
        "solid_angles_sr": (eye,),
        "spectral_sensitivity": (green, [500.0]),
        "sphere": (1e-3,),
        "split_eye": (eye,),
        "squeeze_for_skew": (directions, sphere, (0, 0, -1), 0.1),
        "squeezed": ((0, 0, -1), 1.0),
        "superposition_facets": (eye, 1e-3),
        "up_towards": (eye, (0, 1, 0)),
        "variance_map": {
            "scene": renderer, "center_m": (0, 1, 0), "size_m": 1.0, "steps": 2, "repeats": 2,
        },
        "window": (),
        "Bar": (10.0, 60.0),
        "DrumGrating": (20.0, 1.0),
        "LedArena": (drum, 0.05, 1, 40.0),
        "LoomingDisc": (0.05, 1.0),
        "NoisePanorama": {"pixel_deg": 10.0},
        "PlaneGrating": (0.5, 1.0),
        "RandomDots": (10, 5.0),
        "SphereGrating": (20.0, 1.0),
        "Starfield": (10, 0.02),
        "Target": (1.0, [0, 1], [0, 10], [0, 0]),
        "edge": (60.0,),
        "optomotor_drum": (18, 60.0),
        "DetectorArray": {
            "count": 24, "pairs": [[0, 1]], "displacement_rad": np.ones((1, 2, 2)), "tau_s": 0.035,
            "frame_rate_hz": 500.0, "high_pass_tau_s": 0.2,
        },
        "LoomingCells": {
            "count": 24, "center": [[0, 0, -1]], "cell": [0], "arm": [1], "ommatidium": [2],
            "along": [[0.0, 1.0]],
        },
        "best_frequency_hz": (0.035, 0.2),
        "detector_array": {
            "eye": eye, "tau_s": 0.035, "frame_rate_hz": 500.0, "pairs": [[0, 1]],
            "high_pass_tau_s": 0.2,
        },
        "expansion": (eye, np.zeros((len(eye), 2)), (0, 0, -1)),
        "looming_cells": (eye, [[0, 0, -1]]),
        "grating_response": {
            "contrast": 1.0, "wavelength_rad": 0.5, "frequency_hz": 5.0, "separation_rad": 0.1,
            "tau_s": 0.035, "high_pass_tau_s": 0.2, "acceptance_angle_rad": 0.1,
            "frame_rate_hz": 500.0,
        },
        "hexagonal_coordinates": (eye,),
        "neighbour_pairs": (large,),
        "ground_at": (omma.scene.plane(), omma.look_at((0, 1, 0), (0, 1, -1))),
        "load_track": (folder / "track.csv",),
        "place_on": dict(ground=omma.scene.plane(), xz_m=(0.1, 0.2), height_m=0.01),
        "walk_on": dict(ground=omma.scene.plane(), track=walked, height_m=0.01),
        "Track": (walked,),
        "load_responses": (kept,),
        "plot_responses": (png, eye, rgb),
        "render_like": (kept, csv),
        "species.make": ("melophorus",),
        "species.assume_rhabdoms": (bee, "honeybee_worker"),
        "species.build": ("honeybee_worker",),
        "species.facts": ("honeybee_worker",),
        "species.facts_text": ("honeybee_worker",),
    }  # fmt: skip
    of_stimulus = {
        "scene": (), "world": {}, "move": (drum.world(), 0.1), "velocities": ([0.0],),
        "expected": ([[0, 0, -1]], 0.1, [0.0]), "transforms": ([0.0],),
        "radiance": ([0, 0, -1], 0.0), "play": (omma.Renderer(drum.world(), eye), [0.0]),
    }  # fmt: skip
    disc = omma.stimuli.LoomingDisc()
    target = omma.stimuli.Target(1.0, [0, 1], [0, 10], [0, 0])
    stars = omma.stimuli.Starfield(3)
    arena = omma.stimuli.LedArena(drum, 0.05, refresh_hz=40.0)
    methods = {
        "DrumGrating": (drum, of_stimulus),
        "LoomingDisc": (disc, {
            **of_stimulus, "size_deg": ([0.0],), "move": (disc.world(), 0.1),
            "play": (omma.Renderer(disc.world(), eye), [0.0]),
        }),
        "Target": (target, {
            **of_stimulus, "directions": ([0.0],), "move": (target.world(), 0.1),
            "play": (omma.Renderer(target.world(), eye), [0.0]),
        }),
        "Starfield": (stars, {
            **of_stimulus, "positions_m": (0.0,), "move": (stars.world(), 0.1),
            "play": (omma.Renderer(stars.world(), eye), [0.0]),
        }),
        "LedArena": (arena, {
            **of_stimulus, "pixels": (0.0,), "move": (arena.world(), 0.1),
            "play": (omma.Renderer(arena.world(), eye), [0.0]),
        }),
        "Renderer": (omma.Renderer(shown, bee, omma.Fixed(1), threads=1, footprints=False), {
            "render": (pose,), "render_rays": (pose,), "render_receptors": (pose,),
            "render_stokes": (pose,),
            "with_eye": (eye,), "render_iter": ([pose],), "dataset": (pose,),
            "ground_truth": (pose,), "with_world": (omma.World(scene),),
            "jacobian": (pose,), "jvp": (pose, {"axis": np.zeros((24, 3))}),
            "vjp": (pose, np.zeros((1, 24, 3))), "color_jacobian": (pose, "background"),
            "background_vjp": (pose, np.zeros((1, 24, 3)), (4, 8)),
            "image_vjp": (pose, np.zeros((1, 24, 3)), 0),
        }),
        "Jacobian": (omma.Renderer(scene, bee, omma.Fixed(1)).jacobian(pose, by="axis"), {
            "jvp": ({"axis": np.zeros((24, 3))},), "vjp": (np.zeros((1, 24, 3)),),
        }),
        "Population": (omma.Population(omma.World(scene), [bee, bee]), {
            "render": (pose,), "render_receptors": (pose,), "with_eyes": ([bee],),
        }),
        "Eye": (bee, {"select": (0,), "acceptance": (0,), "take": ([0, 1],)}),
        "Acceptance": (table, {"eval": ([0.1],), "pdf": ([0.1],), "mtf": ([1.0],), "sample": (3,)}),
        "Scene": (scene, {
            "camera": ("plain",), "hit_box_bounds": ("box",), "is_inside": ("box", [[0, 0, 0]]),
        }),
        "World": (omma.World(omma.scene.merge_scenes([scene, swinging])), {
            "index": ("ground",), "set_transforms": ("ground", pose), "at": (0.5, "swing"),
            "camera_at": ("bug", 0.5), "set_vertices": (0, scene.meshes[0].positions_m),
            "vertices": (0,), "set_color": (0, (0.1, 0.2, 0.3)),
            "set_image": (0, np.zeros((2, 2, 3), np.uint8)),
            "with_background": (omma.Background.constant((1, 1, 1)),),
            "with_light": {"light": omma.light.uniform_sky(1.0), "ultraviolet": "dark"},
        }),
        "ImpulseResponse": (omma.photoreceptors.ImpulseResponse.howard(0.01, 0.3), {
            "eval": ([0.01],), "cumulative": ([0.01],), "first_moment_s": ([0.01],),
            "quantile": ([0.5],), "sample": ([0.5],), "transfer": ([10.0],),
        }),
        "EventSensor": (sensor, {
            "step": (None, np.ones(24), 0.0), "run": (np.ones((2, 24)), [0.0, 1.0]),
            "dataset": (events, eye),
        }),
        "EventState": (sensor.step(None, np.ones(24), 0.0)[0], {}),
        "FrameFilter": (started, {"filter": (frames[0],)}),
        "VanHaterenSnippe": (adapted, {"filter": (frames[0],)}),
        "Lattice": (omma.eye.lay_directions(0.3), {}),
        "Observer": (omma.colour_vision.Observer(), {"direction": ()}),
        "Bands": (few, {"mean": ([1.0, 2.0], [300.0, 700.0])}),
        "CloudShadow": (omma.light.CloudShadow([[0.0, 1.0], [1.0, 0.0]], 50.0, 800.0), {
            "transmittance": ((0, 0, 0), (0, 1, 0)),
        }),
        "Disc": (omma.light.Disc((0, 1, 0), 0.004, [1.0]), {"radiance_at": ((0, 1, 0),)}),
        "Light": (light, {
            "radiance": ((0, 1, 0),), "irradiance": (), "turned": (10.0,), "scaled": (2.0,),
            "in_bands": (few,), "plus": (light,),
        }),
        "BandError": (omma.receptors.BandError(np.zeros((1, 1, 1))), {}),
        "EyeMeasures": (measures, {}),
        "Ellipsoid": (sphere, {
            "onto": (1e-3 * directions,), "normals": (1e-3 * directions,),
            "near": (1e-3 * directions,), "point_of_normal": (directions,), "samples": (9,),
            "to_edge": (1e-3 * directions,),
        }),
        "AcuteZone": (omma.eye.AcuteZone(0.0, 0.0, 0.5, 2.0), {"density": (directions,)}),
        "Box": (omma.study.Box((0, 0, 0), (1, 1, 1)), {}),
        "DetectorArray": (omma.motion.detector_array(eye, 0.035, 500.0, pairs=[[0, 1]]), {
            "step": (None, np.ones(24)), "run": (np.ones((3, 24)),), "vectors": (np.ones((3, 1)),),
        }),
        "LoomingCells": (omma.motion.looming_cells(eye, [[0, 0, -1]]), {
            "arms": (np.zeros((len(eye), 2)),), "responses": (np.zeros((len(eye), 2)),),
        }),
        "PanoramaView": (
            omma.rendering.PanoramaView(eye, omma.rendering.Equirectangular(9, 18)),
            {"see": (np.ones((9, 18, 3)),), "see_each": ([np.ones((9, 18, 3))],)},
        ),
        "Track": (omma.motion.Track(walked, times_s=[0, 1]), {
            "every": (0.5,), "at_speed": dict(speed_m_s=0.5, step_s=0.5),
        }),
        "Wiring": (omma.eye.superposition.Wiring([0, 1], [0], [1.0]), {}),
        "CaptureCameras": (capture, {"nearness": (eye, pose)}),
        "GroundTruth": (renderer.ground_truth(pose), {}),
        "UltravioletDependence": (
            omma.rendering.UltravioletDependence((), *[np.ones((1, 1))] * 3), {},
        ),
        "SamplingReport": (
            omma.rendering.SamplingReport(np.ones((1, 1)), np.ones((1, 1, 3)), 0.1), {},
        ),
    }  # fmt: skip
    for subpackage, name, thing in public_things():
        # Names that are also those of other things.
        known = subpackage == "species" or (subpackage, name) == ("scene", "sphere")
        full = f"{subpackage}.{name}" if known else name
        if name == "Error" or not callable(thing):
            continue
        if subpackage == "species" and name in species.names():
            continue  # they take seconds, and one argument, which `make` has too
        if name in ("Acceptance", "Animation", "Background", "WorldInstance"):
            continue  # made by static methods, or by the engine alone
        if dataclasses.is_dataclass(thing) and full not in good:
            continue  # results: whoever makes one knows what of
        yield full, thing, good.get(full, ())
    for kind in (omma.Acceptance, omma.Background, omma.light.Bands, impulse):
        for name, thing in vars(kind).items():
            if isinstance(thing, staticmethod) or type(thing).__name__ == "nb_func":
                full = f"{kind.__name__}.{name}"
                yield full, getattr(kind, name), good.get(full, ())
    for kind, (owner, known) in methods.items():
        for name in dir(owner):
            method = None if name.startswith("_") else getattr(owner, name)
            if callable(method) and f"{kind}.{name}" not in good:
                yield f"{kind}.{name}", method, known.get(name, ())
    lit = omma.World(scene, light=omma.light.uniform_sky(1.0), ultraviolet="dark")
    yield "World.bake_cost", lit.bake_cost, ()


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    """(name, function, arguments that do) of everything public."""
    folder = tmp_path_factory.mktemp("nonsense")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)  # what writes to a nonsensical path, writes there
        yield list(public_calls(folder))


def by_name(function, good):
    if isinstance(good, dict):
        return good
    return dict(zip(parameters_of(function), good, strict=False))


def outcome(function, named):
    """None where it works or says what is wrong, else what came."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            function(**named)
        except (omma.Error, TypeError):
            return None
        except Exception as error:  # whatever it is, it is what the test is after
            return f"{type(error).__name__}: {error}"[:160]


def test_nonsense_is_refused(calls):
    total, wrong = 0, {}
    for name, function, good in calls:
        named = by_name(function, good)
        drawn = random.Random(name)
        every = [(key, value) for key in parameters_of(function) for value in NONSENSE]
        count = CALLS_OF_SLOW if name in SLOW else CALLS
        picked = drawn.sample(every, min(count, len(every)))
        # All of it where some is known to come through, so that the list stays true.
        picked += [(key, value) for key, value in every if f"{name}({key})" in LEFT]
        for key, value in picked:
            total += 1
            came = outcome(function, {**named, key: value})
            if came:
                wrong.setdefault(f"{name}({key})", []).append(f"{value!r:.60}: {came}")
    assert total > 2000
    unexpected = [
        f"{place}, {text}" for place in wrong if place not in LEFT for text in wrong[place]
    ]
    assert not unexpected, f"{len(unexpected)} of {total} calls:\n" + "\n".join(unexpected)
    assert set(wrong) == set(LEFT), "mended, so off the list"


def test_every_call_does_without_nonsense(calls):
    """Else the nonsense would never come to where it can do harm."""
    for name, function, good in calls:
        if name not in WITHOUT and name not in SLOW:
            function(**by_name(function, good))
