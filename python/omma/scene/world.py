"""The world: a scene ready to be seen, whose things can be moved between two frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Background, Error, Scene
from omma._core import WorldInstance as WorldInstance
from omma.base.arguments import array_of, checked, expect, whole
from omma.base.notebook import html_table, without_folder
from omma.base.pixels import check_radiance, warn_of_background
from omma.base.progress import Progress, share_of
from omma.light import Light
from omma.scene.baking import Bake, BakeCost, BakedInfo, bake_cost, find_baked_light
from omma.scene.device_list import ordinals, prepare_backend
from omma.scene.lighting import (
    LightingName,
    Sun,
    Ultraviolet,
    checked_lighting,
    options_after,
    tell_of_emission,
    tell_of_making,
    tell_of_splats,
)
from omma.scene.open_volumes import tell_of_open_volumes
from omma.scene.rig_parts import RigParts
from omma.scene.without_light import tell_without_light
from omma.scene.world_changes import Changes
from omma.scene.world_colors import Colors, set_color, set_image
from omma.scene.world_moves import (
    Animations,
    at,
    camera_at,
    set_transforms,
    set_vertices,
    vertices,
)
from omma.scene.world_pickles import parts_of

# The share of progress that building has where light is baked too.
_BUILDING = 0.1


class World:
    """A scene with its acceleration structure and background, for any number of renderers.

    What is moved here has moved for all who see it: renderers hold the world itself, not a copy,
    and `copy.copy` gives the same world too. Pickled, it is its scene, its background, what has
    moved and the other arguments below; it is built again where it is unpickled. A deep copy is
    such a world of its own. Worlds are equal only to themselves.

    Args:
        scene: what there is to see.
        background: instead of the scene's own.
        threads: that build it and take pictures; 0 takes one per hardware thread.
        backend: what traces the rays: "embree"; "portable", which is Omma's own and there on every
            processor; "cuda", a graphics card of NVIDIA's; or "": the card where there is one that
            sees a small scene as the processor does (`omma.scene.devices`, docs/install.md), else
            the faster of the others that is built in.
        devices: ordinals of the graphics cards that share the poses of a render, to the same bits,
            such as [0, 1]; () takes the first one.
        band_from_rgb: (B, 3), what linear RGB, as textures, colours and backgrounds have it, is in
            each of 1 to 128 bands (`omma.light.band_from_rgb` makes it); responses are then
            [..., B]. None: the bands are red, green and blue. Not together with ``light``, which
            has bands of its own.
        light: what the world is lit by (`omma.light.clear_sky` and others); radiance is then in its
            bands and its unit, absolute, and its sky replaces a background. None:
            surfaces show their base colour and emission, as they are.
        lighting: "path" follows light over all surfaces for every ray, and has nothing to prepare;
            "baked" first finds the light of the sky and between surfaces, on both sides of every
            triangle, which takes minutes, and looks it up where rays meet them
            (docs/light.md); "unlit" is what it is without ``light``. None: "path" where there
            is light.
        depth: most scatterings on the way of light to the eye: 1 is direct light alone. None: as
            many as it takes, and so always where light is baked.
        polarized: follow light as Stokes vectors, which `Renderer.render_stokes` gives and which
            receptors with microvilli see (`Renderer.render_receptors`).
        ultraviolet: what materials of which only RGB is known reflect below 400 nm: "dark",
            nothing; "as_blue", as much as blue; or a reflectance from 0 to 1, e.g. 0.02 of leaves.
            A mapping {name of a material: one of these} says it for each, "" for those that it does
            not name. None: refused, where there is such a material.
        sun: how the sun is asked for where light is baked: "exact" past a shadow ray for each ray,
            "map" in a shadow map, which is faster and has no penumbra.
        bake: how light is baked, and where it is kept.
        emission_cd_m2: what surfaces that emit white (1, 1, 1) give, cd m⁻²; those whose emission
            has a spectrum say it themselves. Files mean 1 (glTF); some exporters write lamps in
            candelas and emission in watts, for which 683 is right.
        progress: called with the finished share (0 to 1) of the acceleration structure and of
            baking a few times a second. What it raises ends the work and is raised here; so does
            Ctrl-C.

    Raises:
        omma.Error: an argument is out of its range, a material of which nobody says what it
            reflects in the ultraviolet, cells of the size asked for do not fit in memory, there is
            no card that can be used where one is asked for, or this
            is a process made by fork from one that had used a renderer (docs/performance.md).
        TypeError: an argument is of another type.

    Warns:
        UserWarning: triangles are lit by probes, as cells have no room, or what was baked cannot be
            kept; surfaces that emit vanish beside the rest of the light; glass with a thickness is
            no closed mesh; there is a card that is left alone; or a background's picture is
            negative or looks like one in 8 bits.
    """

    @checked
    def __init__(
        self,
        scene: Scene,
        *,
        background: Background | None = None,
        threads: int = 0,
        backend: str = "",
        devices: Sequence[int] = (),
        band_from_rgb: ArrayLike | None = None,
        light: Light | None = None,
        lighting: LightingName | None = None,
        depth: int | None = None,
        polarized: bool = False,
        ultraviolet: Ultraviolet = None,
        sun: Sun = "exact",
        bake: Bake | None = None,
        emission_cd_m2: float = 1.0,
        progress: Progress | None = None,
    ) -> None:
        expect(scene, Scene, "scene", "omma.load_scene gives one")
        if background is not None:
            expect(background, Background, "background", "omma.Background.constant gives one")
        self._scene = scene
        self._background = background
        self._base: World | None = None  # of which this is another background
        # What has moved, and where it was before; shared with such worlds.
        self._moved: dict[int, NDArray[np.float64]] = {}
        self._colors = Colors(scene)  # that changed; shared as well
        # The time of the last `at` and of which animation, where there was one; shared as well.
        self._last_at: list[tuple[float, Animations | None]] = []
        self._changes = Changes()  # how often it was changed; shared as well
        number = whole(threads, "threads", 0, 1 << 16)
        cards = ordinals(devices)
        self._asked = {"threads": number, "backend": backend, "devices": cards}
        self._band_from_rgb: NDArray[np.float64] | None = None
        weights: list[float] = []
        if band_from_rgb is not None:
            self._band_from_rgb = array_of(band_from_rgb, "band_from_rgb", (None, 3))
            weights = self._band_from_rgb.ravel().tolist()
            if not weights:
                raise Error("band_from_rgb: expected at least one band, found none")
        given = checked_lighting(
            light, lighting, depth, polarized, ultraviolet, sun, bake, emission_cd_m2
        )
        self._lighting = given
        tell_of_making(scene)
        if given is None:
            tell_without_light(scene)
        warn_of_background(self.background.pixels)
        for number_of_image, image in enumerate(scene.images):
            if image.pixels.dtype.kind == "f":
                check_radiance(image.pixels[..., :3], f"images[{number_of_image}]")
        tell_of_emission(scene, given)
        tell_of_splats(scene, given)
        tell_of_open_volumes(scene, given)
        self._baked: BakedInfo | None = None
        self._places_when_baked: dict[int, NDArray[np.float64]] = {}
        arguments = None if given is None else given.light_arguments(scene)
        lit = None if given is None or arguments is None else given.for_engine(arguments)
        bakes = given is not None and given.bake is not None
        building = share_of(progress, 0, _BUILDING) if bakes else progress
        chosen = prepare_backend(backend, cards, building)
        self._engine = _core.World(scene, number, background, chosen, cards, weights, lit, building)
        if arguments is not None:
            self._bake(arguments, share_of(progress, _BUILDING, 1))

    def _bake(self, light: dict[str, Any], progress: Progress | None) -> None:
        """Goes on with baked light, where that was asked for, from a world that is lit by paths."""
        lighting = self._lighting
        self._baked = None
        if lighting is None or lighting.bake is None:
            return
        baked, self._baked = find_baked_light(
            self._engine, self._scene, light, lighting.bake, progress
        )
        self._engine = self._engine.with_lighting(lighting.for_engine(light, baked))
        instances = self.instances if self._moved else []
        self._places_when_baked = {k: instances[k].world_from_node for k in self._moved}

    def with_background(self, background: Background) -> World:
        """The same world before another background: what moves in one moves in both.

        Warns:
            UserWarning: what `World` warns of a background's picture.
        """
        expect(background, Background, "background", "omma.Background.constant gives one")
        warn_of_background(background.pixels)
        other = object.__new__(World)
        vars(other).update(vars(self))
        other._background = background
        other._base = self
        other._engine = self._engine.with_background(background)
        return other

    @checked
    def with_light(
        self,
        light: Light,
        *,
        lighting: LightingName | None = None,
        depth: int | None = None,
        polarized: bool | None = None,
        ultraviolet: Ultraviolet = None,
        sun: Sun | None = None,
        bake: Bake | None = None,
        emission_cd_m2: float | None = None,
        progress: Progress | None = None,
    ) -> World:
        """The same world in another light: what moves in one moves in both.

        It shares the acceleration structure; light is baked anew, with things where they are now,
        unless the cache has it (``baked`` says how long it took). What is not given is as in this
        world, where it is lit, but a ``depth`` makes it "path". Arguments, errors and warnings are
        those of `World`. ``world.with_light(world.light, lighting="path")`` is the reference of
        baked light.
        """
        options = options_after(
            self._lighting, lighting=lighting, depth=depth, polarized=polarized,
            ultraviolet=ultraviolet, sun=sun, bake=bake, emission_cd_m2=emission_cd_m2,
        )  # fmt: skip
        other = object.__new__(World)
        vars(other).update(vars(self))
        other._background = other._band_from_rgb = None
        other._base = self
        given = checked_lighting(light, **options)
        assert given is not None
        other._lighting = given
        tell_of_emission(self._scene, given)
        tell_of_splats(self._scene, given)
        if self._lighting is None:
            tell_of_open_volumes(self._scene, given)
        arguments = given.light_arguments(self._scene)
        other._engine = self._engine.with_lighting(given.for_engine(arguments))
        other._bake(arguments, progress)
        return other

    @cached_property
    def _rig_parts(self) -> RigParts:
        """What the scene's animations bend and move."""
        return RigParts(self._scene)

    def __copy__(self) -> World:
        return self

    def __reduce__(self) -> tuple[Callable[..., World], tuple[Any, ...]]:
        return parts_of(self)

    @property
    def scene(self) -> Scene:
        """What there is to see, as it was given: where things are now, `instances` says."""
        return self._scene

    @property
    def background(self) -> Background:
        """What is behind all things in a world without light: its own, else the scene's."""
        return self._scene.background if self._background is None else self._background

    @property
    def instances(self) -> list[WorldInstance]:
        """What can be moved, each with its ``name`` and where it is, ``world_from_node`` (4, 4), m.

        One for each node that places triangles, with all of them, in the order of the file. A new
        list each time, as things are then.
        """
        return self._engine.instances

    def index(self, name: str) -> int:
        """The index in `instances` of what has that name.

        Raises:
            omma.Error: nothing has it, with names that are nearly the same; or several things have,
                with their indices.
        """
        return self._engine.find_instance(name)

    set_transforms = set_transforms
    at = at
    camera_at = camera_at
    set_vertices = set_vertices
    vertices = vertices
    set_image = set_image
    set_color = set_color

    @property
    def bands(self) -> int:
        """Numbers that radiance has: 3, or as many as were asked for."""
        return self._engine.bands

    @property
    def band_from_rgb(self) -> NDArray[np.float64] | None:
        """What linear RGB is in each band, (B, 3); None: the bands are RGB."""
        return self._band_from_rgb

    @property
    def light(self) -> Light | None:
        """What it is lit by; None: surfaces are as they are."""
        return None if self._lighting is None else self._lighting.light

    @property
    def materials_without_ultraviolet(self) -> tuple[str, ...]:
        """Names of materials of which only RGB is known where this world's light reaches below
        400 nm, so that ``ultraviolet`` says what they reflect there; "" stands for surfaces without
        a material. `omma.rendering.ultraviolet_dependence` tells by how much that matters."""
        if self._lighting is None:
            return ()
        return self._lighting.names_without_ultraviolet(self._scene)

    @property
    def lighting(self) -> LightingName:
        """How it is lit: "baked", "path" or "unlit"."""
        return "unlit" if self._lighting is None else self._lighting.lighting

    @property
    def baked(self) -> BakedInfo | None:
        """What was baked, how long that took and how much memory it has; None: nothing was."""
        return self._baked

    def bake_cost(self, bake: Bake | None = None) -> BakeCost:
        """What baking this world would take, found by baking a few of its cells in some seconds.

        Args:
            bake: how light would be baked.

        Raises:
            omma.Error: the world has no light, or baked light already.
            TypeError: ``bake`` is of another type.
        """
        if bake is not None:
            expect(bake, Bake, "bake", "omma.scene.Bake makes one")
        return bake_cost(self._engine, bake or Bake())

    @property
    def depth(self) -> int | None:
        """Most scatterings on the way of light to the eye; None: no limit, or no light."""
        return None if self._lighting is None else self._lighting.depth

    @property
    def emission_cd_m2(self) -> float:
        """What emission of white (1, 1, 1) is, cd m⁻², where the world is lit."""
        return 1.0 if self._lighting is None else self._lighting.emission_cd_m2

    @property
    def polarized(self) -> bool:
        """Whether light is followed as Stokes vectors."""
        return self._lighting is not None and self._lighting.polarized

    @property
    def threads(self) -> int:
        """Threads that build it and take pictures."""
        return self._engine.threads

    @property
    def backend(self) -> str:
        """What traces the rays, with its version; of cards the names of all."""
        return self._engine.backend

    @property
    def build_times(self) -> dict[str, float]:
        """Seconds spent when it was made: scene_s, acceleration_s."""
        return self._engine.build_times

    def __repr__(self) -> str:
        count = len(self.instances)
        lit = {"unlit": "", "path": ", lit by paths", "baked": ", light baked"}[self.lighting]
        return f"<omma.World of {self._scene!r}, {count:,} things{lit}, {self.backend}>"

    def _repr_html_(self) -> str:
        scene = self._scene
        rows = {
            "scene": without_folder(scene.path, scene.path) or "in memory",
            "triangles": f"{scene.triangle_count:,}",
            "things": f"{len(self.instances):,}, {len(self._moved):,} of them moved",
            "cameras": ", ".join(camera.name for camera in scene.cameras),
            "background": repr(self._background or scene.background),
            "light": "none: surfaces are as they are" if self.light is None else repr(self.light),
            "lighting": self.lighting if self._baked is None else f"baked: {self._baked}",
            "bands": "RGB" if self.bands == 3 and self._band_from_rgb is None else str(self.bands),
            "backend": self.backend,
            "threads": str(self.threads),
        }
        return html_table("omma.World", rows)
