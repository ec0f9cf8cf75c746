"""Writes a glTF scene of as many triangles as asked for: rolling hills with a checkerboard, indexed
with 32 bits, for measuring what it takes to load and build large scenes. `.glb`, or `.gltf` with
its numbers in a `.bin` beside it, by the name's ending. The hills are those of bench/scenes.cpp.

    python bench/make_large_scene.py 10000000 hills.glb

As of photogrammetry, in one file of 3.3 GB with photographs of 16,384 pixels a side, and what it
takes to load it, to make a world and to see a frame:

    python bench/make_large_scene.py 40000000 place.glb --pictures 4 --apart
    python bench/large_scene.py place.glb
"""

from __future__ import annotations

import argparse
import base64
import io
import json
import math
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image


def height_m(x: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the ground, m, at x and z, m."""
    return (
        6 * np.sin(0.02 * x) * np.cos(0.017 * z)
        + 0.7 * np.sin(0.31 * x + 0.2 * z)
        + 0.2 * np.sin(1.3 * x) * np.sin(1.1 * z)
    )


def hills(cells: int) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.uint32]]:
    """Positions (V, 3), m, texture coordinates (V, 2) and triangles (T, 3) of a grid over a square
    kilometre; T is 2 cells^2.
    """
    side = np.linspace(-500.0, 500.0, cells + 1)
    z, x = (a.ravel() for a in np.meshgrid(side, side, indexing="ij"))
    positions = np.stack([x, height_m(x, z), z], axis=1).astype("<f4")
    texcoords = np.stack([0.1 * x, 0.1 * z], axis=1).astype("<f4")
    row, column = (a.ravel() for a in np.indices((cells, cells), dtype=np.uint32))
    a = row * np.uint32(cells + 1) + column
    b, c = a + np.uint32(1), a + np.uint32(cells + 1)
    d = c + np.uint32(1)
    return positions, texcoords, np.stack([a, c, b, b, c, d], axis=1).reshape(-1, 3).astype("<u4")


def checkerboard_png(size: int = 256) -> bytes:
    """A grey and yellow checkerboard, 8 squares across."""
    y, x = np.indices((size, size))
    value = ((x // 32 + y // 32) % 2) * 120 + 60 + (x ^ y) % 32
    rgb = np.stack([value, value, np.full_like(value, 90)], axis=-1).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(rgb).save(file, "PNG")
    return file.getvalue()


def photograph(pixels: int, seed: int) -> NDArray[np.uint8]:
    """A JPEG of so many pixels a side: patches with grain, which pack as photographs do."""
    rng = np.random.default_rng(seed)
    patches = rng.integers(40, 200, (pixels // 64 + 1, pixels // 64 + 1, 3), np.uint8)
    colours = patches.repeat(64, axis=0).repeat(64, axis=1)[:pixels, :pixels]
    grain = rng.integers(0, 56, colours.shape, np.uint8)
    file = io.BytesIO()
    Image.fromarray(colours + grain).save(file, "JPEG", quality=90)
    data = file.getvalue()
    return np.frombuffer(data + b"\0" * (-len(data) % 4), np.uint8)


def write_scene(
    path: Path, triangles: int, pictures: int = 0, pixels: int = 16384, apart: bool = False
) -> int:
    """Write the scene; the number of triangles that a square grid makes of ``triangles``.

    With ``pictures`` the ground is in as many strips, each with a photograph of its own; triangles
    that are ``apart`` share no vertices.
    """
    cells = max(1, math.ceil(math.sqrt(triangles / 2)))
    positions, texcoords, indices = hills(cells)
    if apart:
        positions, texcoords = positions[indices.ravel()], texcoords[indices.ravel()]
        indices = np.arange(indices.size, dtype="<u4").reshape(-1, 3)
    strips = np.array_split(indices, max(1, pictures))
    photographs = [photograph(pixels, seed) for seed in range(pictures)]
    arrays = [positions, texcoords, *strips, *photographs]
    sizes = [array.nbytes for array in arrays]
    offsets = np.concatenate([[0], np.cumsum(sizes)]).tolist()
    image = base64.b64encode(checkerboard_png()).decode()
    images: list[dict[str, object]] = [
        {"uri": "data:image/png;base64," + image, "mimeType": "image/png"}
    ]
    if pictures:
        first = 2 + len(strips)
        images = [{"bufferView": first + k, "mimeType": "image/jpeg"} for k in range(pictures)]
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0], "extras": {"background-shader": "simple_sky"}}],
        "nodes": [{"mesh": 0, "name": "hills"}],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
                        "indices": 2 + k,
                        "material": k,
                    }
                    for k in range(len(strips))
                ]
            }
        ],
        "extensionsUsed": ["KHR_materials_unlit"],
        "materials": [
            {
                "doubleSided": True,
                "pbrMetallicRoughness": {"baseColorTexture": {"index": k}},
                "extensions": {"KHR_materials_unlit": {}},
            }
            for k in range(len(strips))
        ],
        "textures": [{"source": k} for k in range(len(images))],
        "images": images,
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": len(positions),
                "type": "VEC3",
                "min": positions.min(axis=0).tolist(),
                "max": positions.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": 5126, "count": len(texcoords), "type": "VEC2"},
            *(
                {"bufferView": 2 + k, "componentType": 5125, "count": one.size, "type": "SCALAR"}
                for k, one in enumerate(strips)
            ),
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": offset, "byteLength": size}
            for offset, size in zip(offsets, sizes, strict=False)
        ],
        "buffers": [{"byteLength": offsets[-1]}],
    }
    binary = path.suffix.lower() == ".glb"
    if not binary:
        beside = path.with_suffix(".bin")
        document["buffers"] = [{"byteLength": offsets[-1], "uri": beside.name}]
        path.write_text(json.dumps(document))
        with beside.open("wb") as file:
            for array in arrays:
                file.write(array.data)
        return len(indices)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with path.open("wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + offsets[-1]))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", offsets[-1], b"BIN\0"))
        for array in arrays:
            file.write(array.data)
    return len(indices)


def main() -> None:
    parser = argparse.ArgumentParser(description="Write a large scene of rolling hills.")
    parser.add_argument("triangles", type=int, help="how many, at least")
    parser.add_argument("file", type=Path, help="hills.glb, or hills.gltf with its .bin")
    parser.add_argument("--pictures", type=int, default=0, help="photographs, each on a strip")
    parser.add_argument("--pixels", type=int, default=16384, help="a side of each")
    parser.add_argument("--apart", action="store_true", help="triangles share no vertices")
    given = parser.parse_args()
    written = write_scene(given.file, given.triangles, given.pictures, given.pixels, given.apart)
    print(f"{given.file}: {written:,} triangles")


if __name__ == "__main__":
    main()
