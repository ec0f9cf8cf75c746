"""Writes meadow.glb: a meadow with hills, grass, flowers, trees, a path and a sky.

    python examples/make_meadow.py [file]
    python examples/make_meadow.py --lit [file]

Everything is made here from a fixed seed (NumPy, and Pillow to encode the textures): the same
versions of those give the same bytes. Many plants are few meshes under many nodes. The materials
are unlit; sun, shade and distance haze are baked into the colours to go with the sky called
"simple_sky", which readers of the scene's extras draw.

With --lit it writes meadow_lit.glb: the same triangles, with materials that have spectra and hold
no light, and a pond. That needs omma, for the spectra.
"""

import math
import sys
from pathlib import Path

import numpy as np
from meadow import land, plants, trees
from meadow.glb import add_mesh, append, glb_bytes, join, new_glb
from meadow.lit import EXTENSIONS, POND, add_lit_material, pond, with_brightness
from meadow.paint import LIGHTS, lit_paint, unlit_paint
from meadow.places import (
    BUSHES,
    CROWN,
    DRIFT_COLOURS,
    DRIFTS,
    FLOWER_HEIGHTS,
    HEDGES,
    PETALS,
    STONES,
    TREES,
)
from meadow.shapes import linear, unit

SEED = 20240521
TILE_M = 2.0  # of turf


def quaternion(up, yaw):
    """[x, y, z, w] that turns by yaw about y and then takes y to `up`."""
    axis = np.cross([0, 1, 0], up)
    tilt = unit([*axis, 1 + up[1]])
    spin = np.array([0, math.sin(yaw / 2), 0, math.cos(yaw / 2)])
    a, b = tilt[:3], spin[:3]
    xyz = tilt[3] * b + spin[3] * a + np.cross(a, b)
    return unit([*xyz, tilt[3] * spin[3] - a @ b])


def numbers(values, digits):
    return [round(float(v), digits) + 0.0 for v in values]


def add_node(glb, name, mesh, x, z, yaw=0.0, scale=1.0, upright=0.0, sink=0.0):
    """A node that stands on the ground at (x, z). upright: 0 along the slope's normal, 1 along y.
    sink: how deep the mesh's origin lies in the ground, metres."""
    up = unit(land.normal(np.array(x), np.array(z)) * (1 - upright) + np.array([0, upright, 0]))
    node = {
        "name": name,
        "mesh": mesh,
        "translation": numbers((x, land.height_m(x, z) - sink, z), 3),
        "rotation": numbers(quaternion(up, yaw), 7),
    }
    if scale != 1.0:
        node["scale"] = numbers((scale,) * 3, 3)
    return append(glb, "nodes", node)


def add_group(glb, name, children):
    return append(glb, "nodes", {"name": name, "children": children})


def free_of_path(x, z, margin):
    return land.path_distance_m(x, z) > margin


def scattered(rng, spacing, reach, keep):
    """Jittered grid points within reach of the origin; keep(r) is the share that stays."""
    ticks = np.arange(-reach, reach, spacing)
    x, z = (g.ravel() for g in np.meshgrid(ticks, ticks))
    x, z = x + rng.uniform(0, spacing, x.shape), z + rng.uniform(0, spacing, z.shape)
    r = np.hypot(x, z)
    chosen = (r < reach) & (rng.random(len(r)) < keep(r))
    return list(zip(x[chosen], z[chosen]))


def shadows():
    rows = [(x, z, CROWN[kind][0] * size, CROWN[kind][1] * size) for kind, x, z, size, _ in TREES]
    return rows + [(x, z, 0.9 * size, 0.5 * size) for x, z, size in BUSHES]


def far_drifts(rng):
    """Drifts of flowers all over the meadow, seen from some way off: (kind, x, z, radius)."""
    kinds = list(DRIFT_COLOURS)
    rows = []
    while len(rows) < 60:
        r, angle = 34 * math.sqrt(rng.random()), rng.uniform(0, 2 * math.pi)
        if r > 8:
            kind = kinds[len(rows) % len(kinds)]
            rows.append((kind, r * math.cos(angle), r * math.sin(angle), rng.uniform(1.5, 3.2)))
    return rows


# Grass on cards, kind: (side of the square, cards, strip of the texture, card width, height).
# Large tiles side by side overlap less than many small ones, which a ray tracer thanks us for.
GRASS = {
    "thick turf": (TILE_M, 96, plants.LUSH_STRIP, 0.58, 0.30),
    "turf": (TILE_M, 44, plants.LUSH_STRIP, 0.66, 0.30),
    "thin turf": (TILE_M, 24, plants.LUSH_STRIP, 0.72, 0.30),
    "edge turf": (0.5, 7, plants.LUSH_STRIP, 0.42, 0.24),
    "tall grass": (0.7, 7, plants.TALL_STRIP, 0.70, 0.62),
}


