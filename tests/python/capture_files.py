"""Files of cameras as COLMAP, Nerfstudio and 3D Gaussian Splatting write them, from poses as Omma
has them: world_from_camera, looking along -Z with +Y up."""

import json
import struct

import numpy as np
from scipy.spatial.transform import Rotation

# y and z of a camera turned round, as COLMAP has them.
FLIP = np.diag([1.0, -1.0, -1.0])
# Name, number and parameters of some lenses; pictures are 640 x 480 pixels.
LENSES = {
    "SIMPLE_PINHOLE": (0, [400, 320, 240]),
    "PINHOLE": (1, [400, 420, 320, 240]),
    "SIMPLE_RADIAL": (2, [400, 320, 240, 0.01]),
    "OPENCV": (4, [400, 420, 320, 240, 0.01, 0, 0, 0]),
    "OPENCV_FISHEYE": (5, [200, 210, 320, 240, 0, 0, 0, 0]),
    "FOV": (7, [400, 420, 320, 240, 0.9]),
    "SIMPLE_FISHEYE": (14, [200, 320, 240]),
    "EQUIRECTANGULAR": (17, [640, 480]),
}
SIZE = (640, 480)


def colmap_pose(world_from_camera):
    """Quaternion w, x, y, z and translation of camera_from_world."""
    turn = (world_from_camera[:3, :3] @ FLIP).T
    x, y, z, w = Rotation.from_matrix(turn).as_quat()
    return [w, x, y, z, *(-turn @ world_from_camera[:3, 3])]


def write_colmap_text(folder, poses, lens="PINHOLE", camera_of=None):
    folder.mkdir(parents=True, exist_ok=True)
    words = " ".join(map(str, LENSES[lens][1]))
    (folder / "cameras.txt").write_text(
        "# Camera list with one line of data per camera:\n# Number of cameras: 1\n"
        f"7 {lens} {SIZE[0]} {SIZE[1]} {words}\n"
    )
    lines = ["# Image list with two lines of data per image:"]
    for k, pose in enumerate(poses):
        numbers = " ".join(f"{x:.17g}" for x in colmap_pose(pose))
        lines.append(f"{k + 1} {numbers} {camera_of or 7} shot {k}.jpg")
        # Every second photograph has no points at all, which is an empty line.
        lines.append("" if k % 2 else "10.5 20.5 -1 11 12 3")
    (folder / "images.txt").write_text("\n".join(lines) + "\n")
    return folder


def write_colmap_binary(folder, poses, lens="PINHOLE", camera_of=None):
    folder.mkdir(parents=True, exist_ok=True)
    number, parameters = LENSES[lens]
    (folder / "cameras.bin").write_bytes(
        struct.pack("<QIiQQ", 1, 7, number, *SIZE)
        + struct.pack(f"<{len(parameters)}d", *parameters)
    )
    data = struct.pack("<Q", len(poses))
    for k, pose in enumerate(poses):
        data += struct.pack("<I7dI", k + 1, *colmap_pose(pose), camera_of or 7)
        data += f"shot {k}.jpg".encode() + b"\0"
        data += struct.pack("<Q", k % 3) + struct.pack("<ddq", 1.5, 2.5, -1) * (k % 3)
    (folder / "images.bin").write_bytes(data)
    return folder


def transforms(poses, **shared):
    """What `transforms.json` holds."""
    about = {"w": SIZE[0], "h": SIZE[1], "fl_x": 400.0, "fl_y": 420.0, "cx": 320.0, "cy": 240.0}
    frames = [
        {"file_path": f"images/{k}.png", "transform_matrix": pose.tolist()}
        for k, pose in enumerate(poses)
    ]
    return {"camera_model": "OPENCV", **about, **shared, "frames": frames}


def write_transforms(path, poses, **shared):
    path.write_text(json.dumps(transforms(poses, **shared)))
    return path


def write_splat_cameras(path, poses):
    path.write_text(
        json.dumps(
            [
                {
                    "id": k, "img_name": f"{k:05}", "width": SIZE[0], "height": SIZE[1],
                    "position": pose[:3, 3].tolist(),
                    "rotation": (pose[:3, :3] @ FLIP).tolist(), "fx": 400.0, "fy": 420.0,
                }
                for k, pose in enumerate(poses)
            ]
        )
    )  # fmt: skip
    return path
