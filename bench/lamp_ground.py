"""How far off responses to ground below many lamps are, and what their standard errors say.

.venv/bin/python bench/lamp_ground.py

289 ommatidia of 0.1 deg look at a matt plane below point lamps of 100 cd, 4 m up on a grid of 6 m:
one render each, beside the sum over all lamps of I cos / d^2. Then one lamp of 100 cd, 5 m up,
under a full moon, over grounds of different sizes. And some of the first lamps beside one, 500
times as strong, whose light reaches no place there: one that points upwards, two and nine that do,
one in a cellar, one behind a wall. Last, how often single responses are beyond three of their
standard errors: of two lamps beside a strong one behind a wall, and of a panel whose texture shines
on one half.
"""

import platform

import numpy as np

import omma

SPACING_M, UP_M, REFLECTANCE = 6.0, 4.0, 0.5
FINE = omma.Fixed(16384)


def lamps_on_a_grid(count: int) -> np.ndarray:
    """Places of lamps, (count, 3), a little off their grid."""
    side = int(np.ceil(count**0.5))
    column, row = np.arange(count) % side, np.arange(count) // side
    off_m = np.random.default_rng(2).uniform(-1, 1, (count, 2))
    level = (np.stack([column, row], 1) - (side - 1) / 2) * SPACING_M + off_m
    return np.stack([level[:, 0], np.full(count, UP_M), level[:, 1]], 1)


def world_of(places_m: np.ndarray) -> omma.World:
    lights = []
    for number, place in enumerate(places_m):
        world_from_light = np.eye(4)
        world_from_light[:3, 3] = place
        lights.append(
            omma.scene.PunctualLight(
                f"lamp {number}", intensity=100, world_from_light=world_from_light
            )
        )
    matt = omma.scene.Material(specular=0, base_color=(REFLECTANCE,) * 3)
    ground = omma.scene.plane((400, 400)).replace(lights=lights, materials=[matt])
    light = omma.light.lamps(bands=omma.light.Bands.equal(1, 540, 560), unit="watts")
    return omma.World(ground, light=light, depth=1)


def main() -> None:
    at = np.linspace(-8, 8, 17)
    places = np.stack(np.meshgrid(at, [0.0], at, indexing="ij"), -1).reshape(-1, 3)
    axes = places - (0, 1, 0)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    eye = omma.Eye(np.zeros_like(axes), axes, np.radians(0.1))
    pose = np.eye(4)
    pose[1, 3] = 1
    unit = one_lamp(pose)
    print(f"{platform.machine()}, {len(eye)} ommatidia, standard errors by 8 times as many rays")
    print("lamps  rays  off by, rms  claimed, rms  median/true  |z| > 3")
    for count, samples in ((10, 16), (100, 16), (300, 16), (1000, 16), (300, 64)):
        lamps = lamps_on_a_grid(count)
        away = lamps[None] - places[:, None]
        distance = np.linalg.norm(away, axis=2)
        true = (away[..., 1] / distance**3).sum(1)
        response, error = omma.Renderer(world_of(lamps), eye, omma.Fixed(samples)).render(
            pose, standard_error=True
        )
        found, claimed = response[0, :, 0].astype(float), error[0, :, 0].astype(float)
        off, said = found / (unit * true) - 1, claimed / (unit * true)
        print(
            f"{count:5d} {samples:5d} {np.sqrt(np.mean(off**2)):11.1%} "
            f"{np.sqrt(np.mean(said**2)):12.1%} {np.median(off) + 1:12.3f} "
            f"{np.mean(np.abs(off) > 3 * said):8.1%}"
        )
    lamp_under_moon()
    lamps_that_do_not_reach(eye, pose)
    beyond_three_errors(eye.take(range(0, len(eye), 16)), pose)