def grass_places(rng):
    """[(kind, x, z, yaw)]: turf in tiles, small patches along the path, tall grass, blades."""
    places = []
    ticks = np.arange(-36, 36, TILE_M) + TILE_M / 2
    for x in ticks:
        for z in ticks:
            r = math.hypot(x, z)
            if r > 36 + rng.normal(0, 1) or rng.random() < 0.012 * (r - 12):
                continue
            if free_of_path(x, z, 0.75 * TILE_M):
                near = "thick turf" if math.hypot(x - BEE[0], z - BEE[2] + 2.5) < 7 else "turf"
                kind = near if r < 22 else "thin turf"
                places.append((kind, x, z, int(rng.integers(4)) * math.pi / 2))
            else:
                offsets = (np.arange(5) + 0.5) * TILE_M / 5 - TILE_M / 2
                for ox in offsets:
                    for oz in offsets:
                        ex, ez = x + ox + rng.normal(0, 0.06), z + oz + rng.normal(0, 0.06)
                        if free_of_path(ex, ez, 0.62):
                            places.append(("edge turf", ex, ez, rng.uniform(0, 7)))
    spots = [(x, z) for x, z in scattered(rng, 1.5, 36, lambda r: 0.75 - 0.3 * r / 36)]
    spots = [(x, z) for x, z in spots if free_of_path(x, z, 0.9)]
    places += [
        ("tall grass", x, z, rng.uniform(0, 7)) for x, z in spots if land.waves(x, z, 11, 20) > 0.05
    ]
    for x, z in scattered(rng, 0.42, 7.5, lambda r: 0.95 - 0.09 * r):
        if free_of_path(x, z, 0.5):
            places.append(("blades", x, z, rng.uniform(0, 7)))
    z = rng.uniform(-14, 6, 340)
    edge = land.path_x(z) + rng.choice([-1, 1], 340) * rng.uniform(0.36, 0.7, 340)
    return places + [("few blades", *p, rng.uniform(0, 7)) for p in zip(edge, z)]


def add_grass(glb, rng, paint):
    meshes = {}
    low, high = linear(48, 66, 24), linear(158, 178, 82)
    for kind in (*GRASS, "blades", "few blades"):
        for i in range(2):
            if kind in GRASS:
                mesh, materials = plants.grass_patch(rng, *GRASS[kind]), paint.cards
            else:
                count, radius, height = (32, 0.25, 0.34) if kind == "blades" else (16, 0.07, 0.24)
                mesh = plants.blade_tuft(rng, count, radius, height, low, high)
                materials = paint.blades
            for light, factor in LIGHTS.items():
                if light in materials:
                    named = f"{kind} {i} {light}"
                    meshes[kind, light, i] = (named, mesh.tinted(factor), materials[light])
    added = {}
    children = []
    tree_shadows = shadows()
    for i, (kind, x, z, yaw) in enumerate(grass_places(rng)):
        if land.shade(x, z, tree_shadows) < 0.75:
            light = "sun" if paint.lit else "shade"
        else:
            light = "dry" if land.waves(x, z, 19, 4) + rng.normal(0, 0.25) > 0.3 else "sun"
        key = (kind, light, i % 2)
        if key not in added:
            added[key] = add_mesh(glb, *meshes[key])
        size = 1.0 if kind.endswith("turf") and kind != "edge turf" else rng.uniform(0.8, 1.2)
        children.append(add_node(glb, f"{kind} {i}", added[key], x, z, yaw, size))
    return add_group(glb, "grass", children)


