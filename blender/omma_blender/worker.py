"""What the add-on has done by the package omma: this file is run by a Python that has it.

Blender brings a Python of its own, in which omma is not installed. So the add-on starts another,
`python worker.py REQUEST`, and never imports this file. REQUEST is a JSON file, an object whose
`task` is the name of a function in TASKS and whose other members are its arguments. Answers are
lines of JSON on standard output, an object each: any number of {"stage": text, "fraction": number
or null} and {"warning": text}, at last {"done": object} or {"error": text}. Arrays go through files
of NumPy's that the request names.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time
import warnings
from pathlib import Path
from typing import Any

# Answers go out where standard output was; what libraries print must not come between them.
_ANSWERS = os.fdopen(os.dup(1), "w", encoding="utf-8")


def say(**answer: Any) -> None:
    print(json.dumps(answer), file=_ANSWERS, flush=True)


def facts() -> dict[str, Any]:
    """What the package offers, by name."""
    import omma

    return {
        "version": omma.__version__,
        "python": sys.executable,
        "species": list(omma.species.names()),
        "materials": list(omma.scene.natural_materials()),
        "projections": list(omma.picture.PROJECTIONS),
    }


def eye(
    *,
    file: str | None = None,
    unit: str = "mm",
    species: str | None = None,
    arrays: str | None = None,
    copy: str | None = None,
) -> dict[str, Any]:
    """Reads an eye, from a file or as a species has it.

    Args:
        arrays: .npz to write: position_m (N, 3), axis (N, 3), acceptance_angle_rad (N,),
            facet_diameter_m (N,), 0 where not known, eye_id (N,), float32 and int32.
        copy: file without ending to write the eye to, lengths in metres, which is how a camera of
            a scene names it: .eye where that is what was read, else .csv, which keeps everything.
    """
    import numpy as np

    import omma

    if file is None:
        read, ending = omma.species.make(species).eye, ".csv"
    else:
        read = omma.load_eye(file, unit)
        ending = ".csv" if omma.eye.eye_file_losses("a.eye", read) else ".eye"
    if arrays is not None:
        facets = np.asarray(read.facet_diameter_m, np.float32)
        np.savez(
            arrays,
            position_m=np.asarray(read.position_m, np.float32),
            axis=np.asarray(read.axis, np.float32),
            acceptance_angle_rad=np.asarray(read.acceptance_angle_rad, np.float32),
            facet_diameter_m=facets if len(facets) else np.zeros(len(read), np.float32),
            eye_id=np.asarray(read.eye_id, np.int32),
        )
    if copy is not None:
        copy += ending
        omma.save_eye(copy, read, "m")
    return {"ommatidia": len(read), "copy": copy}


def material(*, name: str) -> dict[str, Any]:
    """The spectra of a natural material as extras say them, and the colour that it is shown in."""
    import omma

    found = omma.scene.natural_material(name)
    extras: dict[str, Any] = {"spectral_luminance": found.spectral_luminance}
    for part in ("reflectance", "transmittance"):
        spectrum = getattr(found, part)
        if spectrum is not None and len(spectrum.wavelength_nm):
            extras[part] = {
                "wavelength_nm": [float(x) for x in spectrum.wavelength_nm],
                "value": [float(x) for x in spectrum.value],
            }
    return {
        "extras": extras,
        "base_color": [float(x) for x in found.base_color],
        "roughness": float(found.roughness),
        "ior": float(found.ior),
    }


def render(
    *,
    scene: str,
    outputs: list[str],
    camera: str,
    picture: str | None = None,
    light: dict[str, Any] | None = None,
    **options: Any,
) -> dict[str, Any]:
    """`omma render`, by its function `omma.render_file`; the first output is an .npy file.

    Args:
        picture: .npy to write what is to be shown to: float32 (height, width, 3), linear, row 0 at
            the top, NaN where no ommatidium looks.
        light: what lights the scene, see `light_of`; without it, it is not lit.
        options: samples, seed, width, and of an eye kernel (angular sensitivity),
            standard_error and projection.
    """
    import numpy as np

    import omma

    samples, width = options.pop("samples"), options.pop("width")
    projection = options.pop("projection", None)
    loaded = quietly(omma.load_scene, scene)
    is_eye = loaded.camera(camera).type == "compound"
    if light is not None:
        return render_lit(
            loaded, outputs[0], camera, picture, light, samples, width, projection, **options
        )
    report = omma.render_file(
        scene,
        outputs,
        omma.Fixed(samples),
        camera=camera,
        **options,
        # Of an eye's numbers there is no width; it is the picture below that has one.
        **({} if is_eye else {"width": width}),
        progress=lambda stage, fraction: say(stage=stage, fraction=fraction),
    )
    for warning in report.warnings:
        say(warning=warning)
    if picture is not None:
        seen = np.load(outputs[0])
        if is_eye:
            head = omma.picture.camera_eye(loaded, camera)
            seen = omma.picture.project(head, seen[0], projection, width, linear=True)
        np.save(picture, np.asarray(seen, np.float32))
    return {
        "ommatidia": report.ommatidia,
        "rays": report.rays,
        "seconds": report.seconds,
        "outputs": list(report.outputs),
    }


def quietly(function: Any, *arguments: Any) -> Any:
    """A call whose warnings nobody needs, as another says them too."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return function(*arguments)


