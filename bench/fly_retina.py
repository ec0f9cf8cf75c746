"""FlyGym's retina and ours: contrast of gratings beside a Gaussian acceptance, and time of a frame.

    python bench/fly_retina.py [--frames 20]

Writes bench/results/mujoco_gratings.csv and bench/results/mujoco.csv. The first needs NumPy:
FlyGym's way is done anew here from its published facts (a rectilinear camera of 512 x 450 pixels,
157 degrees, eight bits, a fisheye lens by nearest pixels, the mean over hexagons of pixels). The
second takes FlyGym itself where it is installed, and else a model of posts about a head, of which
FlyGym's way is only MuJoCo's two pictures.
"""

import argparse
import csv
import os
import time
from pathlib import Path

import numpy as np

import omma
import omma.mujoco

RESULTS = Path(__file__).parent / "results"
ROWS, COLUMNS, FOVY_DEG, DISTORTION, ZOOM = 512, 450, 157.0, 3.8, 2.72
RINGS, PITCH = 15, 16.5  # of the hexagonal lattice; pixels between neighbours in a column
PER_DEGREE = (0.01, 0.02, 0.04, 0.06, 0.08, 0.1, 0.125, 0.15, 0.2)


def hexagonal_map():
    """FlyGym's map of ommatidia from its facts: (512, 450), 1 to 721, columns from the left."""
    row, column = np.mgrid[:ROWS, :COLUMNS]
    middles, numbers, count = [], [], 0
    for q in range(-RINGS - 1, RINGS + 2):
        for r in range(-2 * RINGS - 2, 2 * RINGS + 3):
            there = max(abs(q), abs(r), abs(q + r)) <= RINGS
            if there or max(abs(q), abs(r), abs(q + r)) <= RINGS + 1:
                across = PITCH * 3**0.5 / 2 * q
                middles.append(((ROWS - 1) / 2 + PITCH * (r + q / 2), (COLUMNS - 1) / 2 + across))
                count += there
                numbers.append(count if there else 0)
    nearest = np.full((ROWS, COLUMNS), np.inf)
    found = np.zeros((ROWS, COLUMNS), int)
    for (y, x), number in zip(middles, numbers):
        away = (row - y) ** 2 + (column - x) ** 2
        closer = away < nearest
        nearest[closer], found[closer] = away[closer], number
    # Beyond the ring outside of the lattice all is nobody's.
    return found


def grating_picture(per_degree, phase_rad, samples=4):
    """What the camera sees of a grating over azimuth: (512, 450), 0 to 1 in steps of 1/255."""
    half = np.tan(np.radians(FOVY_DEG) / 2)
    inside = (np.arange(COLUMNS * samples) + 0.5) / samples
    x = half * COLUMNS / ROWS * (2 * inside / COLUMNS - 1)
    light = 0.5 + 0.5 * np.cos(2 * np.pi * per_degree * np.degrees(np.arctan(x)) + phase_rad)
    # Azimuth depends on the column alone.
    line = np.rint(255 * light.reshape(COLUMNS, samples).mean(axis=1)) / 255
    return np.tile(line, (ROWS, 1))


def bent(picture):
    """The camera's picture behind the fisheye lens, by nearest pixels; 0 where it shows nothing."""
    row, column = np.mgrid[:ROWS, :COLUMNS].astype(float)
    down, right = (2 * row - ROWS) / ROWS / ZOOM, (2 * column - COLUMNS) / COLUMNS / ZOOM
    shrink = 1 - DISTORTION * (down**2 + right**2) + 1e-6
    source_row = ((down / shrink + 1) * ROWS / 2).astype(int)
    source_column = ((right / shrink + 1) * COLUMNS / 2).astype(int)
    inside = (0 <= source_row) & (source_row < ROWS)
    inside &= (0 <= source_column) & (source_column < COLUMNS)
    found = np.zeros_like(picture)
    found[inside] = picture[source_row[inside], source_column[inside]]
    return found


def pooled(picture, ids):
    """FlyGym's means over hexagons of the bent picture: (N,)."""
    total = np.bincount(ids[ids > 0], bent(picture)[ids > 0])[1:]
    return total / np.bincount(ids[ids > 0])[1:]


