"""The tab of the ommatidium that is picked, and its field and rays in the scene."""

from __future__ import annotations

import html
from typing import Any

import numpy as np

from omma.receptors.sensitivity import ommatidium_of_receptor
from omma.view.overlay import PICKED, acceptance_drawing, field_lines, ray_lines, reach_of
from omma.view.page import Page
from omma.view.picked import angles_deg, rays_of
from omma.view.state import Look, Seen

# More rays than these are a solid cone.
_MOST_RAYS = 64
_MOST_BANDS = 40
_NONE = '<p style="margin:4px 12px">None is picked: click on the picture, on the facets of the head or on anything in the scene, or say a number.</p>'  # noqa: E501


class Chosen:
    """Widgets and shapes of the picked ommatidium."""

    def __init__(self, page: Page, gui: Any) -> None:
        self.page = page
        self._number = gui.add_number("Number", 0, min=0, max=len(page.looker.eye) - 1, step=1)
        self._rays = gui.add_checkbox("Its rays in the scene", True)
        self._text = gui.add_html(_NONE)
        self._acceptance = gui.add_html("")
        self._drawn: tuple[Look, int, int] | None = None
        self._shown: tuple[int, float] | None = None
        self._interommatidial_deg = np.degrees(page.looker.eye.interommatidial_angle_rad())

        async def on_number(event: Any) -> None:
            if event.client_id is not None:
                page.choose(int(self._number.value))

        async def on_rays(_: Any) -> None:
            self._drawn = None
            page.choose(page.chosen)

        self._number.on_update(page.guarded(on_number))
        self._rays.on_update(page.guarded(on_rays))

    def show(self, seen: Seen, still: bool) -> None:
        """The numbers of a frame, and where it is still the rays too; in the rendering thread."""
        number = self.page.chosen
        if number is None:
            return
        look = seen.look
        if self._shown != (number, look.acceptance_factor):
            self._shown = (number, look.acceptance_factor)
            self._number.value = number
            eye = self.page.looker.eye_of(look)
            self._acceptance.content = (
                f'<div style="padding:0 12px">{acceptance_drawing(eye, number)}</div>'
            )
        self._text.content = self._numbers(seen, number)
        if still:
            self._draw(look, number)

    def _numbers(self, seen: Seen, number: int) -> str:
        page, look = self.page, seen.look
        eye = page.looker.eye_of(look)
        azimuth, elevation = angles_deg(eye.axis[number].astype(np.float64))
        turn = look.pose.world_from_head[:3, :3]
        world = angles_deg(turn @ eye.axis[number].astype(np.float64))
        rows = [
            ("eye", str(int(eye.eye_id[number]))),
            ("direction in the head", f"{azimuth:.2f}° right, {elevation:.2f}° up"),
            ("direction in the world", f"{world[0]:.2f}° right of −Z, {world[1]:.2f}° up"),
            ("Δρ", f"{np.degrees(eye.acceptance_angle_rad[number]):.3f}°"),
            ("Δφ", f"{self._interommatidial_deg[number]:.3f}°"),
        ]
        if eye.facet_diameter_m[number] > 0:
            rows.append(("facet", f"{1e6 * eye.facet_diameter_m[number]:.1f} µm"))
        text = "".join(
            f"<tr><td>{html.escape(name)}</td><td>{html.escape(value)}</td></tr>"
            for name, value in rows
        )
        text += "".join(
            f'<tr><td>{html.escape(name)}</td><td><span class="omma-response">{value:.7g}</span>'
            + ("" if error is None else f' ± <span class="omma-error">{error:.3g}</span>')
            + "</td></tr>"
            for name, value, error in self._responses(seen, number)
        )
        return (
            f'<table id="omma-chosen" data-number="{number}" style="margin:4px 12px;'
            f'font-size:12px;border-spacing:8px 1px">{text}</table>'
        )

    def _responses(self, seen: Seen, number: int) -> list[tuple[str, float, float | None]]:
        world, eye = self.page.looker.world, self.page.looker.eye
        if seen.receptors is not None:
            mine = np.flatnonzero(np.asarray(ommatidium_of_receptor(eye)) == number)
            values, errors = seen.receptors[mine], seen.receptor_errors
            types = eye.receptor_types
            names = [f"receptor {k}, {types[eye.receptor_type[k]].name}" for k in mine]
            found = None if errors is None else errors[mine]
        else:
            assert seen.responses is not None
            values = seen.responses[number]
            found = None if seen.errors is None else seen.errors[number]
            plain = world.light is None and world.band_from_rgb is None
            names = ["red", "green", "blue"] if plain else [f"band {k}" for k in range(len(values))]
        numbers = values.tolist()[:_MOST_BANDS]
        listed = [None] * len(numbers) if found is None else found.tolist()[:_MOST_BANDS]
        return list(zip(names, numbers, listed, strict=False))

    def _draw(self, look: Look, number: int) -> None:
        page = self.page
        samples = min(look.samples, _MOST_RAYS)
        if self._drawn == (look, number, samples):
            return
        self._drawn = (look, number, samples)
        eye = page.looker.eye_of(look)
        wide = eye.aperture_diameter_m[number] > 0
        scene, matrix = page.server.scene, look.pose.world_from_head
        reach = 30.0
        if not wide:
            rays = rays_of(page.looker, look, number, samples)
            reach = reach_of(rays)
        with page.server.atomic():
            scene.add_line_segments(
                "/picked/field",
                field_lines(eye, matrix, number, reach),
                PICKED,
                thickness=2.0,
                thickness_units="screen",
            )
            if wide or not self._rays.value:
                scene.remove_by_name("/picked/rays")
            else:
                lines, colours = ray_lines(rays)
                scene.add_line_segments(
                    "/picked/rays", lines, colours, thickness=1.5, thickness_units="screen"
                )
