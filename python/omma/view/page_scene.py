"""The scene on the page in 3D, and the head in it with its facets, axes and fields of view."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from omma.base.srgb import srgb_of_linear
from omma.picture.band_colours import bands_to_rgb
from omma.view.overlay import PICKED, head_shapes
from omma.view.poses import HeadPose, quaternion_wxyz
from omma.view.scene_mesh import drawn_scene, sky_dome, without_scale
from omma.view.splat_scene import drawn_splats
from omma.view.state import Look, Looker

if TYPE_CHECKING:
    import viser

_SKY_IN_SCENES = 20.0  # radius of the sky, in sizes of the scene
_GROUND = 0.1  # what light the ground sends up, of what falls on it


class PageScene:
    """What viser draws. head: the control by which it is dragged; head_m: the radius that the head
    is drawn with, m; axes, fields: what can be shown of it; note: what is not drawn, in words."""

    def __init__(self, server: viser.ViserServer, looker: Looker, look: Look) -> None:
        self.server, self.looker = server, looker
        world = looker.world
        scene = server.scene
        scene.set_up_direction("+y")
        self.looker.go_to_time(look.time_s)
        drawn = drawn_scene(world)
        self.note = drawn.note
        if drawn.still is not None:
            scene.add_glb("/scene/still", drawn.still)
        self._add_splats()
        self._moving = {}
        instances = world.instances if drawn.moving else []
        for k, glb in drawn.moving:
            transform = without_scale(instances[k].world_from_node)
            self._moving[k] = scene.add_glb(
                f"/scene/moving/{k}",
                glb,
                wxyz=quaternion_wxyz(transform),
                position=tuple(transform[:3, 3].tolist()),
            )
        bounds = world.scene.bounds
        size_m = 10.0 if bounds is None else float(np.linalg.norm(np.ptp(bounds, axis=0)))
        size_m = size_m if math.isfinite(size_m) and size_m > 0 else 10.0
        scene.add_glb("/sky", sky_dome(world, _SKY_IN_SCENES * size_m))
        if world.light is not None:
            self._add_lamps()
        self.head_m = min(0.12, 0.02 * size_m)
        self._add_head(look.pose)
        matrix = look.pose.world_from_head
        camera = server.initial_camera
        camera.position = (matrix @ [2 * self.head_m, 4 * self.head_m, 9 * self.head_m, 1])[:3]
        camera.look_at = (matrix @ [0, 0, -4 * self.head_m, 1])[:3]
        camera.up = (0.0, 1.0, 0.0)
        camera.near, camera.far = 0.02 * self.head_m, 2.5 * _SKY_IN_SCENES * size_m

    def _add_splats(self) -> None:
        clouds, note = drawn_splats(self.looker.world.scene)
        self.note = "; ".join(one for one in (self.note, note) if one)
        for k, cloud in enumerate(clouds):
            self.server.scene.add_gaussian_splats(
                f"/scene/splats/{k}",
                cloud.centers,
                cloud.covariances,
                cloud.rgbs,
                cloud.opacities,
            )

    def _add_lamps(self) -> None:
        """Sun and sky as lamps of the page: what lies in the open has the colours that the camera's
        picture has, as the world is lit there; without its shadows."""
        light = self.looker.world.light
        assert light is not None
        scene = self.server.scene
        sky, discs = light.irradiance()
        if not np.any(sky + discs):
            lamps = "lit by the page, not by the scene's own lamps"
            self.note = "; ".join(one for one in (self.note, lamps) if one)
            return
        scene.configure_default_lights(False)
        scene.configure_environment_map(None)
        sky_colour, sky_level = _lamp(bands_to_rgb(sky / np.pi, light))
        below = bands_to_rgb(_GROUND * (sky + discs) / np.pi, light)
        ground_colour, _ = _lamp(below, sky_level)
        scene.add_light_hemisphere(
            "/light/sky",
            sky_color=sky_colour,
            ground_color=ground_colour,
            intensity=np.pi * sky_level,
        )
        for k, disc in enumerate(light.discs):
            colour, level = _lamp(bands_to_rgb(disc.irradiance() / np.pi, light))
            # A lamp of viser's shines from where it is to the origin.
            x, y, z = (100 * np.asarray(disc.direction, np.float64)).tolist()
            scene.add_light_directional(
                f"/light/{k}", color=colour, intensity=np.pi * level, position=(x, y, z)
            )

    def _add_head(self, pose: HeadPose) -> None:
        scene, shapes = self.server.scene, head_shapes(self.looker.eye)
        matrix = pose.world_from_head
        self.head = scene.add_transform_controls(
            "/head",
            scale=4.5 * self.head_m,
            line_width=3.0,
            depth_test=False,
            opacity=0.85,
            wxyz=quaternion_wxyz(matrix),
            position=pose.position_m,
        )
        r = self.head_m
        size = 2.1 * r * math.sqrt(4 / max(len(shapes.facets), 12))
        self._facets = scene.add_point_cloud(
            "/head/facets",
            r * shapes.facets,
            (128, 128, 128),
            point_size=size,
            point_shape="circle",
            point_shading="flat",
            precision="float32",
        )
        self.axes = scene.add_line_segments(
            "/head/axes",
            r * shapes.axes,
            shapes.axis_colours,
            thickness=1.0,
            thickness_units="screen",
            visible=False,
        )
        self.fields = [
            scene.add_mesh_simple(
                f"/head/fields/{k}",
                r * vertices,
                triangles,
                color=colour,
                opacity=0.22,
                side="double",
                visible=False,
                cast_shadow=False,
                receive_shadow=False,
            )
            for k, (vertices, triangles, colour) in enumerate(shapes.fields)
        ]
        ahead = r * np.array([[[0.0, 0, -1.0], [0, 0, -3.0]], [[0, 1.0, 0], [0, 1.6, 0]]])
        scene.add_line_segments(
            "/head/ahead", ahead, PICKED, thickness=3.0, thickness_units="screen"
        )

    def place_head(self, pose: HeadPose) -> None:
        """The head where its pose says."""
        self.head.wxyz = quaternion_wxyz(pose.world_from_head)
        self.head.position = pose.position_m

    def place_moving(self, look: Look) -> None:
        """What animations move where it is now; in the thread that renders."""
        if not self._moving:
            return
        instances = self.looker.world.instances
        for k, handle in self._moving.items():
            transform = without_scale(instances[k].world_from_node)
            handle.wxyz = quaternion_wxyz(transform)
            handle.position = tuple(transform[:3, 3].tolist())

    def show_facets(self, colours: NDArray[np.uint8]) -> None:
        """The colours (N, 3) of the facets on the head."""
        self._facets.colors = colours


def _lamp(
    rgb: NDArray[np.float32], level: float | None = None
) -> tuple[tuple[int, int, int], float]:
    """A colour of 8 bits, sRGB, and a level; together linear red, green and blue (3,)."""
    linear = np.clip(np.asarray(rgb, np.float64), 0, None)
    level = float(linear.max()) if level is None else level
    if not level > 0:
        return (0, 0, 0), 0.0
    share = np.clip(linear / level, 0, 1)
    red, green, blue = np.round(255 * srgb_of_linear(share)).astype(int).tolist()
    return (red, green, blue), level