def add_flowers(glb, rng, paint, drifts):
    children = []
    meshes, far_meshes = {}, {}
    for kind, colour in DRIFT_COLOURS.items():
        make = getattr(plants, kind)
        meshes[kind] = [add_mesh(glb, f"{kind} {i}", make(rng), paint.plants) for i in range(3)]
        size = 0.02 if kind in ("clover", "buttercups") else 0.028
        size = 0.042 if kind == "poppies" else size
        far = plants.far_flowers(rng, colour, 30, 0.9, FLOWER_HEIGHTS[kind], size)
        far = far.of(PETALS[kind])
        far_meshes[kind] = add_mesh(glb, f"drift of {kind}", far, paint.plants)

    def put(kind, mesh, x, z, margin, scale):
        if free_of_path(x, z, margin):
            yaw = rng.uniform(-0.6, 0.6)  # heads keep looking towards the sun
            children.append(add_node(glb, f"{kind} {len(children)}", mesh, x, z, yaw, scale, 0.6))

    for kind, cx, cz, radius, count in DRIFTS:
        for i in range(count):
            r, angle = radius * math.sqrt((i + rng.random()) / count), i * 2.39996
            x, z = cx + r * math.cos(angle), cz + r * math.sin(angle)
            # Nothing in the very face of the camera.
            if all(math.hypot(x - c[0], z - c[2]) > 0.36 for c in (BEE, BEE_LOW)):
                put(kind, meshes[kind][i % 3], x, z, 0.5, rng.uniform(0.85, 1.15))
    kinds = list(meshes)
    for x, z in scattered(rng, 1.25, 17, lambda r: 0.8 - 0.03 * r):
        kind = kinds[int(rng.integers(len(kinds)))]
        put(kind, meshes[kind][int(rng.integers(3))], x, z, 0.5, rng.uniform(0.8, 1.1))
    for kind, cx, cz, radius in drifts:
        for _ in range(int(2.2 * radius**2)):
            r, angle = radius * math.sqrt(rng.random()), rng.uniform(0, 2 * math.pi)
            x, z = cx + r * math.cos(angle), cz + r * math.sin(angle)
            put(f"drift of {kind}", far_meshes[kind], x, z, 1.2, rng.uniform(0.9, 1.2))
    return add_group(glb, "flowers", children)


def add_trees(glb, rng, paint):
    children = []
    for kind in ("oak", "birch"):
        wood, leaves = trees.tree(rng, kind)
        trunk = add_mesh(glb, f"{kind} wood", wood, paint.bark[kind])
        crown = add_mesh(glb, f"{kind} leaves", leaves, paint.leaf)
        for i, (name, x, z, size, yaw) in enumerate(TREES):
            if name == kind:
                node = add_node(glb, f"{kind} {i}", trunk, x, z, yaw, size, 1.0)
                child = append(glb, "nodes", {"name": f"{kind} {i} crown", "mesh": crown})
                glb.document["nodes"][node]["children"] = [child]
                children.append(node)
    bushes = [add_mesh(glb, f"bush {i}", trees.bush(rng), paint.leaf) for i in range(2)]
    for i, (x, z, size) in enumerate(BUSHES):
        yaw = rng.uniform(-0.5, 0.5)
        children.append(add_node(glb, f"bush {i}", bushes[i % 2], x, z, yaw, size, 0.8))
    return add_group(glb, "trees", children)


def add_wood(glb, rng, leaf):
    """The wood on the hills: a dense edge, thinner behind it, and a few lone trees below it."""
    meshes = {}
    for haze in (0.15, 0.3):  # the nearer and the farther trees
        for kind in ("round 0", "round 1", "conifer"):
            tree = trees.far_tree(rng, kind == "conifer")
            # Haze cannot be added to a texture, only multiplied: towards a brighter, bluer leaf.
            tree.colour = np.clip(tree.colour * (1 - haze) + haze * np.array([0.8, 1.0, 1.0]), 0, 1)
            meshes[kind, haze] = add_mesh(glb, f"far tree {kind} haze {haze}", tree, leaf)
    children = []
    for i in range(1000):
        r, angle = rng.uniform(70, 176), rng.uniform(0, 2 * math.pi)
        x, z = r * math.cos(angle), r * math.sin(angle)
        inside = float(land.wooded(x, z))
        # Only the edge and the ridge line can be seen from the meadow.
        chance = 0.03 if inside < 0.3 else (0.7 if r < 150 else 0.4)
        if rng.random() > chance:
            continue
        kind = "conifer" if rng.random() < 0.25 else f"round {i % 2}"
        mesh = meshes[kind, 0.15 if r < 120 else 0.3]
        size = rng.uniform(1.1, 1.9) if inside > 0.3 else rng.uniform(0.8, 1.1)
        yaw = rng.uniform(-0.6, 0.6)
        children.append(add_node(glb, f"far tree {i}", mesh, x, z, yaw, size, 1.0, size))
    for i, (ax, az, bx, bz) in enumerate(HEDGES):
        steps = int(math.hypot(bx - ax, bz - az) / 1.45)
        for k in range(steps):
            x = ax + (bx - ax) * k / steps + rng.normal(0, 0.35)
            z = az + (bz - az) * k / steps + rng.normal(0, 0.35)
            size = rng.uniform(0.26, 0.46) if rng.random() < 0.9 else rng.uniform(0.6, 0.9)
            mesh = meshes[f"round {k % 2}", 0.15]
            yaw = rng.uniform(-0.6, 0.6)
            children.append(add_node(glb, f"hedge {i} {k}", mesh, x, z, yaw, size, 1.0, size))
    return add_group(glb, "wood", children)


# The two low cameras: x, height above the ground, z.
BEE, BEE_LOW = (0.1, 0.66, 4.7), (-1.0, 0.30, 4.3)


