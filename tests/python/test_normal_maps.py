"""Normal maps are a relief: from either side, mirrored or not, a sheet is shaded as with vertices
of the same normals.
"""

import numpy as np
import pytest

import omma
from omma.scene import Image, Instance, Material, Mesh, PunctualLight

CODE = np.array([186, 158, 240], np.uint8)
NORMAL = CODE / 255 * 2 - 1
NORMAL = NORMAL / np.linalg.norm(NORMAL)
LAMP = np.array([3.0, 1.0, 10.0]) / np.sqrt(110)
FRAMES = {
    "as made": np.eye(3),
    "from behind": np.diag([-1.0, 1, -1]),
    "mirrored": np.diag([-1.0, 1, 1]),
    "mirrored, from behind": np.diag([1.0, 1, -1]),
    "point reflected": np.diag([-1.0, -1, -1]),
}


def seen(linear, backend, **parts):
    """Radiance of a sheet 3 m ahead, lit from beside the viewer."""
    map_of = {"normal_texture": 0} if parts.pop("is_mapped") else {}
    sheet = Mesh(
        [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
        [[0, 1, 2], [0, 2, 3]],
        texture_coordinates=[[0, 1], [1, 1], [1, 0], [0, 0]],
        material=0,
        **parts,
    )
    world_from_mesh = np.eye(4)
    world_from_mesh[:3, :3] = linear
    world_from_mesh[:3, 3] = 0, 0, -3
    lamp = PunctualLight(
        "lamp", type="directional", world_from_light=omma.look_at(10 * LAMP, (0, 0, 0))
    )
    scene = omma.Scene(
        meshes=[sheet],
        instances=[Instance(0, world_from_mesh)],
        materials=[Material(base_color=(0.5,) * 3, specular=0, double_sided=True, **map_of)],
        images=[Image(np.tile(CODE, (4, 4, 1)))],
        lights=[lamp],
    )
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], np.radians(2))
    world = omma.World(scene, light=omma.light.lamps(), backend=backend)
    return omma.Renderer(world, eye, omma.Fixed(16)).render(np.eye(4))[0, 0, 6]


@pytest.mark.parametrize("backend", ["embree", "portable"])
@pytest.mark.parametrize("frame", FRAMES)
def test_a_relief_is_the_same_from_both_sides(frame, backend):
    """From behind x and y had kept their sign: 25 % off."""
    linear = FRAMES[frame]
    flat = seen(np.eye(3), backend, is_mapped=False) / LAMP[2]
    normal = np.linalg.inv(linear).T @ NORMAL
    normal *= np.sign(normal[2])  # on the viewer's side
    mapped = seen(linear, backend, is_mapped=True)
    # Light is in single precision.
    assert mapped / flat == pytest.approx(normal @ LAMP, rel=1e-5)
    by_vertices = seen(linear, backend, is_mapped=False, normals=np.tile(NORMAL, (4, 1)))
    assert mapped == pytest.approx(by_vertices, rel=1e-5)
