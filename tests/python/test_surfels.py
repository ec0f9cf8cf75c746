"""Points as discs: a plane and a sphere against the surfaces themselves, without holes."""

import warnings

import numpy as np
import pytest
from point_clouds import write_las, write_ply
from scipy.spatial import Voronoi

import omma
from omma.eye.field import sphere_directions
from omma.scene import Instance, PointCloud, merge_scenes, surfels
from omma.scene.surfel_frames import frames_of

RNG = np.random.default_rng(8)
SPACING = 1e-3
HOLE = omma.Background.constant((100.0, 0.0, 100.0))
DOWN = sphere_directions(4000)
DOWN = DOWN[DOWN[:, 1] < -0.03]  # down to 2 degrees below the horizon
LOOKER = omma.Eye(np.zeros((len(DOWN), 3)), DOWN, np.zeros(len(DOWN)))


def plane_points(half, scatter=0.0):
    """One a square millimetre on average, at random, over a square of y = 0."""
    count = round((2 * half / SPACING) ** 2)
    places = RNG.uniform(-half, half, (count, 3))
    places[:, 1] = RNG.normal(0, scatter, count) if scatter else 0
    return places


def sphere_points(radius):
    towards = RNG.normal(size=(round(4 * np.pi * (radius / SPACING) ** 2), 3))
    return radius * towards / np.linalg.norm(towards, axis=1, keepdims=True)


@pytest.fixture(scope="module")
def plane_cloud():
    places = plane_points(0.15)
    return PointCloud(places, colors=pattern(places))


@pytest.fixture(scope="module")
def plane(plane_cloud):
    return surfels(plane_cloud)


def pattern(places):
    """Linear, with waves of 2 cm, far above the spacing."""
    wave = np.sin(places * 2 * np.pi / 0.02)
    return 0.5 + 0.4 * wave[:, [0, 2, 0]] * wave[:, [2, 0, 2]]


def rays_from(height, poses, rng):
    """Poses so high over the middle, and where each of the looker's rays meets y = 0."""
    at = np.tile(np.eye(4), (poses, 1, 1))
    at[:, :3, 3] = rng.uniform(-0.04, 0.04, (poses, 3))
    at[:, 1, 3] = height
    met = at[:, None, :3, 3] + height / -DOWN[:, 1:2] * DOWN
    return at, met, (np.abs(met) < 0.1).all(axis=2)


@pytest.mark.parametrize("height", [1e-3, 3e-3, 10e-3, 30e-3])
def test_no_ray_passes_a_plane(plane, height):
    """From 1 mm above it, and each ray sees the colour that is there but for the spacing."""
    at, met, inside = rays_from(height, 20, np.random.default_rng(1))
    seen = omma.Renderer(plane.replace(background=HOLE), LOOKER, omma.Fixed(1)).render(at)
    assert inside.sum() > 15_000
    assert seen[inside].max() < 1
    # Of discs that overlap in a plane any may be met: a place in a square of half side 1.1 mm is
    # 0.9 mm from its middle (rms), and larger ones are met more often. The rms slope of waves of
    # 20 mm and 0.4 in any direction is 0.4 * 2 pi / 20 / 2 a millimetre, the largest twice that.
    off = (seen - pattern(met.reshape(-1, 3)).reshape(seen.shape))[inside]
    slope = 0.4 * 2 * np.pi / 20
    assert np.sqrt((off**2).mean()) < slope / 2 * 1.3
    assert np.abs(off).max() < slope * 1.1 * np.sqrt(2) * 2.3  # no disc is larger than 2.3 mm
    assert abs(off.mean()) < 0.01


def test_too_small_discs_have_holes(plane_cloud):
    """So that the tests above can fail."""
    scene = surfels(plane_cloud, overlap=0.7).replace(background=HOLE)
    at, _, inside = rays_from(3e-3, 20, np.random.default_rng(1))
    seen = omma.Renderer(scene, LOOKER, omma.Fixed(1)).render(at)
    assert (seen[inside].max(axis=-1) > 2).mean() > 0.005


@pytest.mark.filterwarnings("ignore:.*has no colours")
def test_scattered_measurements_have_hardly_any_holes():
    """A fifth of the spacing off the surface: discs are tilted, so that rays pass between them."""
    scene = surfels(PointCloud(plane_points(0.15, 0.2e-3), intensity=np.ones(90_000)))
    for height in (1e-3, 30e-3):
        at, _, inside = rays_from(height, 20, np.random.default_rng(1))
        seen = omma.Renderer(scene.replace(background=HOLE), LOOKER, omma.Fixed(1)).render(at)
        assert (seen[inside].max(axis=-1) > 2).mean() < 1e-3


