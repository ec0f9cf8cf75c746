"""Eyes on surfaces: places of directions, lattices of lenses, skew, facets and their optics."""

import numpy as np
import pytest

import omma

D = np.radians


def icosphere(times):
    """A sphere of triangles: vertices (V, 3), triangles (T, 3)."""
    g = (1 + 5**0.5) / 2
    v = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g),
         (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]  # fmt: skip
    t = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4),
         (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9),
         (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]  # fmt: skip
    corners = np.array(v, float)[np.array(t)]
    for _ in range(times):
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        corners = np.concatenate(
            [np.stack(x, axis=1) for x in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
    corners /= np.linalg.norm(corners, axis=2, keepdims=True)
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


def directions(count, seed=0):
    random = np.random.default_rng(seed).standard_normal((count, 3))
    return random / np.linalg.norm(random, axis=1, keepdims=True)


def angle(first, second):
    return np.arccos(np.clip(np.sum(first * second, axis=1), -1, 1))


def test_points_of_an_ellipsoid():
    axes, centre = np.array([0.4e-3, 1.2e-3, 0.5e-3]), np.array([1e-3, 2e-3, 0])
    surface = omma.eye.surfaces.ellipsoid(axes, centre)
    d = directions(100)
    points = surface.point_of_normal(d)
    assert np.sum(((points - centre) / axes) ** 2, axis=1) == pytest.approx(1)
    assert surface.normals(points) == pytest.approx(d, abs=1e-12)
    assert surface.onto(centre + 3 * (points - centre)) == pytest.approx(points)
    samples, area = surface.samples(100_000)
    # Thomsen's formula is within 1.2 %.
    p = 1.6075
    a, b, c = axes**p
    expected = 4 * np.pi * ((a * b + a * c + b * c) / 3) ** (1 / p)
    assert area.sum() == pytest.approx(expected, rel=0.012)
    assert surface.to_edge(samples) is None


def test_a_mesh_of_a_sphere_is_a_sphere():
    vertices, triangles = icosphere(4)
    for turned in (triangles, triangles[:, ::-1]):  # outwards, whichever way triangles are turned
        mesh = omma.eye.surfaces.mesh_surface(1e-3 * vertices, turned)
        d = directions(500)
        points = mesh.point_of_normal(d)
        # Middles of triangles are up to 2.8° from corners, so 1 - cos 2.8° = 0.12 % too low.
        assert np.linalg.norm(points, axis=1) == pytest.approx(1e-3, rel=1.2e-3)
        assert angle(points / 1e-3, d).max() < 0.06
        assert mesh.normals(points) == pytest.approx(d, abs=1e-6)
        assert mesh.onto(2e-3 * d) == pytest.approx(1e-3 * d, abs=2e-5)
        assert mesh.samples(1000)[1].sum() == pytest.approx(4e-6 * np.pi, rel=3e-3)
        assert mesh.to_edge(points) is None


def test_nearest_points_of_a_mesh_are_the_nearest():
    vertices, triangles = icosphere(1)
    mesh = omma.eye.surfaces.mesh_surface(vertices, triangles)
    points = 1.3 * directions(50)
    # Against a fine sampling of all triangles.
    samples = mesh.samples(2_000_000)[0]
    for point, found in zip(points, mesh.onto(points)):
        distance = np.linalg.norm(samples - point, axis=1).min()
        assert np.linalg.norm(found - point) <= distance + 1e-9
        assert np.linalg.norm(found - point) == pytest.approx(distance, abs=1e-3)


@pytest.mark.parametrize("ending", ["stl", "obj", "glb"])
def test_meshes_from_files(tmp_path, ending):
    trimesh = pytest.importorskip("trimesh")
    vertices, triangles = icosphere(2)
    path = tmp_path / f"eye.{ending}"
    trimesh.Trimesh(vertices * [1, 2, 3], triangles).export(path)
    mesh = omma.eye.surfaces.load_surface(path, unit="um")
    assert np.abs(mesh.vertices).max(axis=0) == pytest.approx([1e-6, 2e-6, 3e-6], rel=1e-5)
    assert len(mesh.triangles) == len(triangles)


def test_wrong_files_are_errors(tmp_path):
    pytest.importorskip("trimesh")
    for name, text in (("none.stl", None), ("bad.obj", "nothing"), ("bad.glb", "nothing")):
        if text is not None:
            (tmp_path / name).write_text(text)
        with pytest.raises(omma.Error, match=name):
            omma.eye.surfaces.load_surface(tmp_path / name)


def test_a_file_that_is_not_there_is_said_to_be_missing(tmp_path):
    with pytest.raises(omma.Error, match=r"none\.stl: there is no such file"):
        omma.eye.surfaces.load_surface(tmp_path / "none.stl")


def test_a_mesh_in_another_unit_is_told(tmp_path):
    vertices, triangles = icosphere(1)
    lines = [f"v {x} {y} {z}" for x, y, z in 400 * vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    (tmp_path / "eye.obj").write_text("\n".join(lines))
    with pytest.warns(UserWarning, match=r"eye\.obj: 0\.8 m along .* with unit 'mm'"):
        omma.eye.surfaces.load_surface(tmp_path / "eye.obj")
    omma.eye.surfaces.load_surface(tmp_path / "eye.obj", "um")


def test_directions_that_no_normal_points_in_are_told():
    vertices, triangles = icosphere(3)
    whole = omma.eye.surfaces.mesh_surface(1e-3 * vertices, triangles)
    omma.eye.eye_on_surface(directions(300), whole)
    front = vertices[triangles].mean(axis=1)[:, 2] < 0
    half = omma.eye.surfaces.mesh_surface(1e-3 * vertices, triangles[front])
    d = directions(300)
    turn = np.arange(8) * D(45)
    behind = np.stack([np.cos(turn), np.sin(turn), 0.5 + 0 * turn], axis=1)
    seen = np.concatenate([d[d[:, 2] < -0.3], behind])
    with pytest.warns(UserWarning, match=f"points as 8 of {len(seen)} directions want it"):
        omma.eye.eye_on_surface(seen, half)


def test_eye_of_directions():
    d = directions(200)
    surface = omma.eye.surfaces.ellipsoid((1e-3, 2e-3, 1e-3))
    eye = omma.eye.eye_on_surface(d, surface, acceptance_ratio=1.5, eye_id=1)
    assert eye.axis == pytest.approx(d, abs=1e-6)
    assert eye.position_m == pytest.approx(surface.point_of_normal(d), rel=1e-5)
    assert eye.acceptance_angle_rad == pytest.approx(1.5 * eye.interommatidial_angle_rad())
    assert eye.facet_diameter_m == pytest.approx(omma.eye.facet_diameters_m(eye))
    assert set(eye.eye_id.tolist()) == {1}
    assert omma.eye.skew.skew_rad(eye, surface=surface) == pytest.approx(0, abs=1e-3)  # float axes


@pytest.mark.parametrize("centre", [None, (0.0, 0.0, 0.0)])
@pytest.mark.parametrize("degrees", [32, 38, 45])
def test_a_skewed_design_has_the_median_asked_for(degrees, centre):
    # 32 to 45° is what real bees have, from the head's middle.
    d = directions(2000)
    towards = omma.eye.direction(60, 0)
    d = d[angle(d, np.broadcast_to(towards, d.shape)) < D(80)]
    surface = omma.eye.surfaces.ellipsoid((0.4e-3, 1.2e-3, 0.5e-3), (1.4e-3, 0, 0))
    factor = omma.eye.skew.squeeze_for_skew(d, surface, towards, D(degrees), center_m=centre)
    eye = omma.eye.eye_on_surface(d, surface, normal=omma.eye.skew.squeezed(towards, factor))
    skew = (
        omma.eye.skew.skew_rad(eye, surface=surface)
        if centre is None
        else omma.eye.skew.skew_rad(eye)
    )
    assert np.degrees(np.median(skew)) == pytest.approx(degrees, abs=0.01)  # float positions
    normals = surface.normals(eye.position_m.astype(float))
    many = np.broadcast_to(towards, d.shape)
    assert angle(normals, many) == pytest.approx(factor * angle(d, many), abs=1e-3)


def test_lenses_over_a_sphere():
    eye = omma.eye.lay_on_surface(
        omma.eye.surfaces.sphere(1e-3, (1e-3, 0, 0)), 100e-6, acceptance_ratio=2
    )
    position = eye.position_m.astype(float) - [1e-3, 0, 0]
    assert np.linalg.norm(position, axis=1) == pytest.approx(1e-3, rel=1e-5)
    assert eye.axis == pytest.approx(position / 1e-3, abs=1e-5)
    # Hexagonal cells of that width, √3/2 a².
    assert len(eye) == pytest.approx(4 * np.pi / (np.sqrt(3) / 2 * 0.1**2), rel=0.01)
    assert np.median(eye.facet_diameter_m) == pytest.approx(100e-6, rel=0.02)
    assert np.quantile(np.abs(eye.facet_diameter_m / 100e-6 - 1), 0.95) < 0.1
    assert eye.acceptance_angle_rad == pytest.approx(2 * eye.interommatidial_angle_rad())


def test_lenses_over_part_of_a_surface_wider_on_top():
    surface = omma.eye.surfaces.ellipsoid((0.6e-3, 1e-3, 0.6e-3))

    def width(points):
        return 40e-6 * (1.5 + 0.5 * points[:, 1] / 1e-3)

    eye = omma.eye.lay_on_surface(
        surface, width, inside=lambda points: points[:, 0] > 0, count=700,
        axis=lambda points, normals: normals + [0.5, 0, 0],
    )  # fmt: skip
    position = eye.position_m.astype(float)
    assert len(eye) == 700
    assert position[:, 0].min() > 0
    relative = eye.facet_diameter_m / width(position)
    scale = np.median(relative)  # to give 700
    assert np.quantile(np.abs(relative / scale - 1), 0.95) < 0.1
    expected = surface.normals(position) + [0.5, 0, 0]
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    assert eye.axis == pytest.approx(expected, abs=1e-5)


def test_whole_facets_on_an_open_mesh():
    vertices, triangles = icosphere(3)
    above = (vertices[triangles][:, :, 1] > -1e-9).all(axis=1)
    mesh = omma.eye.surfaces.mesh_surface(1e-3 * vertices, triangles[above])
    eye = omma.eye.lay_on_surface(mesh, 100e-6)
    position = eye.position_m.astype(float)
    assert mesh.to_edge(position).min() >= 49e-6
    assert np.median(eye.facet_diameter_m) == pytest.approx(100e-6, rel=0.03)
    assert eye.axis[:, 1].min() > 0
    assert eye.axis == pytest.approx(mesh.normals(position), abs=1e-5)


def hexagons(rows, columns, stretch=1.0):
    """An eye of a flat hexagonal lattice of spacing 20 µm, and which of it is inside."""
    row, column = [part.ravel() for part in np.mgrid[:rows, :columns]]
    x, y = column + 0.5 * (row % 2), row * np.sqrt(3) / 2 * stretch
    position = 20e-6 * np.stack([x, y, 0 * x], axis=1)
    inside = (row > 0) & (row < rows - 1) & (column > 0) & (column < columns - 1)
    return omma.Eye(position, [[0, 0, -1]] * len(row), 0.1), inside


def test_facets_of_a_lattice_also_at_its_edge():
    eye, _ = hexagons(9, 11)
    # Corners too, where the next ring is among the six nearest.
    assert omma.eye.facet_diameters_m(eye) == pytest.approx(20e-6, rel=1e-5)
    stretched, inside = hexagons(9, 11, 1.3)
    expected = 20e-6 * (2 + 4 * np.hypot(0.5, 1.3 * np.sqrt(3) / 2)) / 6
    assert omma.eye.facet_diameters_m(stretched)[inside] == pytest.approx(expected, rel=1e-5)
    assert omma.eye.set_facets(eye, 0.9).facet_diameter_m == pytest.approx(18e-6, rel=1e-5)
    head = omma.eye.merge_eyes([eye, eye])  # at the same positions
    assert omma.eye.facet_diameters_m(head) == pytest.approx(20e-6, rel=1e-5)


def test_acceptance_from_facets():
    eye = hexagons(4, 4)[0].replace(facet_diameter_m=np.linspace(15e-6, 30e-6, 16))
    airy = omma.eye.acceptance_from_facets(eye, wavelength_nm=400)
    assert [one.kernel for one in airy.acceptances] == ["airy"] * 16
    # 1.0290 λ/D
    expected = 1.0290 * 400e-9 / eye.facet_diameter_m
    assert airy.acceptance_angle_rad == pytest.approx(expected, rel=5e-3)
    snyder = omma.eye.acceptance_from_facets(
        eye, rhabdom_diameter_m=2e-6, f_number=2, model="snyder", wavelength_nm=500
    )
    d = eye.facet_diameter_m.astype(float)
    expected = np.hypot(500e-9 / d, 2e-6 / (2 * d))
    assert snyder.acceptance_angle_rad == pytest.approx(expected, rel=5e-3)
    focal = omma.eye.acceptance_from_facets(
        eye, rhabdom_diameter_m=np.full(16, 2e-6), focal_length_m=2 * d, model="snyder"
    )
    assert focal.acceptance_angle_rad == pytest.approx(snyder.acceptance_angle_rad, rel=1e-5)
    assert (focal.facet_diameter_m == eye.facet_diameter_m).all()


def test_facets_are_grouped_for_their_optics():
    count = 3000
    eye = omma.Eye(np.zeros((count, 3)), directions(count), 0.1)
    facets = np.random.default_rng(0).uniform(15e-6, 30e-6, count)
    eye = omma.eye.acceptance_from_facets(eye.replace(facet_diameter_m=facets))
    assert len(eye.acceptances) == 64
    made_of = np.array([one.facet_diameter_m for one in eye.acceptances])[eye.acceptance_of]
    # Half of 2^(1/64) and as much again, as the mean of a group need not be its middle.
    assert np.abs(made_of / facets - 1).max() < 0.011
    assert np.abs(made_of / facets - 1).mean() < 0.004
    assert eye.facet_diameter_m == pytest.approx(facets, rel=1e-6)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: omma.eye.surfaces.sphere(0), ["semi_axes_m", "0"]),
        (lambda: omma.eye.surfaces.ellipsoid((1, 2)), ["semi_axes_m", "(2,)"]),
        (
            lambda: omma.eye.surfaces.mesh_surface([[0, 0, 0]], [[0, 0, 1]]),
            ["triangles", "indices"],
        ),
        (lambda: omma.eye.surfaces.mesh_surface([[0, 0, 0]], [[0, 0, 0]]), ["triangles", "area"]),
        (lambda: omma.eye.surfaces.mesh_surface([[0, 0]], [[0, 0, 0]]), ["vertices", "(1, 2)"]),
        (
            lambda: omma.eye.eye_on_surface([[0, 0]], omma.eye.surfaces.sphere(1)),
            ["directions", "(1, 2)"],
        ),
        (lambda: omma.eye.skew.squeezed([0, 0, 0], 1), ["towards"]),
        (lambda: omma.eye.skew.squeezed([0, 0, 1], 0), ["factor", "0"]),
        (
            lambda: omma.eye.skew.squeeze_for_skew(
                directions(9), omma.eye.surfaces.sphere(1), [0, 0, 1], 3.1
            ),
            ["median_rad", "found 177.6"],
        ),
        (lambda: omma.eye.skew.skew_rad(hexagons(2, 2)[0]), ["centre"]),
        (lambda: omma.eye.lay_on_surface(omma.eye.surfaces.sphere(1), 0), ["spacing_m", "above 0"]),
        (
            lambda: omma.eye.lay_on_surface(omma.eye.surfaces.sphere(1), 9),
            ["spacing_m", "too wide"],
        ),
        (lambda: omma.eye.lay_on_surface(omma.eye.surfaces.sphere(1), 1, count=1), ["count", "1"]),
        (
            lambda: omma.eye.lay_on_surface(omma.eye.surfaces.sphere(1), lambda p: p),
            ["spacing_m", "shape"],
        ),
        (
            lambda: omma.eye.lay_on_surface(omma.eye.surfaces.sphere(1), 1, inside=lambda p: p),
            ["inside"],
        ),
        (
            lambda: omma.eye.lay_on_surface(omma.eye.surfaces.sphere(1e-3), 2e-8),
            ["spacing_m", "200,000", "0.02 µm", "12.6 mm²", "another unit"],
        ),
        (
            lambda: omma.eye.lay_on_surface(
                omma.eye.surfaces.sphere(1), 0.1, inside=lambda p: p[:, 0] > 2
            ),
            ["inside", "holds none of 200,000"],
        ),
        (lambda: omma.eye.facet_diameters_m(omma.Eye([[0, 0, 0]], [[0, 0, 1]], 0)), ["one"]),
        (lambda: omma.eye.set_facets(hexagons(2, 2)[0], 0), ["factor"]),
        (lambda: omma.eye.acceptance_from_facets(hexagons(2, 2)[0]), ["4 of 4", "set_facets"]),
        (
            lambda: omma.eye.acceptance_from_facets(
                omma.eye.set_facets(hexagons(2, 2)[0]), f_number=2
            ),
            ["rhabdom_diameter_m"],
        ),
        (
            lambda: omma.eye.acceptance_from_facets(
                omma.eye.set_facets(hexagons(2, 2)[0]), rhabdom_diameter_m=1e-6
            ),
            ["focal_length_m", "f_number"],
        ),
    ],
)
def test_wrong_arguments_are_named(call, words):
    with pytest.raises(omma.Error) as caught:
        call()
    for word in words:
        assert word in str(caught.value)


def test_the_old_name_of_a_centre_works_with_a_warning():
    with pytest.warns(DeprecationWarning, match="centre_m: is called center_m now"):
        old = omma.eye.surfaces.sphere(1e-3, centre_m=(1e-3, 0, 0))
    assert old == omma.eye.surfaces.sphere(1e-3, center_m=(1e-3, 0, 0))
