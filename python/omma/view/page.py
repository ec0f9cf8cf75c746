"""The page: viser's widgets and what they do. What is set here becomes a `Look`; what comes back as
`Seen` is painted, drawn over the scene and told in numbers."""

from __future__ import annotations

import io
import math
import time
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from omma._core import Error
from omma.view.command import Sources
from omma.view.door import Door
from omma.view.live import Live
from omma.view.page_scene import PageScene
from omma.view.page_texts import CLIENT
from omma.view.painting import (
    PROJECTIONS,
    Channel,
    Pixels,
    channels_of,
    paint_camera,
    paint_eye,
    shown_values,
    white_of,
)
from omma.view.picked import ommatidium_looking_at
from omma.view.picture_ids import PictureIds
from omma.view.poses import HeadPose, matrix_from_wxyz, pose_from_matrix, quaternion_wxyz
from omma.view.state import Look, Looker, Seen
from omma.view.watchers import Reply

if TYPE_CHECKING:
    from typing import TypeGuard

    import viser

_CAMERA_SIZE = (480, 270)
_JPEG_QUALITY = 88
# While things move: seconds between two updates of what costs a browser or two cores much.
_NUMBERS_S, _FACETS_S, _CAMERA_S = 0.2, 0.15, 0.33
_SAME_ERROR_S = 5.0
# Browsers look along +Z with Y down, heads along -Z with Y up.
_HEAD_FROM_CAMERA = np.diag([1.0, -1.0, -1.0, 1.0])


class Panel(Protocol):
    """What a page tells its widgets."""

    def show_pose(self, pose: HeadPose) -> None: ...
    def show_numbers(self, seen: Seen, frame_s: float) -> None: ...
    def show_chosen(self, seen: Seen, still: bool) -> None: ...
    def close(self) -> None: ...


class Taker(Protocol):
    """What takes the messages of browsers."""

    def take(self, message: dict[str, Any], send_file: Reply) -> None: ...


