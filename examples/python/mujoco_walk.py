"""A fly-sized body drives past posts in MuJoCo; its two eyes see them pass.

The model is in millimetres. The body is pushed ahead and turns slowly; what it sees is made by
rays, beside physics (docs/mujoco.md). Needs pip install 'omma[mujoco]'.

python examples/python/mujoco_walk.py -o mujoco_walk.png
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import mujoco
import numpy as np

import omma
import omma.mujoco

COLOURS = ((0.75, 0.1, 0.1), (0.1, 0.25, 0.7), (0.05, 0.05, 0.05), (0.9, 0.75, 0.1))
POSTS = [(8 + 5 * (k // 2), (-1) ** k * (4 + 1.5 * (k % 3)), COLOURS[k % 4]) for k in range(8)]
MODEL = """<mujoco><option timestep="0.001" gravity="0 0 -9810"/>
<visual><map zfar="200"/></visual><statistic extent="20"/>
<asset>
  <texture name="sky" type="skybox" builtin="gradient" rgb1="0.45 0.65 0.9" rgb2="0.9 0.9 0.85"
    width="128" height="768"/>
  <texture name="squares" type="2d" builtin="checker" rgb1="0.45 0.4 0.3" rgb2="0.3 0.35 0.2"
    width="256" height="256"/>
  <material name="squares" texture="squares" texrepeat="0.5 0.5" texuniform="true"/>
</asset>
<worldbody>
  <geom name="ground" type="plane" size="0 0 1" material="squares"/>
  POSTS
  <body name="fly" pos="0 0 0.9"><freejoint/>
    <geom name="body" type="ellipsoid" size="1.3 0.6 0.6" mass="1e-3" friction="0 0 0"/></body>
</worldbody></mujoco>"""
POSTS_XML = "".join(
    f'<geom name="post {k}" type="cylinder" size="0.7 3" pos="{x} {y} 3" rgba="{r} {g} {b} 1"/>'
    for k, (x, y, (r, g, b)) in enumerate(POSTS)
)
SPEED_MM_S, TURN_RAD_S, DURATION_S, RATE_HZ = 40.0, 0.35, 0.6, 100


def walk(rays=16):
    """The eye, its path (T, 3) in mm, and what it saw (T, N, 3)."""
    model = mujoco.MjModel.from_xml_string(MODEL.replace("POSTS", POSTS_XML))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    world = omma.mujoco.world_from_model(model, data, hidden=["body"])
    eye = omma.species.drosophila().eye
    renderer = omma.Renderer(world, eye, omma.Fixed(rays))
    millimetres = np.diag([1000.0, 1000, 1000, 1])  # of the model, for an eye in metres
    path, seen = [], []
    for _ in range(round(DURATION_S * RATE_HZ)):
        for _ in range(round(1 / RATE_HZ / model.opt.timestep)):
            ahead = data.body("fly").xmat.reshape(3, 3)[:, 0]
            data.qvel[:2] = SPEED_MM_S * ahead[:2]
            data.qvel[3:6] = 0, 0, TURN_RAD_S
            mujoco.mj_step(model, data)
        omma.mujoco.update(world, data)
        pose = omma.mujoco.head_pose(data, "fly") @ millimetres
        path.append(pose[:3, 3])
        seen.append(renderer.render(pose)[0])
    return eye, world, np.array(path), np.array(seen)


def draw(path, eye, world, way, seen):
    figure = plt.figure(figsize=(9.6, 7.2), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1, 0.9))
    panel = left.subplots()
    panel.set_title("From above, and the way of the body", fontsize=10)
    for x, y, colour in POSTS:
        panel.add_patch(plt.Circle((x, y), 0.7, color=colour))
    panel.plot(way[:, 0], way[:, 1], color="0.3")
    moments = (0, len(seen) // 2, len(seen) - 1)
    for moment in moments:
        panel.plot(way[moment, 0], way[moment, 1], "o", color="#d55e00")
        panel.annotate(f"{(moment + 1) / RATE_HZ:.2f} s", way[moment, :2], xytext=(6, -16),
                       textcoords="offset points", fontsize=9)  # fmt: skip
    panel.set(aspect="equal", xlabel="x, mm", ylabel="y, mm", xlim=(-3, 28), ylim=(-12, 14))
    panel.grid(color="0.9")
    panel.set_axisbelow(True)
    for panel, moment in zip(right.subplots(3, 1), moments):
        # What is farther than 8° from every axis no ommatidium sees: it is hatched.
        picture = omma.picture.equirectangular(eye, seen[moment], 720, 360, max_angle_deg=8)
        panel.imshow(picture, extent=(-180, 180, -90, 90))
        panel.set_title(f"What its {len(eye):,} ommatidia see at {(moment + 1) / RATE_HZ:.2f} s",
                        fontsize=10)  # fmt: skip
        panel.set(yticks=(-90, 0, 90), ylabel="elevation, °", xticks=range(-180, 181, 60))
    panel.set_xlabel("azimuth in the head, ° (left of ahead to right of it)")
    figure.savefig(path, dpi=100)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="mujoco_walk.png", help="the figure")
    parser.add_argument("--rays", type=int, default=16, help="for each ommatidium (default: 16)")
    asked = parser.parse_args()
    eye, world, way, seen = walk(asked.rays)
    gone = np.linalg.norm(way[-1] - way[0])
    print(f"{len(seen)} frames of {len(eye):,} ommatidia; it went {gone:.1f} mm")
    draw(asked.output, eye, world, way, seen)
    print(f"wrote {asked.output}")


if __name__ == "__main__":
    main()
