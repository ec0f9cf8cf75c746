"""How far off responses to things that move within frames are, and what their standard errors say.

.venv/bin/python bench/moving_things.py

A bright disc of 3 deg, and a light of 3 mm 2 m away, pass 21 ommatidia of 5 deg, whose impulse
response is the blowfly's; the same motion of the disc by a head that turns. Responses of more than
a quarter of the largest, of 8 seeds, beside the exact convolution.
"""

import platform

import numpy as np

import omma

WIDTH_RAD = np.radians(5.0)
HALF_WAY_DEG = 30.0


def some_eye() -> omma.Eye:
    azimuths = np.linspace(-10, 10, 21)
    axis = np.array([omma.eye.direction(azimuth, 0) for azimuth in azimuths])
    return omma.Eye(np.zeros_like(axis), axis, WIDTH_RAD)


def convolved(instants, times_s, h):
    """What `instants(times)` gives, (times, ommatidia), as h sees it at `times_s`."""
    delay_s = np.linspace(0, h.duration_s, 3001)
    weight = h.eval(delay_s)
    weight[[0, -1]] /= 2
    weight /= weight.sum()
    fine_s = np.arange(-1.05 * h.duration_s, times_s[-1] + 1e-4, 1e-4)
    seen = instants(fine_s)
    return np.array(
        [[np.interp(t - delay_s, fine_s, one) @ weight for one in seen.T] for t in times_s]
    )


def report(what, samples, exact, renders):
    seen, errors = (np.stack(each)[..., 1].astype(float) for each in zip(*renders, strict=True))
    bright = exact > 0.25 * exact.max()
    off = (seen - exact)[:, bright] / exact[bright]
    claimed = np.sqrt(np.mean((errors[:, bright] / exact[bright]) ** 2))
    one = np.sqrt(np.mean(off**2))
    print(
        f"{what:28s} {samples:5d} {one:9.1%} {claimed:9.1%} "
        f"{np.sqrt(np.mean(off.mean(0) ** 2)):15.1%} {one / claimed:13.2f}"
    )


def main() -> None:
    h = omma.photoreceptors.published_response("blowfly")
    eye = some_eye()
    print(platform.machine())
    print("what passes                   rays  off, rms   claimed  mean of 8 seeds  off / claimed")
    for speed in (100, 200, 400):
        duration_s = 2 * HALF_WAY_DEG / speed
        times_s = np.linspace(0, duration_s, 61)
        disc = omma.stimuli.Target(
            3.0, [0, duration_s], [-HALF_WAY_DEG, HALF_WAY_DEG], [0, 0], target=1.0, background=0.0
        )
        world = disc.world()
        exact = convolved(
            lambda t, disc=disc: disc.expected(eye.axis, np.full(len(eye), WIDTH_RAD), t),
            times_s, h,
        )  # fmt: skip
        for samples in (16, 128, 512):
            renders = [
                omma.Renderer(
                    world, eye, omma.Fixed(samples), impulse_response=h, seed=seed
                ).render(
                    np.stack([np.eye(4)] * len(times_s)), times_s=times_s, instances=disc.names,
                    transforms=disc.transforms(times_s), standard_error=True,
                )
                for seed in range(8)
            ]  # fmt: skip
            report(f"disc, {speed} deg/s", samples, exact, renders)
        if speed != 100:
            continue
        middle = omma.stimuli.Target(3.0, [0, 1], [0, 0], [0, 0], target=1.0, background=0.0)
        turned = omma.poses_from_angles(
            np.zeros((61, 3)),
            np.stack([speed * (duration_s / 2 - times_s)] + [0 * times_s] * 2, -1),
        )
        still = middle.world()
        still.set_transforms(middle.names, middle.transforms(np.zeros(1))[0])
        inside = np.where(np.arange(61)[:, None] > 6, exact, 0)
        for samples in (16, 128, 512):
            renders = [
                omma.Renderer(
                    still, eye, omma.Fixed(samples), impulse_response=h, seed=seed
                ).render(turned, times_s=times_s, standard_error=True)
                for seed in range(8)
            ]
            report("the same, the head turns", samples, inside, renders)
    small_light(eye, h)


def small_light(eye, h) -> None:
    speed, distance_m = 90, 2.0
    times_s = np.linspace(0, 2 * HALF_WAY_DEG / speed, 61)

    def azimuth_rad(t):
        return np.radians(np.clip(speed * t, 0, 2 * HALF_WAY_DEG) - HALF_WAY_DEG)

    glow = omma.scene.Material("glow", base_color=(0, 0, 0, 1), emissive=(1, 1, 1))
    ball = omma.scene.sphere(0.0015).replace(materials=[glow])
    light = omma.light.lamps(bands=omma.light.Bands.equal(3, 450, 650))
    world = omma.World(ball, light=light)
    place = np.tile(np.eye(4), (len(times_s), 1, 1, 1))
    place[:, 0, :3, 3] = distance_m * np.stack(
        [np.sin(azimuth_rad(times_s)), 0 * times_s, -np.cos(azimuth_rad(times_s))], -1
    )
    world.set_transforms([0], place[30])
    straight = int(np.argmax(eye.axis @ (0, 0, -1)))
    at_rest = omma.Renderer(world, eye, omma.Fixed(65536)).render(np.eye(4))[0, straight, 1]

    def instants(t):
        towards = np.stack([np.sin(azimuth_rad(t)), 0 * t, -np.cos(azimuth_rad(t))], -1)
        off = np.arccos(np.clip(towards @ eye.axis.T, -1, 1))
        return float(at_rest) * np.exp(-4 * np.log(2) * (off / WIDTH_RAD) ** 2)

    exact = convolved(instants, times_s, h)
    for samples in (16, 128):
        renders = [
            omma.Renderer(world, eye, omma.Fixed(samples), impulse_response=h, seed=seed).render(
                np.stack([np.eye(4)] * len(times_s)), times_s=times_s,
                instances=[0], transforms=place, standard_error=True,
            )
            for seed in range(8)
        ]  # fmt: skip
        report(f"light of 3 mm, {speed} deg/s", samples, exact, renders)


if __name__ == "__main__":
    main()