class Page:
    """All that is on the page of one server, the same for every browser that looks at it.

    Args:
        server: viser's.
        looker: what renders.
        look: the first settings.
        sources: the files that it all came from.
    """

    tabs: Panel
    hands: Taker

    def __init__(
        self,
        server: viser.ViserServer,
        looker: Looker,
        look: Look,
        sources: Sources,
    ) -> None:
        self.server, self.looker, self.sources = server, looker, sources
        self.channels = {one.name: one for one in channels_of(looker.world, looker.eye)}
        self.channel: Channel = next(iter(self.channels.values()))
        self.projection = next(iter(PROJECTIONS))
        self.stops = 0.0
        self.chosen: int | None = None
        self.seen: Seen | None = None
        self.white = 1.0
        self._door: Door | None = None
        self._pictures = PictureIds(looker.eye)
        self._white_of: Channel | None = None
        self._last = {"numbers": 0.0, "facets": 0.0, "camera": 0.0, "frame": 0.0}
        self._frame_s = 0.0
        self._errors: dict[str, float] = {}
        self._camera_look: tuple[Look, int] | None = None
        self._pilot: int | None = None
        self.live = Live(
            looker,
            look,
            on_seen=self._on_seen,
            on_still=self._on_still,
            on_error=self.tell_error,
        )
        self.scene = PageScene(server, looker, look)
        self.scene.head.on_update(self.guarded(self._on_drag))
        server.scene.on_click()(self.guarded(self._on_scene_click))
        server.on_client_connect(self._on_connect)
        server.on_client_disconnect(self._on_disconnect)

    def equip(self, tabs: Panel, hands: Taker) -> None:
        """Its widgets and what browsers move it by, which know it and are made after it."""
        self.tabs, self.hands = tabs, hands

    def start(self, door: Door) -> None:
        """Render from now on, into the streams of a door."""
        self._door = door
        self.live.start()

    def close(self) -> None:
        """End the threads."""
        self.tabs.close()
        self.live.close()

    # What is wanted.

    def want(self, **changes: Any) -> None:
        """Change the settings that are named; shown as soon as it is rendered."""
        self.live.want(replace(self.live.look, **changes))

    def go_to(self, pose: HeadPose, *, dragged: bool = False, **changes: Any) -> None:
        """Put the head somewhere, and change the settings that are named. Where the browser drags
        it, it is there already."""
        self.want(pose=pose, **changes)
        if not dragged:
            self.scene.place_head(pose)
        self.tabs.show_pose(pose)

    def show_channel(self, name: str) -> None:
        """Show something else of the numbers."""
        self.channel = self.channels[name]
        self.want(receptors=self.channel.receptors)
        self.repaint()

    def repaint(self) -> None:
        """Paint what has been rendered anew, as its colours or its projection have changed."""

        def paint_again() -> bool:
            if self._shows(self.seen):
                self._paint(self.seen, still=True)
            self._camera_look = None
            self._paint_camera(self.live.look, still=True)
            return False

        self.live.do(paint_again)

    def choose(self, number: int | None) -> None:
        """Pick an ommatidium by its number, or none."""
        if number is not None and not 0 <= number < len(self.looker.eye):
            raise Error(f"ommatidium: expected 0 to {len(self.looker.eye) - 1}, found {number}")

        def pick() -> bool:
            self._take(number)
            return False

        self.live.do(pick)

    def _take(self, number: int | None) -> None:
        """The picked ommatidium is another; in the thread that renders."""
        self.chosen = number
        if self._shows(self.seen):
            self._paint(self.seen, still=True)
            self.tabs.show_chosen(self.seen, still=True)

    def _shows(self, seen: Seen | None) -> TypeGuard[Seen]:
        """Whether a frame has the numbers that are to be shown: after a change from light to
        receptors the next has."""
        return seen is not None and seen.look.receptors == self.channel.receptors

    def click(self, x: float, y: float) -> None:
        """A click on the picture: the ommatidium that is shown there is picked."""

        def pick() -> bool:
            ids = self._ids()
            row = min(int(y * ids.shape[0]), ids.shape[0] - 1)
            number = int(ids[row, min(int(x * ids.shape[1]), ids.shape[1] - 1)])
            if number >= 0:
                self._take(number)
            return False

        self.live.do(pick)

    def save(self, take: Callable[[bytes], None]) -> None:
        """Hand over the picture that is shown, as PNG, without the mark of what is picked."""

        def paint() -> bool:
            seen, channel = self.seen, self.channel
            if self._shows(seen):
                values = shown_values(self.looker.world, self.looker.eye, seen, channel)
                take(encoded(self._painted(values), "PNG"))
            return False

        self.live.do(paint)

    def note(self, text: str) -> None:
        """A line for a moment, in every browser."""
        if self._door is not None:
            self._door.note(text)

    # What comes back, in the thread that renders.

    def _on_seen(self, seen: Seen) -> None:
        now = time.monotonic()
        since, self._last["frame"] = now - self._last["frame"], now
        # Between frames that follow each other; what was still before is no frame's time.
        self._frame_s = since if since < 1 and not seen.standard_error else seen.seconds
        self.seen = seen
        if not self._shows(seen):
            return
        self.scene.place_moving(seen.look)
        self._paint(seen, still=seen.standard_error)
        if not seen.standard_error:
            self._paint_camera(seen.look, still=False)

    def _on_still(self, look: Look) -> None:
        self._paint_camera(look, still=True)
        if self._shows(self.seen):
            self._paint(self.seen, still=True)

    def _size(self) -> tuple[int, int]:
        return self._door.size if self._door is not None else (0, 0)

    def _ids(self) -> NDArray[np.int32]:
        return self._pictures.fitted(self.projection, *self._size())

    def _painted(self, values: NDArray[np.float32], chosen: int | None = None) -> Pixels:
        hidden = self._pictures.unseen(self.projection, *self._size())
        return paint_eye(self._ids(), values, self.white, self.stops, chosen, hidden)

    def _paint(self, seen: Seen, still: bool) -> None:
        channel = self.channel  # which browsers may change meanwhile
        if seen.look.receptors != channel.receptors:
            return
        values = shown_values(self.looker.world, self.looker.eye, seen, channel)
        if self._white_of is not channel:
            # Kept as long as that is shown: what moves is not to flicker.
            self._white_of = channel
            self.white = white_of(self.looker.world, channel, values)
        if self._door is not None:
            pixels = self._painted(values, self.chosen)
            self._door.show("eye", encoded(pixels, "JPEG"))
        if self._is_due("facets", _FACETS_S, still):
            each = np.arange(len(values), dtype=np.int32)[None]
            self.scene.show_facets(paint_eye(each, values, self.white, self.stops)[0])
        if self._is_due("numbers", _NUMBERS_S, still):
            self.tabs.show_numbers(seen, self._frame_s)
            self.tabs.show_chosen(seen, still)

    def _paint_camera(self, look: Look, still: bool) -> None:
        samples = 2 if still else 1
        if self._door is None or self._camera_look == (look, samples):
            return
        if not self._is_due("camera", _CAMERA_S, still):
            return
        width, height = _CAMERA_SIZE if still else (_CAMERA_SIZE[0] // 2, _CAMERA_SIZE[1] // 2)
        picture = self.looker.picture(look, width, height, samples)
        pixels = paint_camera(self.looker.world, picture, self.stops)
        self._door.show("camera", encoded(pixels, "JPEG"))
        self._camera_look = (look, samples)

    def _is_due(self, what: str, every_s: float, still: bool) -> bool:
        now = time.monotonic()
        if not still and now - self._last[what] < every_s:
            return False
        self._last[what] = now
        return True

    # What browsers do.

    async def _on_drag(self, event: Any) -> None:
        target = event.target
        self.go_to(pose_from_matrix(matrix_from_wxyz(target.wxyz, target.position)), dragged=True)

    async def _on_scene_click(self, event: Any) -> None:
        start = np.asarray(event.ray_origin, np.float64)
        direction = np.asarray(event.ray_direction, np.float64)

        def pick() -> bool:
            look = self.live.look
            number = ommatidium_looking_at(self.looker, look, start, direction, self.scene.head_m)
            if number is not None:
                self._take(number)
            return False

        self.live.do(pick)

    async def _on_connect(self, client: Any) -> None:
        client.gui.add_html(CLIENT.format(number=client.client_id))

    async def _on_disconnect(self, client: Any) -> None:
        if self._pilot == client.client_id:
            self.fly(None)

    def fly(self, client_id: int | None) -> None:
        """The camera of a browser goes with the head, and the head's control is out of the way;
        None: nobody flies."""
        self._pilot = client_id
        self.scene.head.visible = client_id is None
        self.camera_to_head(client_id)

    def camera_to_head(self, client_id: object) -> None:
        """A browser's camera where the head is, looking where it looks."""
        pilot = self._pilot
        client = None if pilot is None else self.server.get_clients().get(pilot)
        if client is None or client_id != pilot:
            return
        matrix = self.live.look.pose.world_from_head
        with client.atomic():
            client.camera.wxyz = quaternion_wxyz(matrix @ _HEAD_FROM_CAMERA)
            client.camera.position = matrix[:3, 3]

    def guarded(self, function: Callable[[Any], Awaitable[None]]) -> Callable[[Any], Any]:
        """A callback whose errors are told on the page."""

        async def call(event: Any) -> None:
            try:
                await function(event)
            except Exception as error:
                self.tell_error(error)

        return call

    def tell_error(self, error: Exception) -> None:
        """Say on the page what went wrong, in every browser; the same thing not twice in a row."""
        text = str(error) or type(error).__name__
        if not isinstance(error, Error):
            text = f"{type(error).__name__}: {text}"
        now = time.monotonic()
        if now - self._errors.get(text, -math.inf) < _SAME_ERROR_S:
            return
        self._errors = {text: now}
        self.tell("That did not work", text, "red")

    def tell(self, title: str, text: str, colour: Literal["blue", "red"] = "blue") -> None:
        """A note in every browser."""
        for client in self.server.get_clients().values():
            client.add_notification(title, text, color=colour, auto_close_seconds=12.0)


def encoded(pixels: NDArray[np.uint8], kind: Literal["JPEG", "PNG"]) -> bytes:
    """A picture as a file."""
    from PIL import Image

    file = io.BytesIO()
    options = {"quality": _JPEG_QUALITY} if kind == "JPEG" else {}
    Image.fromarray(pixels).save(file, kind, **options)
    return file.getvalue()
