"""Values behave as values: one of each public class is pickled, copied, compared and printed."""

import copy
import dataclasses
import inspect
import operator
import pickle
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from animated_scenes import swinging_box
from conftest import make_eye
from dataset_jobs import write_job
from public_names import public_things

import omma
from omma.base.values import same, value_class


def begun(rng):
    """Of a loop: where it starts."""
    return 0, np.eye(4)


def all_round_eye(path=""):
    """An eye in which no array is as it is by default."""
    count = 6
    plain = make_eye(count)
    kinds = [
        omma.Acceptance.gaussian(0.1, 0.05, 0.3),
        omma.Acceptance.airy(20e-6, 500),
        omma.Acceptance.lens_rhabdom(25e-6, 60e-6, 1.5e-6, 500, 1.37, 1.33, "snyder"),
        omma.Acceptance.table([0, 0.1, 0.2], [1, 0.5, 0], "profile.csv"),
        omma.Acceptance.table_2d([-0.1, 0, 0.1], [-0.2, 0.2], np.eye(3)[:2]),
        None,
    ]
    types = [
        omma.receptors.ReceptorType(
            "green", peak_wavelength_nm=540, microvillus_angle_rad=0.1,
            polarisation_sensitivity=2, absorption_per_m=5000, length_m=2e-4, right_rad=0.01,
            up_rad=0.02, acceptance=kinds[0],
        ),
        omma.receptors.ReceptorType("dim", wavelength_nm=[300, 400, 500], sensitivity=[0, 1, 0]),
    ]  # fmt: skip
    numbers = np.arange(count, dtype=np.float64)
    numbers[2] = np.nan
    return plain.replace(
        path=path,
        focal_offset_m=1e-5,
        eye_id=np.arange(count) % 2,
        up=plain.axis[:, [1, 2, 0]],
        facet_diameter_m=2e-5,
        aperture_diameter_m=np.linspace(0, 1e-4, count),
        acceptance_angle_rad=np.full(count, 0.07),
        acceptance=kinds,
        receptor_types=types,
        receptors=[[0, 1], [], [1], [0], [0, 0], [1]],
        columns={"depth": numbers, "region": list("abcdef")},
    )


TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
SPLAT = [(0, 0, -1)], [(0.1, 0.2, 0.3)], [(0, 0, 0, 1)], [0.5], np.zeros((1, 4, 3))
LENSES = np.stack(np.meshgrid(*[np.arange(4) * 2e-5] * 2, [0.0]), axis=-1).reshape(-1, 3)
BULGING = LENSES - [3e-5, 3e-5, 0]
BULGING[:, 2] = -np.sqrt(1e-6 - BULGING[:, 0] ** 2 - BULGING[:, 1] ** 2)