def add_camera(glb, name, place, look_at, yfov_deg):
    """place: x, height above the ground, z. look_at: a point relative to the same ground height."""
    x, above, z = place
    ground = float(land.height_m(x, z))
    eye = np.array([x, ground + above, z])
    back = unit(eye - (np.asarray(look_at) + [0, ground, 0]))
    yaw, pitch = math.atan2(back[0], back[2]), -math.asin(back[1])
    turn = [
        math.sin(pitch / 2) * math.cos(yaw / 2),
        math.cos(pitch / 2) * math.sin(yaw / 2),
        -math.sin(pitch / 2) * math.sin(yaw / 2),
        math.cos(pitch / 2) * math.cos(yaw / 2),
    ]
    lens = {"yfov": round(math.radians(yfov_deg), 6), "aspectRatio": 1.777778}
    lens |= {"znear": 0.01, "zfar": 1000}
    camera = append(glb, "cameras", {"name": name, "type": "perspective", "perspective": lens})
    node = {"name": name, "camera": camera, "translation": numbers(eye, 4)}
    return append(glb, "nodes", node | {"rotation": numbers(turn, 7)})


def build(lit=False):
    rng = np.random.default_rng(SEED)
    extensions = EXTENSIONS if lit else ["KHR_materials_unlit"]
    glb = new_glb("Omma examples/make_meadow.py", "The Omma authors, MIT licence", extensions)
    paint = lit_paint(glb, rng) if lit else unlit_paint(glb, rng)
    drifts = far_drifts(rng)
    tints = [(x, z, r, DRIFT_COLOURS[kind], 0.05) for kind, x, z, r in drifts]
    terrain = land.terrain(shadows(), tints)
    if lit:
        terrain = with_brightness(terrain)
    path = land.path_strip(shadows(), tints)
    stone_meshes = [add_mesh(glb, f"stone {i}", trees.stone(rng), paint.stones) for i in range(2)]
    hedges = join([land.hedge_strip(row[:2], row[2:]) for row in HEDGES])
    roots = [
        append(glb, "nodes", {"name": "land", "mesh": add_mesh(glb, "land", terrain, paint.land)}),
        append(glb, "nodes", {"name": "path", "mesh": add_mesh(glb, "path", path, paint.path)}),
        append(
            glb, "nodes", {"name": "verges", "mesh": add_mesh(glb, "verges", hedges, paint.verges)}
        ),
        add_grass(glb, rng, paint),
        add_flowers(glb, rng, paint, drifts),
        add_trees(glb, rng, paint),
        add_wood(glb, rng, paint.leaf),
        add_group(
            glb,
            "stones",
            [
                add_node(glb, f"stone {i}", stone_meshes[i % 2], x, z, 0.4 * (i % 3 - 1), size, 0.5)
                for i, (x, z, size) in enumerate(STONES)
            ],
        ),
        add_camera(glb, "bee", BEE, (0.1, 0.52, 2.7), 58),
        add_camera(glb, "bee-low", BEE_LOW, (-1.5, 0.42, 2.3), 60),
        add_camera(glb, "overview", (2.0, 10.0, 24.0), (0.0, 1.0, -8.0), 52),
    ]
    if lit:
        roots += add_pond(glb)
    extras = {"background-shader": "simple_sky"}
    name = "lit meadow" if lit else "meadow"
    append(glb, "scenes", {"name": name, "nodes": roots, "extras": extras})
    return glb


def add_pond(glb):
    """The pond, and a camera on its bank."""
    water = {"": add_lit_material(glb, "pond water", "pond water")}
    node = {"name": "pond", "mesh": add_mesh(glb, "pond", pond(), water)}
    x, z = POND
    camera = add_camera(glb, "pond", (x + 5.5, 0.5, z - 6.5), (x - 2.0, 0.1, z + 2.0), 50)
    return [append(glb, "nodes", node), camera]


def main():
    arguments = [text for text in sys.argv[1:] if text != "--lit"]
    lit = len(arguments) < len(sys.argv) - 1
    default = Path(__file__).resolve().parent / ("meadow_lit.glb" if lit else "meadow.glb")
    path = Path(arguments[0]) if arguments else default
    glb = build(lit)
    data = glb_bytes(glb)
    path.write_bytes(data)
    document = glb.document
    indices = [[part["indices"] for part in mesh["primitives"]] for mesh in document["meshes"]]
    count = [sum(document["accessors"][i]["count"] // 3 for i in mesh) for mesh in indices]
    drawn = sum(count[node["mesh"]] for node in document["nodes"] if "mesh" in node)
    print(
        f"{path}: {len(data) / 1e6:.2f} MB, {len(document['nodes'])} nodes, {sum(count)} triangles "
        f"stored, {drawn} drawn"
    )


if __name__ == "__main__":
    main()