def render_lit(
    scene: Any,
    output: str,
    camera: str,
    picture: str | None,
    light: dict[str, Any],
    samples: int,
    width: int,
    projection: str | None,
    *,
    seed: int,
    kernel: str = "own",
    standard_error: bool = False,
) -> dict[str, Any]:
    """A camera of a scene that is lit, by paths. The .npy holds photons m⁻² s⁻¹ sr⁻¹ nm⁻¹ in the
    light's bands, (1, N, bands) of an eye and else (height, width, bands); .json says which."""
    import numpy as np

    import omma

    start = time.perf_counter()
    made, rgb_of = light_of(scene, light)
    world = omma.World(
        scene,
        light=made,
        lighting="path",
        ultraviolet="dark",
        progress=lambda fraction: say(stage="Building", fraction=fraction),
    )
    progress = lambda fraction: say(stage="Rendering", fraction=fraction)  # noqa: E731
    errors = None
    if scene.camera(camera).type == "compound":
        head = omma.picture.camera_eye(scene, camera)
        renderer = omma.Renderer(
            world, head, omma.Fixed(samples), seed=seed, angular_sensitivity=kernel
        )
        seen = renderer.render(camera, standard_error=standard_error, progress=progress)
        if standard_error:
            seen, errors = seen
        shown = omma.picture.project(head, rgb_of(seen[0]), projection, width, linear=True)
        ommatidia, rays = len(head), renderer.rays_per_frame * (8 if standard_error else 1)
    else:
        seen = omma.render_camera(
            world, camera, width=width, samples=samples, seed=seed, progress=progress
        )
        shown, ommatidia, rays = rgb_of(seen), 0, seen.shape[0] * seen.shape[1] * samples
    written = [output]
    save_whole(output, seen)
    if errors is not None:
        written.append(str(Path(output).with_suffix(".error.npy")))
        save_whole(written[-1], errors)
    said = {
        "camera": camera,
        "light": light,
        "unit": "photons m-2 s-1 sr-1 nm-1",
        "band_from_nm": [float(x) for x in made.bands.edges_nm[:-1]],
        "band_to_nm": [float(x) for x in made.bands.edges_nm[1:]],
        "samples": samples,
        "seed": seed,
    }
    written.append(str(Path(output).with_suffix(".json")))
    Path(written[-1]).write_text(json.dumps(said, indent=1), encoding="utf-8")
    if picture is not None:
        np.save(picture, np.asarray(shown, np.float32))
    seconds = time.perf_counter() - start
    return {"ommatidia": ommatidia, "rays": rays, "seconds": seconds, "outputs": written}


def save_whole(name: str, values: Any) -> None:
    """An .npy file that is there whole or not at all."""
    import numpy as np

    with open(f"{name}.partial", "wb") as file:
        np.save(file, values)
    os.replace(f"{name}.partial", name)


def light_of(scene: Any, light: dict[str, Any]) -> tuple[Any, Any]:
    """A light, and what makes linear RGB of radiance in its bands.

    Args:
        light: {"kind": "world"}, what the scene's background is, a radiance of 1 being 1 cd/m², as
            lamps are in candelas and surfaces shine in cd/m²; white of 1 cd/m² is shown as 1. Or
            {"kind": "sky", "sun_elevation_deg": ..., "sun_azimuth_deg": ...}, a clear one; white
            matt ground is shown as a luminance of 1.
    """
    import numpy as np

    import omma

    if light["kind"] == "sky":
        sky = omma.light.clear_sky(
            light["sun_elevation_deg"], sun_azimuth_deg=light["sun_azimuth_deg"]
        )
        return sky, lambda radiance: omma.picture.bands_to_rgb(radiance, sky)
    backdrop = scene.background
    if backdrop.type not in ("constant", "image"):
        raise omma.Error(f"{scene.path}: background: expected a colour or a picture")
    picture = np.asarray(backdrop.pixels) if backdrop.type == "image" else None
    if picture is None:
        picture = np.broadcast_to(np.asarray(backdrop.color, np.float32), (4, 8, 3)).copy()
    candela = photons_per_candela()
    made = omma.light.panorama(picture, ultraviolet="dark").scaled(candela)
    white = omma.light.uniform_sky(np.where(made.bands.centers_nm > 400, candela, 0.0))
    of_white = omma.picture.bands_to_rgb(white.radiance((0, 1, 0))[0], white)

    def rgb_of(radiance: Any) -> Any:
        return omma.picture.bands_to_rgb(radiance, white) / of_white

    return made, rgb_of


def photons_per_candela() -> float:
    """Radiance of white of 1 cd/m², in photons m⁻² s⁻¹ sr⁻¹ nm⁻¹: that of a surface that shines so,
    seen."""
    import numpy as np

    import omma

    glowing = omma.scene.Material("glowing", base_color=(0, 0, 0), emissive=(1, 1, 1))
    surface = omma.scene.plane((2, 2)).replace(materials=[glowing])
    dark = omma.World(surface, light=omma.light.uniform_sky(0), lighting="path", ultraviolet="dark")
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], [0.01])
    seen = omma.Renderer(dark, eye, omma.Fixed(16)).render(omma.look_at((0, 1, 0.1), (0, 0, 0)))
    return float(np.max(seen))


TASKS = {task.__name__: task for task in (facts, eye, material, render)}


def main() -> int:
    os.dup2(2, 1)
    request = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # unwinds as Ctrl-C does
    try:
        import omma
    except ImportError as error:
        say(error=f"{sys.executable} has no omma: {error}", missing=True)
        return 1
    try:
        with warnings.catch_warnings():
            warnings.showwarning = lambda message, *_: say(warning=str(message))
            say(done=TASKS[request.pop("task")](**request))
    except (omma.Error, OSError, MemoryError) as error:
        say(error=str(error) or type(error).__name__)
        return 1
    except KeyboardInterrupt:
        say(error="stopped")
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
