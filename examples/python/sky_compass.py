"""Where is the sun? Its azimuth from a desert ant's dorsal rim areas alone.

Cataglyphis sees polarisation with 80 ommatidia at the upper rim of each eye: ultraviolet receptors
with crossed microvilli, which work against each other (Labhart & Meyer 2002, Microsc Res Tech
47:368). Here they look at skies that omma computes: clear, half covered with clouds, or through
leaves. They are decoded by a matched filter (Wehner 1989, Trends Neurosci 12:353): the azimuth at
which a template fits best, the electric vectors of single scattering. Two templates are compared:
of the sun on the horizon at all times of day, and of the sun as high as it is. Patterns of both
ends of the line through the sun are alike, so azimuths are sought on the brighter side only.

There is no noise of receptors. Clouds are patches of an overcast sky, without bright edges.

python examples/python/sky_compass.py -o sky_compass.png
"""

import argparse
import dataclasses

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import omma

ELEVATIONS_DEG = (2, 10, 20, 30, 45, 60, 75)
SUN_AZIMUTH_DEG = 0.0
CONDITIONS = ("clear", "clouds", "leaves")
LEAVES_AT_M = 1.0  # above the ground
SEED = 5


def dorsal_rim():
    """Both rims as one eye, each ommatidium with its two ultraviolet receptors."""
    eye = omma.species.cataglyphis().eye
    rim = eye.take(np.flatnonzero(np.array(eye.columns["region"]) == "dorsal rim"))
    crossed = {one.name: one for one in rim.receptor_types if "dorsal rim" in one.name}
    along_and_across = omma.receptors.OmmatidiumType("rim", tuple(crossed.values()))
    return omma.receptors.assign_receptors(rim, along_and_across)


def template(eye, sun_elevation_deg):
    """(360, N): opponent signals under a sky of single scattering with the sun at that elevation,
    at azimuths of 0, 1, ... degrees from straight ahead."""
    axis = eye.axis.astype(float)
    microvilli = omma.receptors.microvillus_direction(eye)[0::2]
    sun = omma.eye.direction(np.arange(360), sun_elevation_deg)
    across = np.cross(axis[None], sun[:, None])  # as long as the sine of the angle to the sun
    sine2 = (across**2).sum(axis=-1)
    along = np.einsum("and,nd->an", across, microvilli)
    return (2 * along**2 - sine2) / (2 - sine2)  # degree sin²/(1 + cos²) times cos 2(angle)


def decode(eye, responses, sun_elevation_deg):
    """The sun's azimuth from straight ahead (P,), degrees, of responses (P, R), with the template
    of a sun at that elevation."""
    first, second = responses[:, 0::2], responses[:, 1::2]
    opponent = (first - second) / np.maximum(first + second, 1e-30)
    expected = template(eye, sun_elevation_deg)
    fit = opponent @ (expected / np.linalg.norm(expected, axis=1, keepdims=True)).T
    # The brighter side: where a plane through the logarithms of brightness goes up.
    plane = np.column_stack([eye.axis.astype(float), np.ones(len(eye))])
    brightness = np.log(np.maximum(first + second, 1e-30))
    slope = np.linalg.lstsq(plane, brightness.T, rcond=None)[0][:3].T
    is_brighter = slope @ omma.eye.direction(np.arange(360), 0).T > 0
    return np.argmax(np.where(is_brighter, fit, -np.inf), axis=1).astype(float)


def light_of(sun_elevation_deg, bands):
    """A clear sky, and one that is overcast, with the sun at an elevation."""
    clear = omma.light.clear_sky(sun_elevation_deg, sun_azimuth_deg=SUN_AZIMUTH_DEG, bands=bands)
    return clear, omma.light.overcast_sky(sun_elevation_deg, bands=bands)


