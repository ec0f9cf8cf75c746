"""The tab of the head: where it is, its steps, its speed, the scene's cameras."""

from __future__ import annotations

from typing import Any

import numpy as np

from omma.view.page import Page
from omma.view.page_texts import FLY
from omma.view.poses import HeadPose, pose_from_matrix, stepped, turned_aside

SLOWEST_M_S, FASTEST_M_S = 1e-4, 1e3
_BUTTONS = (("Ahead", "Back", "Left", "Right"), ("Up", "Down", "Turn left", "Turn right"))


class Head:
    """Widgets of the head's pose."""

    def __init__(self, page: Page, gui: Any, guarded: Any) -> None:
        self.page = page
        pose = page.live.look.pose
        self._position = gui.add_vector3("Position, m", pose.position_m, step=0.01)
        self._angles = gui.add_vector3(
            "Turned, °", (pose.yaw_deg, pose.pitch_deg, pose.roll_deg), step=0.5,
            hint="Yaw to the right, pitch up, roll: right side down",
        )  # fmt: skip
        gui.add_html(FLY)
        size_m = page.scene.head_m
        self._speed = gui.add_number(
            "Speed, m/s", float(f"{4 * size_m:.1g}"), min=SLOWEST_M_S, max=FASTEST_M_S,
            hint="Of flying; the wheel changes it, or the keys . and ,",
        )  # fmt: skip
        cameras = [camera.name for camera in page.looker.world.scene.cameras]
        if cameras:
            go = gui.add_dropdown("Go to camera", ["…", *cameras])

            async def on_go(_: Any) -> None:
                if go.value in cameras:
                    which = cameras.index(go.value)
                    found = page.looker.world.scene.cameras[which].world_from_camera
                    page.go_to(pose_from_matrix(found))
                    go.value = "…"

            go.on_update(guarded(on_go))
        behind = gui.add_button("My camera behind the head", icon="camera")
        self._step = gui.add_slider(
            "Step, m", 0.01, 2.0, 0.01, round(min(max(0.5 * size_m, 0.01), 2.0), 2)
        )
        for names in _BUTTONS:
            buttons = gui.add_button_group("Head", names)
            buttons.on_click(guarded(self._on_step))

        async def on_pose(_: Any) -> None:
            x, y, z = self._position.value
            yaw, pitch, roll = self._angles.value
            page.go_to(HeadPose((x, y, z), yaw, pitch, roll))

        async def on_behind(event: Any) -> None:
            self._behind(event.client)

        self._position.on_update(guarded(on_pose))
        self._angles.on_update(guarded(on_pose))
        behind.on_click(guarded(on_behind))

    @property
    def step_m(self) -> float:
        """Of the keys and buttons."""
        return float(self._step.value)

    @property
    def speed_m_s(self) -> float:
        """Of flying."""
        return float(self._speed.value)

    @speed_m_s.setter
    def speed_m_s(self, wanted: float) -> None:
        # Three digits, as is shown.
        self._speed.value = float(f"{min(max(wanted, SLOWEST_M_S), FASTEST_M_S):.3g}")

    def show_pose(self, pose: HeadPose) -> None:
        """The numbers of where the head is."""
        self._position.value = pose.position_m
        self._angles.value = (pose.yaw_deg, pose.pitch_deg, pose.roll_deg)

    async def _on_step(self, event: Any) -> None:
        name, pose = str(event.target.value), self.page.live.look.pose
        if name.startswith("Turn "):
            self.page.go_to(turned_aside(pose, name.removeprefix("Turn ")))
        else:
            self.page.go_to(stepped(pose, name.lower(), self.step_m))

    def _behind(self, client: Any) -> None:
        """A browser's camera behind the head."""
        matrix = self.page.live.look.pose.world_from_head
        r = self.page.scene.head_m
        position = matrix @ [2 * r, 4 * r, 9 * r, 1]
        ahead = matrix @ np.array([0, 0, -4 * r, 1])
        with client.atomic():
            client.camera.position = position[:3]
            client.camera.look_at = ahead[:3]