@pytest.mark.filterwarnings("ignore:.*has no colours")
def test_a_sphere_is_seen_like_the_sphere():
    """Where rays meet it, and that none goes through."""
    radius = 0.03
    scene = surfels(PointCloud(sphere_points(radius), colors=None))
    rng = np.random.default_rng(2)
    axis = sphere_directions(3000)
    eye = omma.Eye(np.zeros((len(axis), 3)), axis, np.zeros(len(axis)))
    for above in (1e-3, 10e-3, 30e-3):
        out = rng.normal(size=(30, 3))
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        poses = np.array([omma.look_at(one * (radius + above), (0, 0, 0)) for one in out])
        found = omma.Renderer(scene, eye, omma.Fixed(1)).ground_truth(poses).distance_m
        # The same rays and the sphere itself: |o + t d| = radius.
        d = np.einsum("pij,nj->pni", poses[:, :3, :3], axis)
        b = np.einsum("pni,pi->pn", d, poses[:, :3, 3])
        root = b**2 - (radius + above) ** 2 + radius**2
        meets = (b < 0) & (root > 0)
        assert np.isfinite(found[meets]).all()
        steep = meets & (np.sqrt(np.maximum(root, 0)) > radius / 2)
        off = (found - (-b - np.sqrt(np.maximum(root, 0))))[steep]
        # The corners of a square in a tangent plane, 1.1 * sqrt(2) mm from its middle, stand
        # 0.04 mm off the sphere; the outermost of overlapping ones is met, by rays at up to 60
        # degrees up to twice as far off. Squares of 2.3 mm, the largest, 5 times that.
        assert np.abs(off).mean() < 0.08e-3
        assert np.abs(off).max() < 0.4e-3
        # Beside it nothing is seen, but for discs' corners at the rim.
        beside = ~meets & ~((b < 0) & (root > -((4 * SPACING) ** 2)))
        assert not np.isfinite(found[beside]).any()


def test_discs_reach_to_the_corners_of_voronoi_cells():
    """Another library's cells."""
    places = plane_points(0.05)
    found = frames_of(places.astype(np.float32), None, None)
    assert np.abs(found.normals[:, 1]).min() > 0.999999
    cells = Voronoi(places[:, [0, 2]])
    for i in np.flatnonzero((np.abs(places) < 0.04).all(axis=1)):
        corners = cells.vertices[cells.regions[cells.point_region[i]]]
        farthest = np.linalg.norm(corners - places[i, [0, 2]], axis=1).max()
        assert found.radius_m[i] > farthest * (1 - 1e-4)
    inner = (np.abs(places) < 0.04).all(axis=1)
    # Random points of density 1 have cells of which the farthest corner is 0.98 away on average.
    assert found.radius_m[inner].mean() == pytest.approx(0.98e-3, rel=0.03)


def test_normals_of_a_sphere_look_to_the_scanner():
    places = sphere_points(0.03).astype(np.float32)
    found = frames_of(places, None, np.array([[0.0, 0.0, 0.0]]))
    turned_in = (found.normals * -places / np.linalg.norm(places, axis=1, keepdims=True)).sum(
        axis=1
    )
    # Neighbours span 2 mm of a sphere of 30 mm and are uneven: some degrees.
    assert turned_in.min() > np.cos(np.radians(6))
    assert (frames_of(places, None, None).normals[:, 1] > -1e-2).all()


def test_a_point_off_the_surface_is_no_large_disc():
    places = np.vstack([plane_points(0.03), [[0, 0.2, 0]]]).astype(np.float32)
    assert frames_of(places, None, None).radius_m[-1] < 6e-3


def test_both_sides_are_seen(plane):
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], [0.0])
    for above in (0.02, -0.02):
        pose = omma.look_at((0, above, 0), (0, 0, 0), up=(0, 0, 1))
        assert omma.Renderer(plane, eye, omma.Fixed(1)).ground_truth(pose).distance_m == (
            pytest.approx(0.02, abs=1e-6)
        )


