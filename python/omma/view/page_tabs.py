"""The page's panel: the live picture, and tabs with all that can be set."""

from __future__ import annotations

from typing import Any

from omma._core import Error
from omma.base.arrays import Floats
from omma.base.poses import Matrices
from omma.picture.video import FRAMES_PER_S
from omma.view.motion import Clock
from omma.view.page import Page
from omma.view.page_chosen import Chosen
from omma.view.page_head import Head
from omma.view.page_texts import CAMERA_PICTURE, EYE_PICTURE, LINKS, numbers_html, saved_html
from omma.view.painting import PROJECTIONS
from omma.view.path_files import poses_of_csv, record_video, recorded_csv
from omma.view.poses import HeadPose, pose_from_matrix
from omma.view.state import Seen

MOST_RAYS = 64
_WIDTH = 430.0


class Tabs:
    """The widgets of a page; what they are set to goes to the page, and back.

    ``path``: poses that can be played, (P, 4, 4); None: none as yet. ``times_s``: (P,), when they
    are, by which the scene's animations go; None: nobody knows.
    """

    def __init__(self, page: Page, path: Matrices | None, times_s: Floats | None = None) -> None:
        self.page = page
        self._poses: list[HeadPose] = []
        self._times_s: list[float] | None = None
        self._at = 0.0
        self._clock = Clock(self._on_play, lambda: page.live.look, self._on_full, page.tell_error)
        gui = page.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.set_panel_label("Omma: a window into the eye")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_WIDTH)
        gui.add_html(EYE_PICTURE)
        gui.add_html(LINKS)
        self._numbers = gui.add_html("")
        self._channel = gui.add_dropdown("Shown", list(page.channels))
        self._projection = gui.add_dropdown("Projection", list(PROJECTIONS))
        self._channel.on_update(self._guarded(self._on_channel))
        self._projection.on_update(self._guarded(self._on_projection))
        tabs = gui.add_tab_group()
        with tabs.add_tab("Eye"):
            self._add_eye(gui)
        with tabs.add_tab("Head"):
            self.head = Head(page, gui, self._guarded)
        with tabs.add_tab("Ommatidium"):
            self.chosen = Chosen(page, gui)
        with tabs.add_tab("Play"):
            self._add_play(gui)
        with tabs.add_tab("Save"):
            self._add_save(gui)
        beside = gui.add_panel()
        with beside.add_tab("Camera"):
            gui.add_html(CAMERA_PICTURE)
        beside.float(x=-12, y=-12, width=300)
        if path is not None:
            self._take_path(path, times_s)

    def close(self) -> None:
        """End what plays."""
        self._clock.close()

    def _guarded(self, function: Any) -> Any:
        """A callback for events of browsers only, not for values that are set from here."""

        async def by_browser(event: Any) -> None:
            if event.client_id is not None:
                await function(event)

        return self.page.guarded(by_browser)

    # The tabs.

    def _add_eye(self, gui: Any) -> None:
        page, look = self.page, self.page.live.look
        most = max(MOST_RAYS, look.samples)
        self._rays = rays = gui.add_slider(
            "Rays", 1, most, 1, look.samples,
            hint="Of each ommatidium, while things move",
            marks=tuple((k, str(k)) for k in (1, 16, 32, 48, most)),
        )  # fmt: skip
        factor = gui.add_slider(
            "Δρ", 0.25, 4.0, 0.05, look.acceptance_factor,
            hint="Times each acceptance angle; other than 1 makes round Gaussians",
        )  # fmt: skip
        stops = gui.add_slider(
            "Exposure", -6.0, 6.0, 0.25, 0.0, hint="Of the pictures: each 1 twice as bright"
        )
        duration = page.looker.duration_s
        self._time = None
        if duration > 0:
            self._time = gui.add_slider(
                "Time, s", 0.0, round(duration, 3), round(max(duration / 500, 0.001), 3),
                look.time_s or 0.0,
            )  # fmt: skip
        finer = gui.add_checkbox("Finer while it holds still", True)
        axes = gui.add_checkbox("Axes", False, hint="Where ommatidia look, coloured by eye")
        fields = gui.add_checkbox("Fields of view", False)

        async def on_rays(_: Any) -> None:
            page.want(samples=int(rays.value))

        async def on_factor(_: Any) -> None:
            page.want(acceptance_factor=round(float(factor.value), 3))

        async def on_stops(_: Any) -> None:
            page.stops = float(stops.value)
            page.repaint()

        async def on_time(_: Any) -> None:
            assert self._time is not None
            page.want(time_s=float(self._time.value))

        async def on_finer(_: Any) -> None:
            page.live.refine(bool(finer.value))

        async def on_overlay(_: Any) -> None:
            page.scene.axes.visible = bool(axes.value)
            for one in page.scene.fields:
                one.visible = bool(fields.value)

        rays.on_update(self._guarded(on_rays))
        factor.on_update(self._guarded(on_factor))
        stops.on_update(self._guarded(on_stops))
        finer.on_update(self._guarded(on_finer))
        axes.on_update(self._guarded(on_overlay))
        fields.on_update(self._guarded(on_overlay))
        if self._time is not None:
            self._time.on_update(self._guarded(on_time))

    def _add_play(self, gui: Any) -> None:
        self._upload = gui.add_upload_button("Open a path (CSV)", mime_type=".csv,text/csv")
        self._frame = gui.add_slider("Pose", 0, 1, 1, 0, disabled=True)
        self._play = gui.add_checkbox(
            "Play",
            False,
            hint=f"The path, {FRAMES_PER_S} poses a second, and the animations, by the path's "
            "times where it has some",
        )
        self._record = gui.add_button("Record", icon="player-record")
        self._stop = gui.add_button("Stop, and save the video", icon="video", disabled=True)
        self._keep = gui.add_button("Stop, and save the path", icon="route", disabled=True)
        self._recorded = gui.add_html("")
        self._upload.on_upload(self._guarded(self._on_upload))
        self._frame.on_update(self._guarded(self._on_frame))
        self._play.on_update(self._guarded(self._on_play_box))
        self._record.on_click(self._guarded(self._on_record))
        self._stop.on_click(self._guarded(self._on_stop))
        self._keep.on_click(self._guarded(self._on_keep))

    def _add_save(self, gui: Any) -> None:
        self._saved = gui.add_html("")

    # What browsers do.

    async def _on_channel(self, _: Any) -> None:
        self.page.show_channel(str(self._channel.value))

    async def _on_projection(self, _: Any) -> None:
        self.page.projection = str(self._projection.value)
        self.page.repaint()

    async def _on_upload(self, event: Any) -> None:
        file = event.target.value
        self._take_path(*poses_of_csv(file.name, file.content))
        self.page.tell("Path", f"{file.name}: {len(self._poses)} poses")

    def _take_path(self, matrices: Matrices, times_s: Floats | None) -> None:
        poses = [pose_from_matrix(one) for one in matrices]
        if not poses:
            raise Error("path: expected at least one pose, found none")
        self._poses, self._at = poses, 0.0
        self._times_s = None if times_s is None or self._time is None else times_s.tolist()
        self._frame.max = max(1, len(poses) - 1)
        self._frame.disabled = len(poses) < 2
        self._frame.value = 0

    async def _on_frame(self, _: Any) -> None:
        if self._poses:
            self._at = float(self._frame.value)
            self._go_to(min(int(self._at), len(self._poses) - 1))

    def _go_to(self, number: int) -> None:
        """Go to a pose of the path, and to its time."""
        if self._times_s is None:
            self.page.go_to(self._poses[number])
            return
        time_s = self._times_s[number]
        self.page.go_to(self._poses[number], time_s=time_s)
        assert self._time is not None
        self._time.value = round(min(max(time_s, 0.0), self.page.looker.duration_s), 3)

    async def _on_play_box(self, _: Any) -> None:
        if self._play.value and not self._poses and self._time is None:
            self._play.value = False
            raise Error("play: there is no path as yet, and nothing in the scene moves")
        self._clock.play(bool(self._play.value))

    def _on_play(self, frames: float) -> None:
        """Some frames on, in the clock's thread; what ends begins anew."""
        if self._poses:
            self._at = (self._at + frames) % len(self._poses)
            self._go_to(int(self._at))
            self._frame.value = int(self._at)
        if self._time is not None and self._times_s is None:
            duration = self.page.looker.duration_s
            now = (float(self._time.value) + frames / FRAMES_PER_S) % duration
            self._time.value = round(now, 3)
            self.page.want(time_s=round(now, 3))

    async def _on_record(self, _: Any) -> None:
        self._clock.record()
        self._recording(True)

    def _recording(self, running: bool) -> None:
        self._record.disabled = running
        self._stop.disabled = self._keep.disabled = not running
        self._recorded.content = "<p style='margin:0 12px'>Recording …</p>" if running else ""

    def _on_full(self) -> None:
        self.page.tell("Recording", "It has become two minutes long, and has ended: save it now.")

    async def _on_stop(self, event: Any) -> None:
        looks = self._clock.recorded()
        self._recording(False)
        record_video(self.page, looks, event.client, self._recorded)

    async def _on_keep(self, event: Any) -> None:
        looks = self._clock.recorded()
        self._recording(False)
        event.client.send_file_download("path.csv", recorded_csv(looks), save_immediately=True)

    # What comes back.

    def show_pose(self, pose: HeadPose) -> None:
        """The numbers of where the head is."""
        self.head.show_pose(pose)

    def show_rays(self, samples: int) -> None:
        """How many rays each ommatidium has while things move."""
        self._rays.value = samples

    def show_numbers(self, seen: Seen, frame_s: float) -> None:
        """The line below the picture, and how to render the same."""
        self._numbers.content = numbers_html(seen, frame_s, self.page.scene.note)
        self._saved.content = saved_html(self.page.sources, seen)

    def show_chosen(self, seen: Seen, still: bool) -> None:
        """What is picked."""
        self.chosen.show(seen, still)