def lamp_under_moon() -> None:
    bands = omma.light.Bands.equal(3, 400, 700)
    moon, dark = omma.light.moonlit_sky(45, bands=bands), omma.light.lamps(bands=bands)
    eye = omma.eye.generate_eye(1000)
    eye = eye.take(np.flatnonzero(eye.axis[:, 1] < -0.8))
    pose = omma.poses_from_angles((2, 1.5, 0), (0, 0, 0))
    matt = omma.scene.Material(specular=0, base_color=(REFLECTANCE,) * 3)
    world_from_light = np.eye(4)
    world_from_light[1, 3] = 5
    lamp = omma.scene.PunctualLight("lamp", intensity=100, world_from_light=world_from_light)

    def seen(scene, light, samples, seed=0):
        renderer = omma.Renderer(omma.World(scene, light=light), eye, samples, seed=seed)
        response, error = renderer.render(pose, standard_error=True)
        return response[0, :, 1].astype(float), error[0, :, 1].astype(float)

    print("ground, m  rays           off by, rms  claimed, rms")
    for size in (20, 200, 2000):
        ground = omma.scene.plane((size, size)).replace(materials=[matt])
        lit = ground.replace(lights=[lamp])
        true = seen(lit, dark, omma.Fixed(1024))[0] + seen(ground, moon, omma.Fixed(1024))[0]
        samplings = {
            "Fixed(16)": omma.Fixed(16),
            "ToError(0.05)": omma.ToError(relative_error=0.05),
        }
        for name, samples in samplings.items():
            off, said = [], []
            for seed in range(8):
                found, claimed = seen(lit, moon, samples, seed)
                off.append(found / true - 1)
                said.append(claimed / true)
            rms = [np.sqrt(np.mean(np.square(values))) for values in (off, said)]
            print(f"{size:9d}  {name:14s} {rms[0]:11.2%} {rms[1]:13.2%}")