def seen(per_degree, phase_rad, eye, samples=256):
    """What our ommatidia see of the same grating: (N,)."""
    azimuth_deg = (np.arange(8192) + 0.5) / 8192 * 360 - 180
    light = 0.5 + 0.5 * np.cos(2 * np.pi * per_degree * azimuth_deg + phase_rad)
    image = np.tile(light.astype(np.float32)[None, :, None], (2, 1, 3))
    scene = omma.Scene(background=omma.Background.image(image))
    return omma.Renderer(scene, eye, omma.Fixed(samples)).render(np.eye(4))[0, :, 1].astype(float)


def contrast(of_phase):
    """The transfer of each ommatidium from its answers to a grating at two phases."""
    return 2 * np.hypot(*(of_phase(phase) - 0.5 for phase in (0.0, np.pi / 2)))


def grating_table(ids):
    """(spatial frequency, field, ours, FlyGym's, Gaussian, largest difference of ours)."""
    eye = omma.mujoco.fly_eye(ids)
    azimuth, elevation = omma.eye.azimuth_elevation_deg_of(eye.axis)
    level = np.abs(elevation) < 6
    fields = {"0 to 25": level & (np.abs(azimuth) < 25),
              "45 to 65": level & (np.abs(azimuth) > 45) & (np.abs(azimuth) < 65)}  # fmt: skip
    width = np.degrees(eye.acceptance_angle_rad.astype(float))
    rows = []
    for nu in PER_DEGREE:
        ours = contrast(lambda phase, nu=nu: seen(nu, phase, eye))
        theirs = contrast(lambda phase, nu=nu: pooled(grating_picture(nu, phase), ids))
        gaussian = np.exp(-((np.pi * nu * width) ** 2) / (4 * np.log(2)))
        for name, field in fields.items():
            rows.append((
                nu, name, width[field].mean(), gaussian[field].mean(), ours[field].mean(),
                theirs[field].mean(), np.abs(ours - gaussian)[field].max(),
                np.abs(theirs - gaussian)[field].max(),
            ))  # fmt: skip
    return rows


def flygym_simulation():
    """A fly on its six legs among posts in FlyGym; None where it is not installed."""
    try:
        from flygym import Simulation
        from flygym.anatomy import ActuatedDOFPreset, AxisOrder, JointPreset, Skeleton
        from flygym.compose import ActuatorType, FlatGroundWorld, KinematicPosePreset, NeuroMechFly
        from flygym.utils.math import Rotation3D
    except ImportError:
        return None
    fly = NeuroMechFly(name="fly")
    # As in FlyGym's own benchmark: joints of the legs, held in a neutral pose by actuators.
    stance = KinematicPosePreset.NEUTRAL
    skeleton = Skeleton(axis_order=AxisOrder.YAW_PITCH_ROLL, joint_preset=JointPreset.LEGS_ONLY)
    fly.add_joints(skeleton, neutral_pose=stance)
    legs = skeleton.get_actuated_dofs_from_preset(ActuatedDOFPreset.LEGS_ACTIVE_ONLY)
    fly.add_actuators(legs, ActuatorType.POSITION, kp=50.0, neutral_input=stance)
    fly.add_leg_adhesion()
    fly.add_vision()
    fly.colorize()
    world = FlatGroundWorld()
    world.add_fly(fly, (0, 0, 1.2), Rotation3D("quat", (1, 0, 0, 0)))
    rng = np.random.default_rng(0)
    for k in range(12):
        angle, away = 2 * np.pi * k / 12 + 0.2, 6 + 4 * rng.random()
        world.mjcf_root.worldbody.add_geom(
            name=f"post {k}", type=5, pos=(away * np.cos(angle), away * np.sin(angle), 2),
            size=(0.5 + 0.6 * rng.random(), 2, 0), rgba=(*rng.random(3), 1),
        )  # fmt: skip
    simulation = Simulation(world)
    simulation.reset()
    simulation.forward()
    return simulation