def test_lit_ground_is_as_bright_as_a_plane_of_the_material():
    """Grass at noon, of points with labels; from any height, but for rays at other directions."""
    places = plane_points(0.15)
    cloud = PointCloud(places, labels=np.full(len(places), 2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        discs = surfels(cloud, materials={2: "dark soil"})
    soil = omma.scene.natural_material("dark soil")
    flat = omma.scene.plane((0.6, 0.6))
    flat = flat.replace(
        materials=[soil.replace(double_sided=True)],
        meshes=[one.replace(material=0) for one in flat.meshes],
    )
    light = omma.light.clear_sky(50, sun_azimuth_deg=30)
    at, _, inside = rays_from(10e-3, 3, np.random.default_rng(1))
    seen = []
    for scene in (discs, flat):
        world = omma.World(scene, light=light)
        seen.append(omma.Renderer(world, LOOKER, omma.Fixed(16)).render(at))
    assert seen[1][inside].min() > 0
    assert seen[0][inside] == pytest.approx(seen[1][inside], rel=2e-3)


def test_labels_without_material_keep_their_colours():
    places = plane_points(0.01)
    labels = np.where(places[:, 0] < 0, 2, 6)
    labels[:5] = 1
    cloud = PointCloud(places, labels=labels, colors=np.full((len(places), 3), 0.25))
    with pytest.warns(UserWarning, match=r"without a material .*: 1 \(5\), 6 \(\d+\)"):
        scene = surfels(cloud, materials={2: omma.scene.Material("red", base_color=(1, 0, 0))})
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], [0.0])
    poses = [omma.look_at((x, 0.01, 0), (x, 0, 0), up=(0, 0, 1)) for x in (-0.006, 0.006)]
    found = omma.Renderer(scene, eye, omma.Fixed(1)).render(np.array(poses))[:, 0]
    assert found == pytest.approx(np.array([[1, 0, 0], [0.25, 0.25, 0.25]]))
    with pytest.warns(UserWarning, match="there are no points of the labels 9"):
        surfels(cloud, materials={1: "rock", 2: "rock", 6: "rock", 9: "rock"})
    with pytest.raises(omma.Error, match="materials: expected a cloud with labels"):
        surfels(PointCloud(places), materials={2: "rock"})
    with pytest.raises(omma.Error, match="name: expected one of"):
        surfels(cloud, materials={2: "soil"})


def test_without_colours_intensities_are_seen_else_grey():
    places = plane_points(0.01)
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], [0.0])
    pose = omma.look_at((0, 0.01, 0), (0, 0, 0), up=(0, 0, 1))
    for given, grey, words in (
        ({"intensity": np.where(np.arange(len(places)) % 10, 300.0, 900.0)}, (1 / 3, 1), "900 and"),
        ({}, (0.5,), "no colours and no intensities: its points are grey, 0.5"),
        ({"intensity": np.zeros(len(places))}, (0.5,), "its points are grey"),
    ):
        with pytest.warns(UserWarning, match=words):
            scene = surfels(PointCloud(places, **given))
        found = omma.Renderer(scene, eye, omma.Fixed(1)).render(pose)[0, 0]
        assert min(abs(found[0] - one) for one in grey) < 1e-6


def test_normals_and_radii_given():
    places = plane_points(0.01)
    scene = surfels(
        PointCloud(places[:3], colors=np.ones((3, 3))), normals=[[0, 0, 5]] * 3, radius_m=2e-3
    )
    corners = scene.meshes[0].positions_m.reshape(3, 4, 3)
    assert np.ptp(corners[..., 2], axis=1) == pytest.approx(0, abs=1e-8)
    assert np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1) == pytest.approx(4e-3, rel=1e-5)
    cloud = PointCloud(places, colors=np.ones((len(places), 3)))
    half = np.where(np.arange(len(places))[:, None] % 2, [[0, 2, 0]], 0)
    with pytest.warns(UserWarning, match=f"{len(places) // 2} normals have no length"):
        surfels(cloud, normals=half)
    for wrong, words in (
        ({"radius_m": 0}, "radius_m: expected numbers above 0"),
        ({"radius_m": [1, 2]}, r"radius_m: expected shape \(400,\)"),
        ({"normals": [[0, 1, 0]]}, "normals: expected shape"),
        ({"normals": np.full((len(places), 3), np.nan)}, "normals: expected finite"),
        ({"overlap": 0}, "overlap: expected a number above 0"),
    ):
        with pytest.raises(omma.Error, match=words):
            surfels(cloud, **wrong)


def test_few_points_and_points_on_each_other():
    for count in (1, 12):
        with pytest.raises(omma.Error, match=f"expected more than 12 .*found {count}"):
            surfels(PointCloud(plane_points(0.01)[:count]))
    places = plane_points(0.01)
    twice = PointCloud(np.vstack([places] * 20), colors=np.ones((20 * len(places), 3)))
    with pytest.warns(UserWarning, match=f"{19 * len(places):,} points are left out"):
        assert surfels(twice).triangle_count == 2 * len(places)
    with pytest.raises(omma.Error, match="found 1"):
        surfels(PointCloud(np.ones((50, 3))))


def test_progress_is_told_and_ends_the_work(plane_cloud, tmp_path):
    heard = []
    surfels(plane_cloud, progress=heard.append)
    assert heard == sorted(heard)
    assert heard[-1] == 1
    assert len(heard) > 5

    def stop(done):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        surfels(plane_cloud, progress=stop)
    path = write_ply(
        tmp_path / "a.ply",
        {axis: ("float", plane_points(0.02)[:, k]) for k, axis in enumerate("xyz")},
    )
    heard.clear()
    with pytest.warns(UserWarning, match="grey"):
        omma.load_scene(path, progress=heard.append)
    assert heard == sorted(heard)
    assert heard[-1] == 1