def clouded(clear, overcast, random):
    """A sky of which a random half is overcast, in patches some 20° wide; so is the sun, or not."""
    rows, columns = clear.sky.shape[1:3]
    waves = 9 * random.standard_normal((60, 3))  # a smooth random field over the sphere
    phases = random.uniform(0, 2 * np.pi, 60)

    def field(towards):
        return np.cos(towards @ waves.T + phases).sum(axis=-1)

    azimuth, elevation = np.arange(columns) * 360 / columns, np.linspace(0, 90, rows)
    density = field(omma.eye.direction(azimuth, elevation[:, None]))

    def cover(value):
        return np.clip((value - np.median(density)) / 1.5 + 0.5, 0, 1)

    covered = cover(density)[:, :, None, None]
    grey = np.zeros_like(clear.sky[0])
    grey[:, :, :1] = overcast.sky[0][:, :1]
    sky = clear.sky.copy()
    sky[0] = (1 - covered) * clear.sky[0] + covered * grey
    discs = tuple(
        dataclasses.replace(sun, radiance=sun.radiance * (1 - cover(field(sun.direction))))
        for sun in clear.discs
    )
    return dataclasses.replace(clear, sky=sky, discs=discs, recipe=None)


def leaves(count=22_000):
    """A canopy half a metre deep: leaves 8 cm long at any angle, over a sward. Two of three lines
    up to the sky meet one."""
    random = np.random.default_rng(SEED)
    middle = random.uniform((-2.5, LEAVES_AT_M, -2.5), (2.5, LEAVES_AT_M + 0.5, 2.5), (count, 3))
    length = random.standard_normal((count, 3))
    length /= np.linalg.norm(length, axis=1, keepdims=True)
    width = np.cross(length, random.standard_normal((count, 3)))
    width /= np.linalg.norm(width, axis=1, keepdims=True)
    corners = np.stack(
        [middle - 0.04 * length, middle + 0.025 * width, middle + 0.04 * length,
         middle - 0.025 * width], axis=1
    )  # fmt: skip
    first = 4 * np.arange(count)[:, None]
    faces = (first[:, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    ground = [[-50, 0, 50], [50, 0, 50], [50, 0, -50], [-50, 0, -50]]
    return omma.Scene(
        meshes=[
            omma.scene.Mesh(corners.reshape(-1, 3), faces, material=0),
            omma.scene.Mesh(ground, [[0, 1, 2], [0, 2, 3]], material=1),
        ],
        materials=[omma.scene.natural_material(name) for name in ("green leaf", "green sward")],
    )


def poses(count, random):
    """An ant's head at places near the middle, turned all ways: poses (count, 4, 4), and turns to
    the right (count,), degrees."""
    heading = np.arange(count) * 360 / count
    at = random.uniform((-0.5, 0.01, -0.5), (0.5, 0.01, 0.5), (count, 3))
    ahead = omma.eye.direction(heading, 0)
    return np.stack([omma.look_at(p, p + d) for p, d in zip(at, ahead)]), heading


def errors(elevations=ELEVATIONS_DEG, headings=24, skies=6, rays=64):
    """{condition: (2, elevations, cases)} errors of the azimuth, -180 to 180 degrees, decoded with
    the template of a sun on the horizon and with that of a sun as high as it is."""
    eye = dorsal_rim()
    nm = np.arange(300.0, 701.0)
    seen = omma.receptors.spectral_sensitivity(eye.receptor_types[0], nm)
    bands = omma.light.Bands.from_sensitivities(nm, [seen])  # the one band that these receptors see
    found = {name: [] for name in CONDITIONS}
    random = np.random.default_rng(SEED)
    worlds = {}
    for elevation in elevations:
        clear, overcast = light_of(elevation, bands)
        lights = {
            "clear": [clear],
            "clouds": [clouded(clear, overcast, random) for _ in range(skies)],
            "leaves": [clear],
        }
        for name, of_condition in lights.items():
            if name not in worlds:
                scene = leaves() if name == "leaves" else omma.Scene()
                worlds[name] = omma.World(scene, light=clear, polarized=True, depth=3)
            wrong = []
            for light in of_condition:
                world = worlds[name].with_light(light)
                at, heading = poses(headings, random)
                answers = omma.Renderer(world, eye, omma.Fixed(rays)).render_receptors(at)
                decoded = [decode(eye, answers, assumed) for assumed in (0, elevation)]
                off = np.array(decoded) - (SUN_AZIMUTH_DEG - heading)
                wrong.append((off + 180) % 360 - 180)
            found[name].append(np.concatenate(wrong, axis=1))
    return {name: np.stack(each, axis=1) for name, each in found.items()}


def of_the_line(error_deg):
    """How far the line through the sun is off, whichever its end: -90 to 90 degrees."""
    return (error_deg + 90) % 180 - 90


def draw_sky(panel, eye, elevation=30):
    """The degree of polarisation of a sky with clouds, and where the rims look in it."""
    bands = omma.light.Bands.from_edges([340, 360])
    light = clouded(*light_of(elevation, bands), np.random.default_rng(SEED))
    stokes = light.sky[0, :, :, :, 0]
    degree = np.hypot(stokes[..., 1], stokes[..., 2]) / stokes[..., 0]
    azimuth = np.radians(np.arange(degree.shape[1] + 1) * 360 / degree.shape[1])
    zenith = np.linspace(90, 0, degree.shape[0])
    closed = np.concatenate([degree, degree[:, :1]], axis=1)
    panel.set_theta_zero_location("N")
    drawn = panel.pcolormesh(azimuth, zenith, closed, cmap="magma", vmin=0, vmax=0.8,
                             shading="gouraud", rasterized=True)  # fmt: skip
    x, y, z = eye.axis.T.astype(float)
    panel.scatter(np.arctan2(x, -z), 90 - np.degrees(np.arcsin(y)), s=9, color="#7fd1ff", lw=0)
    panel.scatter([np.radians(SUN_AZIMUTH_DEG)], [90 - elevation], s=60, color="#ffd23f",
                  edgecolor="black", lw=0.7)  # fmt: skip
    panel.set(rlim=(0, 90), yticks=[], xticks=[])
    panel.set_title("degree of polarisation, 350 nm, with clouds;\nblue: where the rims look",
                    fontsize=9)  # fmt: skip
    panel.figure.colorbar(drawn, ax=panel, shrink=0.75, pad=0.05)


def draw(path, elevations, found):
    figure = plt.figure(figsize=(11.5, 3.9), layout="constrained")
    draw_sky(figure.add_subplot(1, 3, 1, projection="polar"), dorsal_rim())
    line, ends = figure.add_subplot(1, 3, 2), figure.add_subplot(1, 3, 3)
    for k, (name, error) in enumerate(found.items()):
        off = np.median(np.abs(of_the_line(error)), axis=2)
        line.plot(elevations, off[1], "o-", ms=4, color=f"C{k}", label=name)
        line.plot(elevations, off[0], "--", lw=1, color=f"C{k}")
        wrong = 100 * (np.abs(error[1]) > 90).mean(axis=1)
        ends.plot(elevations, wrong, "o-", ms=4, color=f"C{k}")
    line.plot([], [], "--", lw=1, color="0.4", label="template of a sun on the horizon")
    line.set(title="error of the line through the sun", ylabel="median, degrees")
    ends.set(title="wrong end of it taken", ylabel="% of headings", ylim=(-2, 60))
    line.set_ylim(bottom=0)
    line.legend(frameon=False, fontsize=8.5)
    for panel in (line, ends):
        panel.set_xlabel("elevation of the sun, degrees")
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=130)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", default="sky_compass.png", help="the figure to write")
    parser.add_argument("--headings", type=int, default=24, help="of the ant (default: 24)")
    parser.add_argument("--rays", type=int, default=64, help="for each ommatidium (default: 64)")
    asked = parser.parse_args()
    found = errors(headings=asked.headings, rays=asked.rays)
    print("median error of the line through the sun, with the template of a sun on the horizon and")
    print("of one as high as it is; how often the wrong end of the line is then taken")
    print("  sun" + "".join(f"{name:>24s}" for name in found))
    for k, elevation in enumerate(ELEVATIONS_DEG):
        cells = []
        for one in found.values():
            low, high = np.median(np.abs(of_the_line(one[:, k])), axis=1)
            cells.append(f"{low:5.1f}° {high:5.1f}° {np.mean(np.abs(one[1, k]) > 90):5.0%}")
        print(f"{elevation:4d}°" + "".join(f"{cell:>24s}" for cell in cells))
    draw(asked.output, ELEVATIONS_DEG, found)
    print(f"wrote {asked.output}")


if __name__ == "__main__":
    main()
