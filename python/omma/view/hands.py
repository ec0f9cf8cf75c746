"""What hands do on the page, as its scripts tell it: keys, flying, clicks and drags on pictures."""

from __future__ import annotations

import math
from typing import Any

from omma._core import Error
from omma.view.page import Page
from omma.view.page_tabs import MOST_RAYS, Tabs
from omma.view.poses import WAYS, moved, pose_from_matrix, stepped, turned, turned_aside
from omma.view.watchers import Reply

_FASTER = 1.25
# A browser that was held up tells of more than this at once; nobody wants to be there.
_LONGEST_S, _FARTHEST_DEG = 1.0, 360.0


class Hands:
    """Does on a page what browsers ask for; in the door's thread."""

    def __init__(self, page: Page, tabs: Tabs) -> None:
        self._page, self._tabs = page, tabs
        self._camera = -1

    def take(self, message: dict[str, Any], send_file: Reply) -> None:
        """Do what a browser says; what is wrong is told on the page."""
        try:
            self._do(message, send_file)
        except Exception as error:
            self._page.tell_error(error)

    def _do(self, message: dict[str, Any], send_file: Reply) -> None:
        page, tabs = self._page, self._tabs
        what = str(message.get("do", ""))
        kind, _, name = what.partition("_")
        if what == "size":
            page.repaint()
        elif what == "pick":
            page.click(_number(message, "x", 0, 1), _number(message, "y", 0, 1))
        elif what == "fly":
            self._fly(message)
        elif what == "flying":
            number = message.get("client")
            page.fly(number if message.get("on") is True and isinstance(number, int) else None)
        elif what == "speed":
            tabs.head.speed_m_s *= _number(message, "factor", 0.1, 10)
            page.note(f"{tabs.head.speed_m_s:.3g} m/s")
        elif what in ("faster", "slower"):
            tabs.head.speed_m_s *= _FASTER if what == "faster" else 1 / _FASTER
            page.note(f"{tabs.head.speed_m_s:.3g} m/s")
        elif what in ("next_camera", "previous_camera"):
            self._go_to_camera(1 if kind == "next" else -1)
        elif what in ("more_rays", "fewer_rays"):
            rays = page.live.look.samples
            rays = min(2 * rays, max(MOST_RAYS, rays)) if kind == "more" else max(rays // 2, 1)
            tabs.show_rays(rays)
            page.want(samples=rays)
            page.note(f"{rays} rays")
        elif what == "save":
            page.save(send_file)
        elif kind == "step" and name in WAYS:
            page.go_to(stepped(page.live.look.pose, name, tabs.head.step_m))
        elif kind == "turn" and name in ("left", "right"):
            page.go_to(turned_aside(page.live.look.pose, name))
        else:
            raise Error(f"page: it asks for '{what[:40]}', which omma does not know; load it anew")

    def _fly(self, message: dict[str, Any]) -> None:
        """Some seconds' way in each direction, and some degrees round."""
        speed = float(self._tabs.head.speed_m_s)
        ways = [
            speed * _number(message, name, -_LONGEST_S, _LONGEST_S)
            for name in ("ahead", "right", "up")
        ]
        yaw, pitch = (
            _number(message, name, -_FARTHEST_DEG, _FARTHEST_DEG) for name in ("yaw", "pitch")
        )
        self._page.go_to(moved(turned(self._page.live.look.pose, yaw, pitch), *ways))
        self._page.camera_to_head(message.get("client"))

    def _go_to_camera(self, by: int) -> None:
        cameras = self._page.looker.world.scene.cameras
        if not cameras:
            raise Error("camera: the scene has none")
        self._camera = (self._camera + by) % len(cameras) if self._camera >= 0 else max(by - 1, -1)
        self._camera %= len(cameras)
        camera = cameras[self._camera]
        self._page.go_to(pose_from_matrix(camera.world_from_camera))
        self._page.note(f"camera {camera.name}, {self._camera + 1} of {len(cameras)}")


def _number(message: dict[str, Any], name: str, low: float, high: float) -> float:
    """A number of a message; what is outside counts as the nearest inside."""
    value = message.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise Error(f"page: expected {name} to be a number, found {str(value)[:40]}")
    return min(max(float(value), low), high)