def lamps_that_do_not_reach(eye: omma.Eye, pose: np.ndarray) -> None:
    upwards = np.array([[1, 0, 0, 3], [0, 0, -1, 0.5], [0, 1, 0, 0], [0, 0, 0, 1]], float)
    below = np.eye(4)
    below[:3, 3] = 3, -1, 0
    strong = {"intensity": 50_000}
    cone = {"inner_cone_rad": 0.2, "outer_cone_rad": 0.4}
    spot = omma.scene.PunctualLight("up", type="spot", world_from_light=upwards, **cone, **strong)
    several = [spot]
    for number in range(1, 9):
        elsewhere = upwards.copy()
        elsewhere[:3, 3] = 5 * (number % 3) - 6, 0.5, 4 - 3 * (number // 3)
        several.append(spot.replace(name=f"up {number}", world_from_light=elsewhere))
    cellar = omma.scene.PunctualLight("cellar", world_from_light=below, **strong)
    walled, wall = lamp_behind_wall()
    beside = {
        "up": [spot], "two up": several[:2], "nine up": several, "cellar": [cellar],
        "behind wall": [walled],
    }  # fmt: skip
    print("lamps  beside       off by, rms  claimed  median/true  0 +- 0  ToError(0.05)")
    for count in (1, 10, 20):
        world = world_of(lamps_on_a_grid(count))
        true = omma.Renderer(world, eye, omma.Fixed(1024)).render(pose)[0, :, 0]
        for name, lamps in beside.items():
            scene = world.scene.replace(lights=[*world.scene.lights, *lamps])
            if walled in lamps:
                scene = omma.scene.merge_scenes([scene, wall])
            both = omma.World(scene, light=world.light, depth=1)
            response, error = omma.Renderer(both, eye, omma.Fixed(16)).render(
                pose, standard_error=True
            )
            found, claimed = response[0, :, 0] / true, error[0, :, 0]
            reached = omma.Renderer(both, eye, omma.ToError(relative_error=0.05)).render(pose)
            off = np.sqrt(np.mean((reached[0, :, 0] / true - 1) ** 2))
            dark = np.mean((found == 0) & (claimed == 0))
            print(
                f"{count:5d}  {name:11s} {np.sqrt(np.mean((found - 1) ** 2)):12.1%} "
                f"{np.sqrt(np.mean((claimed / true) ** 2)):8.1%} {np.median(found):12.3f} "
                f"{dark:7.1%} {off:14.1%}"
            )


def lamp_behind_wall() -> tuple[omma.scene.PunctualLight, omma.Scene]:
    behind = np.eye(4)
    behind[:3, 3] = 0, 3, 30
    lamp = omma.scene.PunctualLight("behind wall", world_from_light=behind, intensity=50_000)
    black = omma.scene.Material(specular=0, base_color=(0, 0, 0, 1), double_sided=True)
    upright = np.array([[1, 0, 0, 0], [0, 0, -1, 5], [0, 1, 0, 25], [0, 0, 0, 1]], float)
    wall = omma.scene.plane((200, 30)).replace(
        materials=[black], instances=[omma.scene.Instance(0, upright, name="wall")]
    )
    return lamp, wall


def panel(width_m: float, texture: omma.scene.Image | None) -> omma.Scene:
    """Shines down from 2 m; of a texture its left half is seen there."""
    x = np.array([0, width_m, width_m, 0]) - 0.5
    corner = np.stack([x, np.full(4, 2.0), [-0.3, -0.3, 0.3, 0.3]], 1)
    glowing = omma.scene.Material(
        specular=0, base_color=(0, 0, 0, 1), emissive=(1, 1, 1), double_sided=True,
        emissive_texture=None if texture is None else 0,
    )  # fmt: skip
    mesh = omma.scene.Mesh(
        corner, [[0, 1, 2], [0, 2, 3]], material=0,
        texture_coordinates=[[0, 0], [width_m, 0], [width_m, 1], [0, 1]],
    )  # fmt: skip
    if texture is None:
        return omma.Scene(meshes=[mesh], materials=[glowing])
    nearest = [omma.scene.Texture(0, filter="nearest")]
    return omma.Scene(meshes=[mesh], materials=[glowing], images=[texture], textures=nearest)


def beyond_three_errors(eye: omma.Eye, pose: np.ndarray) -> None:
    ground = world_of(lamps_on_a_grid(2))
    lamp, wall = lamp_behind_wall()
    walled = ground.scene.replace(lights=[*ground.scene.lights, lamp])
    dark = ground.scene.replace(lights=[])
    half = omma.scene.Image(np.float32([[[1, 1, 1], [0, 0, 0]]]))
    cases = (
        ("two lamps, one hidden", omma.scene.merge_scenes([walled, wall]), ground.scene),
        (
            "half a panel by texture",
            omma.scene.merge_scenes([dark, panel(1.0, half)]),
            omma.scene.merge_scenes([dark, panel(0.5, None)]),
        ),
    )
    poses = np.repeat(pose[None], 200, 0)
    print("lit by                   rays  off by, rms  claimed  |z| > 3")
    for name, scene, alike in cases:
        of_truth = omma.Renderer(omma.World(alike, light=ground.light, depth=1), eye, FINE)
        true = of_truth.render(pose)[0, :, 0].astype(float)
        world = omma.World(scene, light=ground.light, depth=1)
        for samples in (16, 64):
            renderer = omma.Renderer(world, eye, omma.Fixed(samples), noise="new_every_frame")
            response, error = renderer.render(poses, standard_error=True)
            off, claimed = response[..., 0] / true - 1, error[..., 0] / true
            print(
                f"{name:24s} {samples:4d} {np.sqrt(np.mean(off**2)):12.1%} "
                f"{np.sqrt(np.mean(claimed**2)):8.1%} {np.mean(np.abs(off) > 3 * claimed):8.1%}"
            )


def one_lamp(pose: np.ndarray) -> float:
    """What ground straight below one lamp sends, times the square of its distance."""
    eye = omma.Eye([[0, 0, 0]], [[0, -1, 0]], np.radians(0.1))
    world = world_of(np.array([[0.0, UP_M, 0.0]]))
    return float(omma.Renderer(world, eye, omma.Fixed(64)).render(pose)[0, 0, 0]) * UP_M**2


if __name__ == "__main__":
    main()