def test_points_in_a_line_are_told():
    places = np.zeros((500, 3))
    places[:, 0] = RNG.uniform(0, 1, 500)
    with pytest.warns(UserWarning, match="the neighbours of 500 points lie in a line"):
        surfels(PointCloud(places, colors=np.ones((500, 3))))


def test_what_does_not_fit_says_what_would(tmp_path, monkeypatch):
    """And the grid that it names does."""
    path = write_ply(
        tmp_path / "a.ply",
        {axis: ("float", plane_points(0.03)[:, k]) for k, axis in enumerate("xyz")},
    )
    monkeypatch.setattr("omma.scene.surfel_scenes.free_bytes", lambda: 400.0 * 500)
    with pytest.raises(omma.Error, match="500 would fit; thin them by") as told:
        omma.load_scene(path)
    assert str(told.value).startswith(str(path))
    voxel_m = float(str(told.value).split("voxel_m=")[1])
    thinned = omma.scene.load_points(path, voxel_m=voxel_m)
    assert 150 < len(thinned) <= 500
    with pytest.warns(UserWarning, match="grey"):
        surfels(thinned)


def test_files_of_points_are_scenes(tmp_path, run_omma):
    # At steps of 1 mm no two are at one place, which a file's 0.1 mm would make of random ones.
    places = np.stack(np.meshgrid(*[np.arange(60) * SPACING] * 2, [0.0]), axis=-1).reshape(-1, 3)
    places[:, :2] += RNG.integers(-3, 4, (len(places), 2)) * 1e-4
    places += (4e5 - 0.03, 5e6 - 0.03, 100)
    path = write_las(tmp_path / "scan.laz", places, classes=np.full(len(places), 2))
    with pytest.warns(UserWarning, match=r"scan\.laz: it has no colours: intensities are seen"):
        scene = omma.load_scene(path)
    assert scene.triangle_count == 2 * len(places)
    assert scene.path == str(path)
    assert scene.bounds.mean(axis=0) == pytest.approx([4e5, 100, -5e6], abs=0.01)
    assert merge_scenes([scene, omma.scene.box()]).triangle_count == 2 * len(places) + 12
    code, said, _ = run_omma("info", path)
    assert code == 0
    for words in ("3,600", "extent", "a thing on a table", "2 ground: 3,600", "up z"):
        assert words in said, said
    cloud_file = write_ply(
        tmp_path / "scan.ply", {axis: ("double", places[:, k]) for k, axis in enumerate("xyz")}
    )
    with pytest.warns(UserWarning, match="grey"):
        assert omma.load_scene(cloud_file, unit="mm").triangle_count > 0
    out = tmp_path / "a.npy"
    where = ("--position", 4e5, 100.02, -5e6, "--look-at", 4e5, 100, -5e6 - 0.01)
    code, _, told = run_omma("render", path, "--eye", eye_file(tmp_path), *where, "--output", out)
    assert code == 0, told
    assert "intensities are seen" in told
    assert np.load(out).max() > 0


def test_text_files_of_points_are_scenes_where_their_endings_say_it(tmp_path):
    rows = np.c_[np.stack(np.meshgrid(np.arange(4.0), np.arange(5.0)), -1).reshape(-1, 2), [0] * 20]
    for ending in ("xyz", "pts", "txt", "csv"):
        np.savetxt(tmp_path / f"a.{ending}", rows)
    with pytest.warns(UserWarning, match="grey"):
        scenes = [omma.load_scene(tmp_path / f"a.{ending}") for ending in ("xyz", "pts")]
    assert [one.triangle_count for one in scenes] == [40, 40]
    for ending in ("txt", "csv"):
        with pytest.raises(omma.Error, match=rf"a\.{ending}: .*omma\.scene\.load_points"):
            omma.load_scene(tmp_path / f"a.{ending}")


def eye_file(folder):
    omma.save_eye(folder / "a.eye", omma.eye.generate_eye(60))
    return folder / "a.eye"


@pytest.mark.filterwarnings("ignore:.*has no colours")
def test_instances_move_together():
    scene = surfels(PointCloud(plane_points(0.01), colors=None), name="scan")
    assert [type(one) for one in scene.instances] == [Instance]
    world = omma.World(scene)
    lifted = np.eye(4)
    lifted[1, 3] = 1
    world.set_transforms("scan", lifted)
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], [0.0])
    pose = omma.look_at((0, 1.02, 0), (0, 1, 0), up=(0, 0, 1))
    assert omma.Renderer(world, eye, omma.Fixed(1)).ground_truth(pose).distance_m.item() == (
        pytest.approx(0.02, abs=1e-6)
    )
