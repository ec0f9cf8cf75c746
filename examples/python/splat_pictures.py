"""Pictures of the bundled meadow around the camera "bee", as `train_splats.py` trains on them.

Perspective views, sRGB-encoded as photographs are; the light that is behind everything; and the
points that the pixels' middles meet, which stand in for those that COLMAP finds in photographs.
"""

import math
from dataclasses import dataclass

import numpy as np
import torch

import omma

WIDTH, HEIGHT, YFOV_DEG = 128, 96, 60
PIXEL_RAD = 2 * math.tan(math.radians(YFOV_DEG / 2)) / HEIGHT


@dataclass
class View:
    """A picture, the rays of its pixels, and what is behind all splats."""

    eye: torch.Tensor  # (3,), where it was taken
    frame: torch.Tensor  # (3, 3), rows: right, down, ahead
    picture: torch.Tensor  # (pixels, 3), sRGB-encoded
    sky: torch.Tensor  # (pixels, 3), linear
    points: np.ndarray  # (pixels, 3), what the pixels' middles meet, NaN where nothing
    error: np.ndarray  # (pixels,), when it was last trained on


def encode(linear):
    """The curve of sRGB (IEC 61966-2-1)."""
    low, high = 12.92 * linear, 1.055 * linear.clamp(min=0.0031308) ** (1 / 2.4) - 0.055
    return torch.where(linear <= 0.0031308, low, high)


def decode(value):
    """Linear light of sRGB-encoded values; above 1 it goes on as there."""
    low, high = value / 12.92, ((value.clamp(min=0.04045) + 0.055) / 1.055) ** 2.4
    return torch.where(value <= 0.04045, low, high)


def camera_rays():
    """Directions (pixels, 3) through the pixels' middles: right, down, ahead."""
    row, column = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    right, down = (column - WIDTH / 2) * PIXEL_RAD, (row - HEIGHT / 2) * PIXEL_RAD
    rays = np.stack([right, down, np.ones_like(right)], axis=-1).reshape(-1, 3)
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def poses_around(scene, count, seed=0):
    """Cameras' poses around "bee": 0.1 to 2 m above the ground, nearer ones more, in and out."""
    random = np.random.default_rng(seed)
    bee = scene.camera("bee").world_from_camera[:3, 3]
    down = omma.Eye(np.zeros((1, 3)), [[0, -1, 0]], 0.0)
    ground = omma.Renderer(scene, down, omma.Fixed(1), threads=1)
    poses = []
    for i in range(count):
        around, away = i * math.pi * (3 - 5**0.5), 0.2 + 2.3 * random.random() ** 1.5
        place = bee + away * np.array([math.cos(around), 0, math.sin(around)])
        above = omma.look_at(place + (0, 5, 0), place + (0, 5, -1))
        soil = place[1] + 5 - float(ground.ground_truth(above).distance_m[0, 0])
        place[1] = soil + 0.1 * 20 ** random.random()
        azimuth, elevation = random.random() * 2 * math.pi, random.uniform(-1.2, 0.45)
        ahead = np.array([math.cos(azimuth), math.tan(elevation), math.sin(azimuth)])
        poses.append(omma.look_at(place, place + ahead))
    return poses


def take_pictures(scene, poses, samples=32):
    """A `View` for each pose."""
    world = omma.World(scene, threads=1)
    empty = omma.World(omma.Scene(), background=scene.background, threads=1)
    rays = camera_rays()
    pixels = omma.Eye(np.zeros_like(rays), rays * (1, -1, -1), 0.0)
    seen = omma.Renderer(world, pixels, omma.Fixed(1))
    views = []
    for pose in poses:
        camera = omma.scene.Camera(world_from_camera=pose, yfov_rad=math.radians(YFOV_DEG))
        size = {"width": WIDTH, "height": HEIGHT, "samples": samples}
        linear = [omma.render_camera(one, camera, **size).reshape(-1, 3) for one in (world, empty)]
        views.append(
            View(
                torch.tensor(pose[:3, 3], dtype=torch.float32),
                torch.tensor((pose[:3, :3] * (1, -1, -1)).T.copy(), dtype=torch.float32),
                encode(torch.from_numpy(linear[0]).clamp(0, 1)),
                torch.from_numpy(linear[1].copy()),
                seen.ground_truth(pose).position_m[0],
                np.ones(len(rays)),
            )
        )
    return views


class Grid:
    """The pixels of a picture, or each ``stride``th of its columns and rows."""

    def __init__(self, stride=1, column=0, row=0):
        rows, columns = np.mgrid[row:HEIGHT:stride, column:WIDTH:stride]
        self.pixels = (rows * WIDTH + columns).ravel()
        self.rays = torch.tensor(camera_rays()[self.pixels], dtype=torch.float32)
        self.stride, self.first, self.size = stride, (column, row), rows.T.shape