POSTS = "".join(
    f'<geom type="cylinder" size="0.6 2" rgba="{k / 12} 0.5 {1 - k / 12} 1" '
    f'pos="{8 * np.cos(k / 1.9)} {8 * np.sin(k / 1.9)} 2"/>'
    for k in range(12)
)
HEAD = f"""<mujoco><visual><map znear="0.005"/></visual><statistic extent="10"/><worldbody>
<geom type="plane" size="0 0 1" rgba="0.3 0.3 0.3 1"/>{POSTS}
<body name="head" pos="0 0 1.5"><freejoint/><geom type="sphere" size="0.3" group="2"/>
<camera name="left" euler="90 -60 0" fovy="157"/><camera name="right" euler="90 60 0" fovy="157"/>
</body></worldbody></mujoco>"""


def head_among_posts(ids):
    """What steps, what looks FlyGym's way and what looks ours, without FlyGym."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(HEAD)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pictures = mujoco.Renderer(model, ROWS, COLUMNS)
    world = omma.mujoco.world_from_model(model, data, groups=[0], colors="linear")
    renderer = omma.Renderer(world, omma.mujoco.fly_eye(ids), omma.Fixed(16))

    def look():
        for camera in ("left", "right"):
            pictures.update_scene(data, camera)
            pictures.render()

    def look_by_rays():
        omma.mujoco.update(world, data)
        cameras = [omma.mujoco.camera(data, name) for name in ("left", "right")]
        renderer.render(np.stack([one.world_from_camera for one in cameras]))

    return lambda: mujoco.mj_step(model, data), look, look_by_rays


def timed(function, times=1):
    """Seconds by the clock and of all threads."""
    begun, at = time.perf_counter(), time.process_time()
    for _ in range(times):
        function()
    return time.perf_counter() - begun, time.process_time() - at


def times_of_frames(ids, frames, steps=10):
    """Rows of (what, by whom, milliseconds by the clock, of all threads), medians over frames."""
    simulation = flygym_simulation()
    if simulation is None:
        whose = "MuJoCo's two pictures alone"
        step, look, look_by_rays = head_among_posts(ids)
    else:
        whose = "FlyGym"
        retina = omma.mujoco.FlyRetina(simulation)
        step = simulation.step
        look = lambda: simulation.get_ommatidia_readouts("fly")  # noqa: E731
        look_by_rays = lambda: retina.get_ommatidia_readouts("fly")  # noqa: E731
    measured = {f"{steps} steps of physics": [], whose: [], "omma, 16 rays": []}
    for _ in range(frames + 2):  # in turns, so that what else the machine does meets all
        measured[f"{steps} steps of physics"].append(timed(step, steps))
        measured[whose].append(timed(look))
        measured["omma, 16 rays"].append(timed(look_by_rays))
    return [(what, *np.median(1e3 * np.array(each[2:]), axis=0)) for what, each in measured.items()]


def write(path, header, rows):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for row in rows:
            writer.writerow([f"{one:.4g}" if isinstance(one, float) else one for one in row])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=20, help="timed (default: 20)")
    asked = parser.parse_args()
    os.environ.setdefault("MUJOCO_GL", "egl")
    ids = hexagonal_map()
    gratings = grating_table(ids)
    print("cycles/deg  azimuth   width  Gaussian  omma    FlyGym's way")
    for nu, field, width, gaussian, ours, theirs, _, _ in gratings:
        print(f"{nu:8.3f}  {field:>9} {width:6.2f} {gaussian:8.3f} {ours:7.3f} {theirs:10.3f}")
    write(
        RESULTS / "mujoco_gratings.csv",
        ["cycles_per_degree", "azimuth_deg", "acceptance_angle_deg", "gaussian", "omma",
         "flygym_way", "omma_largest_difference", "flygym_way_largest_difference"],
        gratings,
    )  # fmt: skip
    times = times_of_frames(ids, asked.frames)
    for what, clock, threads in times:
        print(f"{what:>30}: {clock:8.2f} ms by the clock, {threads:8.2f} ms of all threads")
    (_, *theirs), (_, *ours) = times[1:]
    ratios = ("theirs over ours", theirs[0] / ours[0], theirs[1] / ours[1])
    print(f"{ratios[0]}: {ratios[1]:.1f}, {ratios[2]:.1f}")
    header = ["what, of 1442 ommatidia", "clock_ms", "all_threads_ms"]
    write(RESULTS / "mujoco.csv", header, [*times, ratios])


if __name__ == "__main__":
    main()
