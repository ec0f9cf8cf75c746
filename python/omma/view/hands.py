"""What hands do on the page, as its scripts tell it: keys, flying, clicks and drags on pictures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from omma._core import Error
from omma.view.poses import HeadPose, moved, pose_from_matrix
from omma.view.watchers import Reply

if TYPE_CHECKING:
    from omma.view.page import Page

_STEP_DEG = 3.0
_FASTER = 1.25
MOST_RAYS = 64
SLOWEST_M_S, FASTEST_M_S = 1e-4, 1e3
# Beyond, left and right change places.
_STEEPEST_DEG = 89.0
# A browser that was held up tells of more than this at once; nobody wants to be there.
_LONGEST_S, _FARTHEST_DEG = 1.0, 360.0
_WAYS = {
    "ahead": (1, 0, 0), "back": (-1, 0, 0), "left": (0, -1, 0), "right": (0, 1, 0),
    "up": (0, 0, 1), "down": (0, 0, -1),
}  # fmt: skip


class Hands:
    """Does on a page what browsers ask for; in the door's thread."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._camera = -1

    def take(self, message: dict[str, Any], send_file: Reply) -> None:
        """Do what a browser says; what is wrong is told on the page."""
        try:
            self._do(message, send_file)
        except Exception as error:
            self._page.tell_error(error)

    def _do(self, message: dict[str, Any], send_file: Reply) -> None:
        page, tabs = self._page, self._page.tabs
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
        elif kind == "step" and name in _WAYS:
            self.step(name)
        elif kind == "turn" and name in ("left", "right"):
            self.turn(name)
        else:
            raise Error(f"page: it asks for '{what[:40]}', which omma does not know; load it anew")

    def step(self, name: str) -> None:
        """A step of the length that is set: ahead, back, left, right, up, down."""
        step_m = float(self._page.tabs.head.step_m)
        ahead, right, up = (step_m * one for one in _WAYS[name])
        self._page.go_to(moved(self._page.live.look.pose, ahead, right, up))

    def turn(self, name: str) -> None:
        """A small turn to the left or to the right."""
        turn = -_STEP_DEG if name == "left" else _STEP_DEG
        self._page.go_to(_turned(self._page.live.look.pose, turn, 0.0))

    def _fly(self, message: dict[str, Any]) -> None:
        """Some seconds' way in each direction, and some degrees round."""
        speed = float(self._page.tabs.head.speed_m_s)
        ways = [
            speed * _number(message, name, -_LONGEST_S, _LONGEST_S)
            for name in ("ahead", "right", "up")
        ]
        yaw, pitch = (
            _number(message, name, -_FARTHEST_DEG, _FARTHEST_DEG) for name in ("yaw", "pitch")
        )
        self._page.go_to(moved(_turned(self._page.live.look.pose, yaw, pitch), *ways))
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


def _turned(pose: HeadPose, yaw_deg: float, pitch_deg: float) -> HeadPose:
    # A pose that is steeper already stays so until it is turned back.
    most = max(_STEEPEST_DEG, abs(pose.pitch_deg))
    pitch = min(max(pose.pitch_deg + pitch_deg, -most), most)
    return HeadPose(pose.position_m, pose.yaw_deg + yaw_deg, pitch, pose.roll_deg)


def _number(message: dict[str, Any], name: str, low: float, high: float) -> float:
    """A number of a message; what is outside counts as the nearest inside."""
    value = message.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise Error(f"page: expected {name} to be a number, found {str(value)[:40]}")
    return min(max(float(value), low), high)