@pytest.fixture(scope="module")
def examples(files, tmp_path_factory):
    """One of each public class, by its full name."""
    folder = tmp_path_factory.mktemp("values")
    scene = omma.load_scene(files / "scene.gltf")
    eye = make_eye(40)
    renderer = omma.Renderer(scene, eye, omma.ToError(0.1))
    seven_columns, seven = omma.columns.columns_of_eye(omma.species.drosophila().eye)
    seven_columns, seven = (
        seven_columns.chosen(np.arange(7)), omma.species.drosophila().eye.take(seven[:7])
    )  # fmt: skip
    kind = omma.receptors.OmmatidiumType("pale", tuple(all_round_eye().receptor_types), 0.4)
    old = folder / "old.eye"
    np.savetxt(old, np.c_[eye.position_m * 1e3, eye.axis, np.full(40, 0.1)], fmt="%.9g")
    angles = omma.eye.generate_eye(200)
    oda = omma.eye.scans.ImportedEye(eye, ("one", "two"))
    pose = omma.look_at((0, 1, 0), (0, 1, -5))
    capture = omma.scene.CaptureCameras([[1.0, 2.0, 3.0]], [np.eye(3)], names=("a.jpg",))
    return {
        "Acceptance": all_round_eye().acceptances[3],
        "Background": omma.Background.constant((0.1, 0.2, 0.3)),
        "Error": omma.Error("eye: expected one, found none"),
        "Eye": all_round_eye("head.eye"),
        "Fixed": omma.Fixed(3),
        "Renderer": renderer,
        "Scene": scene,
        "Shared": omma.Shared(3),
        "ToError": omma.ToError(0.1, most=64),
        "World": renderer.world,
        "datasets.Job": (job := omma.datasets.load_job(write_job(folder / "job"))),
        "datasets.RunReport": omma.datasets.run(job),
        "datasets.VerifyReport": omma.datasets.verify(job.store),
        "datasets.Views": omma.datasets.open_views(job.store),
        "eye.AcuteZone": omma.eye.AcuteZone(0.1, 0.2, 0.3, 2.0, band=True),
        "eye.ConvertedEye": omma.eye.convert_eye(old),
        "eye.EyeMeasures": omma.eye.measure_eye(eye),
        "eye.hexagonal.HexagonalCoordinates": omma.eye.hexagonal_coordinates(angles),
        "eye.scans.ImportedEye": oda,
        "eye.lattice.Lattice": omma.eye.lay_directions(0.4),
        "eye.lattice.LatticeCheck": omma.eye.lattice.check_lattice(angles.axis, 0.1),
        "eye.scans.LensConeEye": omma.eye.scans.import_lens_cone(BULGING, 0.95 * BULGING, 1.0),
        "eye.superposition.Wiring": omma.eye.superposition.Wiring(
            [0, 1, 3], [4, 5, 6], [1.0, 0.5, 0.5]
        ),
        "columns.Columns": omma.columns.Columns([0, 1], [0, 1], [1, 1], np.eye(3)[:2]),
        "columns.ColumnRenderer": (
            columns := omma.columns.ColumnRenderer(scene, seven, seven_columns)
        ),
        "columns.PhotoreceptorTable": columns.render(np.eye(4)),
        "colour_vision.Detection": omma.colour_vision.Detection(1.0, 0.1, 0.02),
        "colour_vision.DiscTarget": omma.colour_vision.DiscTarget(0.02, 0.1, 0.3),
        "colour_vision.Observer": omma.colour_vision.Observer("colour", noise=(0.1, 0.2)),
        "colour_vision.SceneTarget": omma.colour_vision.SceneTarget(scene, scene, 0.1),
        "colour_vision.TetrahedralColour": omma.colour_vision.tetrahedron([1.0, 2.0, 3.0, 4.0]),
        "gym.Loop": omma.gym.Loop(renderer, begun, begun, begun, None),
        "gym.Moment": omma.gym.Moment(1, 0, 2, np.eye(4), np.ones((3, 2), np.float32), 4),
        "job.AllCamerasReport": (
            report := omma.job.render_all_cameras(
                files / "scene.gltf", folder, omma.Fixed(1), width=8
            )
        ),
        "job.CameraReport": report.cameras[0],
        "job.RenderReport": omma.render_file(
            files / "scene.gltf",
            folder / "o.npy",
            omma.Fixed(1),
            eyes=files / "bug.eye",
            position=(0, 1, 0),
        ),
        "light.Bands": omma.light.Bands.equal(),
        "light.CloudShadow": omma.light.CloudShadow([[0.0, 1.0], [1.0, 0.0]], 50.0, 800.0),
        "light.Disc": omma.light.Disc((0, 1, 0), 0.004, [1.0, 2.0], [0.5, 0.6]),
        "light.Light": omma.light.uniform_sky(2.0).turned(10).scaled(3),
        "receptors.BandError": omma.receptors.band_error(
            omma.light.uniform_sky(), omma.receptors.honeybee_ommatidia()[0].receptors
        ),
        "light.Spectrum": omma.light.Spectrum([300, 700], [0.1, 0.2]),
        "photoreceptors.EventSensor": (sensor := omma.photoreceptors.EventSensor([0.1, 0.2])),
        "photoreceptors.EventState": sensor.step(None, np.ones(2), 0.5)[0],
        "photoreceptors.FrameFilter": omma.photoreceptors.FrameFilter(
            omma.photoreceptors.ImpulseResponse.box(0.01), 100.0
        ),
        "photoreceptors.VanHaterenSnippe": omma.photoreceptors.VanHaterenSnippe(100.0),
        "photoreceptors.ImpulseResponse": omma.photoreceptors.ImpulseResponse.table(
            [0, 0.01, 0.02, 0.03], [0, 2, -0.5, 0]
        ),
        "light.MoonPosition": omma.light.MoonPosition(135.0, 30.0, 60.0, 0.75),
        "light.SunPosition": omma.light.SunPosition(135.0, 30.0),
        "motion.DetectorArray": omma.motion.detector_array(angles, 0.035, 500),
        "motion.DetectorState": omma.motion.detector_array(angles, 0.035, 500).step(
            None, np.ones(200)
        )[0],
        "motion.LoomingCells": omma.motion.looming_cells(angles, [[0, 0, -1]]),
        "motion.GroundAt": omma.motion.ground_at(
            omma.scene.plane(), omma.look_at((0, 1, 0), (0, 1, -1))
        ),
        "motion.Track": omma.motion.Track(np.array([(0, 0), (0, -1)])).at_speed(0.1, step_s=1),
        "receptors.OmmatidiumType": kind,
        "receptors.ReceptorType": all_round_eye().receptor_types[0],
        "Population": omma.Population(renderer.world, [eye, eye]),
        "rendering.Jacobian": omma.Renderer(renderer.world, eye, omma.Fixed(8)).jacobian(pose),
        "rendering.CubeFaces": omma.rendering.CubeFaces(8),
        "rendering.Equirectangular": omma.rendering.Equirectangular(9, 18),
        "rendering.Fisheye": omma.rendering.Fisheye(16, 16, 170, "equisolid"),
        "rendering.PanoramaView": omma.rendering.PanoramaView(
            eye, omma.rendering.Equirectangular(9, 18)
        ),
        "rendering.GroundTruth": renderer.ground_truth(
            pose, shares=[0], capture_cameras=capture
        ),
        "rendering.UltravioletDependence": omma.rendering.UltravioletDependence(
            ("grass",),
            np.zeros((1, 2, 3), np.float32),
            np.ones((1, 2, 3), np.float32),
            np.zeros((1, 2, 3), np.float32),
        ),
        "rendering.Settings": omma.rendering.Settings(omma.Shared(4), seed=7),
        "rendering.SamplingReport": renderer.render(pose, report=True)[1],
        "scene.Animation": (swinging := swinging_box(folder / "swing.gltf")).animations[0],
        "scene.Rig": swinging.rig,
        "scene.Bake": omma.scene.Bake(cell_m=0.5, paths=64, cache=False),
        "scene.BakedInfo": omma.scene.BakedInfo(9, 0.5, 32, 0.1, 0.3, 1152, 3, 0.25, True),
        "scene.Camera": scene.cameras[1],
        "scene.CaptureCameras": capture,
        "scene.Device": omma.scene.Device("2 threads", ("embree", "portable")),
        "scene.BoundaryTable": omma.scene.BoundaryTable(
            [300, 700], np.tile([0.5, 0.1, -0.4], (2, 3, 1))
        ),
        "scene.LayerStack": omma.scene.LayerStack([(100.0, 1.5)], 1.5 + 0.1j, 0.02),
        "scene.ExtraReflectance": omma.scene.ExtraReflectance(
            0, [omma.light.Spectrum([300, 400], [0.1, 0.2])]
        ),
        "scene.HitBox": omma.scene.HitBox("nest", *TRIANGLE),
        "scene.Image": omma.scene.Image(np.zeros((2, 3, 3), np.uint8), "black"),
        "scene.Instance": scene.instances[0],
        "scene.Material": omma.scene.Material("paper", unlit=True),
        "scene.MaterialFact": omma.scene.natural_materials()["sand"].facts[0],
        "scene.Mesh": omma.scene.Mesh(*TRIANGLE),
        "scene.PointCloud": omma.scene.PointCloud([[1.0, 2.0, 3.0]], labels=[2]),
        "scene.PunctualLight": omma.scene.PunctualLight("lamp", type="spot"),
        "scene.NaturalMaterial": omma.scene.natural_materials()["grass blade"],
        "scene.SplatCloud": omma.scene.SplatCloud(*SPLAT, name="shrub"),
        "scene.Texture": omma.scene.Texture(0),
        "scene.TextureUse": omma.scene.TextureUse(0),
        "scene.WorldInstance": renderer.world.instances[0],
        "species.Fact": omma.species.facts()[0],
        "species.Source": omma.species.sources()[0],
        "species.Species": omma.species.Species("bug", "Bugs bugs", eye, omma.species.facts()[:9]),
        "stimuli.Bar": omma.stimuli.Bar(12.0, bar=0.9),
        "stimuli.DrumGrating": omma.stimuli.DrumGrating(15.0, 3.0, "square"),
        "stimuli.LedArena": omma.stimuli.LedArena(omma.stimuli.Bar(), 0.2, refresh_hz=50.0),
        "stimuli.LoomingDisc": omma.stimuli.LoomingDisc(0.02, 0.5),
        "stimuli.NoisePanorama": omma.stimuli.NoisePanorama(1.2, pixel_deg=3.0),
        "stimuli.PlaneGrating": omma.stimuli.PlaneGrating(0.2, center_m=(0, -1, 0)),
        "stimuli.RandomDots": omma.stimuli.RandomDots(10, seed=3),
        "stimuli.SphereGrating": omma.stimuli.SphereGrating(15.0, direction_deg=20.0),
        "stimuli.Starfield": omma.stimuli.Starfield(10, velocity_m_s=(1, 0, 0)),
        "stimuli.Target": omma.stimuli.Target(2.0, [0, 1], [-10, 10], [0, 5]),
        "study.Box": omma.study.Box((0, 0, 0), (1, 1, 1)),
        "study.Cylinder": omma.study.Cylinder((0, 0, 0), 1.0, 2.0),
        "study.Method": omma.study.Method("pillbox", "random"),
        "study.MinimumSamples": omma.study.minimum_samples(
            scene, pose[None], fraction=0.5, poses=1, method=omma.study.Method(points="random"),
        ),
        "view.HeadPose": (there := omma.view.HeadPose((0.1, 0.2, 0.3), 4.0, -5.0, 6.0)),
        "view.Look": (look := omma.view.Look(there, 16, 1.5, 0.25)),
        "view.Seen": omma.view.Seen(look, 16, True, *np.ones((2, 40, 3)), None, None, 0.1),
        "study.SpeedTest": omma.study.measure_speed(scene, eye, pose, [1], frames=1, warm_up_s=0),
        # Not public themselves, but what public functions return.
        "sphere()": omma.eye.surfaces.sphere(1e-3),
        "mesh_surface()": omma.eye.surfaces.mesh_surface(
            [[0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]],
            [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ),
        "EyeMeasures.field": omma.eye.measure_eye(eye).field,
    }  # fmt: skip


# A world and what renders it are there once, as are filters with a state; an exception is what
# Python makes of it.
BY_IDENTITY = {
    "World", "Renderer", "Error", "gym.Loop", "rendering.PanoramaView",
    "photoreceptors.FrameFilter", "photoreceptors.VanHaterenSnippe", "columns.ColumnRenderer",
    "Population",
}  # fmt: skip
UNHASHABLE = {
    "colour_vision.TetrahedralColour",
    "columns.Columns", "columns.PhotoreceptorTable", "datasets.Job", "datasets.Views", "gym.Moment",
    "eye.EyeMeasures", "eye.hexagonal.HexagonalCoordinates", "eye.lattice.Lattice",
    "eye.lattice.LatticeCheck", "eye.scans.LensConeEye", "eye.superposition.Wiring",
    "light.Bands", "light.CloudShadow", "light.Disc", "light.Light",
    "receptors.BandError", "stimuli.Target",
    "motion.DetectorArray", "motion.DetectorState", "motion.LoomingCells",
    "motion.GroundAt", "motion.Track", "photoreceptors.EventSensor", "photoreceptors.EventState",
    "rendering.GroundTruth", "rendering.Jacobian",
    "rendering.UltravioletDependence",
    "rendering.SamplingReport", "study.MinimumSamples", "study.SpeedTest",
    "scene.CaptureCameras", "scene.NaturalMaterial", "scene.PointCloud", "view.Seen",
    "mesh_surface()", "EyeMeasures.field",
}  # fmt: skip
# Made of another package's simulation (tests/python/test_mujoco_retina.py); a server's page
# (tests/python/test_view_window.py); memory of a graphics card (tests/python/test_card_arrays.py).
ELSEWHERE = {"mujoco.FlyRetina", "mujoco.PictureRetina", "view.Window", "rendering.CardArray"}
CLASSES = sorted(
    {
        f"{subpackage}.{name}".strip(".")
        for subpackage, name, thing in public_things()
        if inspect.isclass(thing)
    }
    - ELSEWHERE
)
NAMES = [*CLASSES, "sphere()", "mesh_surface()", "EyeMeasures.field"]


@pytest.mark.parametrize("name", NAMES)
def test_one_of_each(examples, name):
    value = examples[name]
    made = [pickle.loads(pickle.dumps(value, protocol)) for protocol in (2, 4, 5)]
    made += [copy.copy(value), copy.deepcopy(value)]
    for other in made:
        assert type(other) is type(value)
        if name not in BY_IDENTITY:
            assert other == value
            assert repr(other) == repr(value)
    assert value != "something else"
    assert value != 1
    assert operator.ne(value, None)
    if name in UNHASHABLE:
        with pytest.raises(TypeError, match=r"has no hash, as its field|unhashable"):
            hash(value)
    elif name not in BY_IDENTITY:
        assert {hash(other) for other in made} == {hash(value)}
    # A scene's has the path, which pytest makes long; an arena's has all of what it shows.
    if name not in ("Scene", "stimuli.LedArena"):
        assert len(repr(value).replace(str(Path.cwd()), "")) < 230
    assert "\n" not in repr(value)


def test_there_is_one_of_each(examples):
    assert set(examples) == set(NAMES)


def test_values_of_other_fields_are_not_equal(examples):
    for name, value in examples.items():
        if not dataclasses.is_dataclass(value):
            continue
        for field in dataclasses.fields(value):
            other = copy.copy(value)
            vars(other)[field.name] = "another"
            assert other != value, f"{name}.{field.name}"


def fields_of(eye):
    """What was given to make an eye, as `replace` takes it back."""
    first = eye.first_receptor
    return {
        "position_m": eye.position_m,
        "axis": eye.axis,
        "acceptance_angle_rad": eye.acceptance_angle_rad,
        "focal_offset_m": eye.focal_offset_m,
        "eye_id": eye.eye_id,
        "up": eye.up,
        "facet_diameter_m": eye.facet_diameter_m,
        "aperture_diameter_m": eye.aperture_diameter_m,
        "acceptance": [eye.acceptance(i) for i in range(len(eye))],
        "receptor_types": eye.receptor_types,
        "receptors": [eye.receptor_type[a:b].tolist() for a, b in zip(first[:-1], first[1:])],
        "columns": eye.columns,
        "path": eye.path,
    }


def test_every_field_of_an_eye_survives():
    """A field that is added to an eye and forgotten here fails."""
    eye = all_round_eye("head.eye")
    again = pickle.loads(pickle.dumps(eye))
    stub = (Path(omma.__file__).parent / "_core.pyi").read_text()
    arguments = stub.split("class Eye:")[1].split("def __init__(self, ")[1].split(") -> None")[0]
    names = [part.split(":")[0].strip() for part in arguments.split(", ") if ": " in part]
    found, expected = fields_of(again), fields_of(eye)
    assert set(found) == set(names)
    for name in found:
        assert same(found[name], expected[name]), name
    for member in ("right", "acceptance_of", "first_receptor", "receptor_type"):
        assert (getattr(again, member) == getattr(eye, member)).all()
    assert again.acceptances == eye.acceptances
    # And each of them counts.
    plain = make_eye(6, seed=2)
    for name, value in fields_of(plain).items():
        if name in ("receptor_types", "receptors"):
            changed = eye.replace(receptors=[[]] * 6)
        elif name == "acceptance":
            changed = eye.replace(acceptance=value)
        else:
            changed = eye.replace(**{name: value})
        assert (changed == eye) == (name == "path"), name


def test_where_an_eye_came_from_plays_no_part(tmp_path):
    eye = omma.eye.generate_eye(100)
    omma.save_eye(tmp_path / "one.eye", eye)
    loaded = omma.load_eye(tmp_path / "one.eye")
    (tmp_path / "one.eye").rename(tmp_path / "two.eye")
    other = omma.load_eye(tmp_path / "two.eye")
    assert loaded == other
    assert hash(loaded) == hash(other)
    assert loaded.path != other.path
    assert pickle.loads(pickle.dumps(other)).path == other.path


def test_a_path_that_is_no_text():
    eye = make_eye(3).replace(path=b"\xff.eye")
    assert pickle.loads(pickle.dumps(eye)).path == eye.path == "\udcff.eye"


@pytest.mark.parametrize("name", ["Eye", "Acceptance", "receptors.ReceptorType"])
def test_pickles_of_another_version_are_refused(examples, name):
    value = examples[name]
    kind = type(value)
    _, state = value.__getstate__()
    for other, found in (((99, state), "99"), ((), "nothing"), ((1, (1, 2)), "what is none")):
        with pytest.raises(omma.Error, match=f"pickle of {kind.__name__}.*found {found}"):
            kind.__new__(kind).__setstate__(other)


def test_results_of_another_version_are_refused():
    zone = omma.eye.AcuteZone(0, 0, 1, 2)
    state = zone.__getstate__()
    del state["band"]
    other = object.__new__(omma.eye.AcuteZone)
    with pytest.raises(omma.Error, match="pickle of AcuteZone: expected the fields azimuth_rad"):
        other.__setstate__(state)


def test_what_is_not_known_equals_what_is_not_known():
    @value_class
    @dataclasses.dataclass(frozen=True, eq=False, repr=False)
    class Numbers:
        one: float
        many: np.ndarray
        names: dict = dataclasses.field(default_factory=dict)

    nan = float("nan")
    assert Numbers(nan, np.array([1, nan])) == Numbers(float("nan"), np.array([1, nan]))
    assert Numbers(nan, np.array([1, nan])) != Numbers(nan, np.array([nan, 1]))
    assert Numbers(1.0, np.array(["a"])) == Numbers(1.0, np.array(["a"]))
    assert Numbers(1.0, np.zeros(2)) != Numbers(1.0, np.zeros((2, 1)))
    assert Numbers(1.0, np.zeros(0), {"a": nan}) == Numbers(1.0, np.zeros(0), {"a": nan})
    assert repr(Numbers(np.float64(0.5), np.zeros((2, 3)))) == (
        "Numbers(one=0.5, many=<float64 (2, 3)>, names={})"
    )

    @value_class
    @dataclasses.dataclass(frozen=True, eq=False, repr=False)
    class Frozen:
        one: float
        more: tuple

    assert hash(Frozen(nan, (nan, 1))) == hash(Frozen(float("nan"), (float("nan"), 1)))


@pytest.mark.parametrize(
    "value",
    [
        omma.photoreceptors.EventSensor(0.2, 0.3, refractory_s=0.001),
        omma.stimuli.LoomingDisc(0.05, 5.0),
        omma.stimuli.Target(2.0, [0, 1], [-20, 20], [0, 0]),
        omma.stimuli.LedArena(omma.stimuli.DrumGrating(30, 5), 0.2),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_an_experiment_writes_down_is_printed_in_full(value):
    """Its defaults too, which another version may change; typed in, it is the same again."""
    for field in dataclasses.fields(value):
        assert f"{field.name}=" in repr(value)
    stimuli = {one: getattr(omma.stimuli, one) for one in omma.stimuli.__all__}
    made = eval(repr(value), {"EventSensor": omma.photoreceptors.EventSensor, **stimuli})
    assert made == value


def test_many_numbers_are_not_printed():
    many = omma.photoreceptors.EventSensor(np.full(100, 0.2))
    assert repr(many).startswith("EventSensor(on_threshold=<float64 (100,)>, off_threshold=None")


def test_a_long_result_prints_as_a_line():
    notes = tuple(f"note {i}" for i in range(100))
    text = repr(omma.eye.scans.ImportedEye(make_eye(3), notes))
    assert text.endswith("notes=('note 0', 'note 1', 'note 2', ... 100 in all))")


def test_an_eye_shows_its_map():
    left, right = make_eye(9000, seed=1), make_eye(6500, seed=2, acceptance_deg=2)
    head = omma.eye.merge_eyes([left, right]).replace(path="a <b> & c.eye")
    text = head._repr_html_()
    assert len(text) < 200_000
    caption, picture = text.split("</div>")
    assert "15,500 ommatidia; eye 0: 9,000, eye 1: 6,500; 12,000 of them drawn" in caption
    assert "a &lt;b&gt; &amp; c.eye" in caption
    drawn = ElementTree.fromstring(picture)
    paths = [p for p in drawn.iter("{http://www.w3.org/2000/svg}path") if p.get("d").endswith("h0")]
    assert sum(p.get("d").count("h0") for p in paths) == 12_000
    texts = [t.text for t in drawn.iter("{http://www.w3.org/2000/svg}text")]
    assert {"5°", "2°", "elevation"} <= set(texts)


@pytest.mark.parametrize(
    ("axis", "side"), [((1, 0, 0), "right"), ((-1, 0, 0), "left"), ((0, 1, 0), "top")]
)
def test_an_eye_s_map_has_right_on_the_right(axis, side):
    text = omma.Eye([[0, 0, 0]], [axis], 0.1)._repr_html_()
    drawn = ElementTree.fromstring(text.split("</div>")[1])
    paths = [p.get("d") for p in drawn.iter("{http://www.w3.org/2000/svg}path")]
    x, y = map(float, next(d for d in paths if d.endswith("h0"))[1:-2].split())
    texts = {t.text: t for t in drawn.iter("{http://www.w3.org/2000/svg}text")}
    ahead = float(texts["azimuth, to the right of ahead"].get("x"))
    assert {"right": x > ahead, "left": x < ahead, "top": y < 20}[side]


def test_worlds_and_renderers_show_a_table(examples):
    assert "<td style='text-align:left'>plain, insect</td>" in examples["World"]._repr_html_()
    text = examples["Renderer"]._repr_html_()
    ElementTree.fromstring(f"<all>{text}</all>")
    assert "40 ommatidia" in text


def test_ground_truth_settings_and_populations_show_a_table(examples):
    renderer = examples["Renderer"].with_eye(make_eye(40), omma.Fixed(2))
    truth = renderer.ground_truth(np.eye(4), shares=[0])
    truth = dataclasses.replace(truth, names=("<b> & c",))
    population = omma.Population(renderer.world, [make_eye(20), make_eye(30)], omma.Fixed(2))
    tables = [one._repr_html_() for one in (truth, renderer.settings, population)]
    for text in tables:
        ElementTree.fromstring(f"<all>{text}</all>")
    assert "&lt;float32 (1, 40)&gt;" in tables[0]
    assert "&lt;b&gt; &amp; c" in tables[0]
    assert "standard_error" not in tables[0]
    assert "low_discrepancy" in tables[1]
    assert "50, 20 to 30 of each eye" in tables[2]


def test_lights_and_animals_show_a_table():
    few = omma.light.Bands.equal(4)
    text = omma.light.clear_sky(30, sun_azimuth_deg=135, bands=few).turned(10)._repr_html_()
    ElementTree.fromstring(f"<all>{text}</all>")
    assert "at azimuth 145°, elevation 30°, 0.533° across" in text
    assert "directions in each half, polarised" in text
    text = omma.light.uniform_sky(1e17, bands=few)._repr_html_()
    # π times the radiance, in bands of 400 nm together; nothing from discs.
    assert "1.26e+20 photons m⁻² s⁻¹ from the sky, 0 from discs" in text
    bee = omma.species.honeybee_worker()
    text = bee._repr_html_()
    assert "ultraviolet 344 nm, blue 436 nm, green 544 nm" in text
    assert "10,760" in text
    assert bee.eye._repr_html_() in text
    assert "none known" in omma.species.holcocephala()._repr_html_()


def test_a_receptor_type_says_what_it_is():
    kind = omma.receptors.ReceptorType
    assert repr(kind("green", peak_wavelength_nm=544)) == (
        "<omma.receptors.ReceptorType 'green', peak 544 nm>"
    )
    assert repr(
        kind(
            "rim", wavelength_nm=[300, 400], sensitivity=[1, 2], absorption_per_m=6700,
            length_m=320e-6, polarisation_sensitivity=6.3, microvillus_angle_rad=np.pi / 2,
            right_rad=np.radians(1.5), acceptance=omma.Acceptance.pillbox(0.05),
        )
    ) == (
        "<omma.receptors.ReceptorType 'rim', table of 300 to 400 nm, rhabdom 320 um long, "
        "absorbing 0.0067 per um, polarisation sensitivity 6.3, microvilli at 90 deg, looks 1.5 "
        "deg right and 0 deg up, an acceptance of its own>"
    )  # fmt: skip
