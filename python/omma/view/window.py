"""`show`: the server of a page, from its start to its end."""

from __future__ import annotations

import atexit
import html
import secrets
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omma._core import Error, Eye, Scene, merge_eyes
from omma.base.arguments import checked, expect, whole
from omma.base.optional import needs
from omma.base.poses import as_pose, as_poses, load_timed_poses
from omma.eye.files import load_eye
from omma.receptors.sensitivity import ultraviolet_mix
from omma.scene.files import read_scene
from omma.scene.world import World
from omma.view.command import Sources, absolute
from omma.view.keys import page_settings
from omma.view.own_eye import own_eye
from omma.view.ports import is_loopback, listening_socket
from omma.view.poses import HeadPose, pose_from_matrix
from omma.view.rules import Rules, proxy_address
from omma.view.state import Look, Looker, Seen

_HEIGHT = 760  # of the frame in a notebook, pixels


class Window:
    """A page that is being shown; `show` makes it.

    ``url`` is where a browser finds it. In a notebook it shows itself. `close` ends it; so does the
    end of the ``with`` block whose value it is, and the end of the program.
    """

    def __init__(self, server: Any, page: Any, door: Any, url: str) -> None:
        self._server, self._page, self._door = server, page, door
        self._url = url
        self._open = True
        atexit.register(self.close)

    @property
    def url(self) -> str:
        """The address of the page, with its token where there is one."""
        return self._url

    @property
    def look(self) -> Look:
        """The settings that the page is at."""
        look: Look = self._page.live.look
        return look

    @property
    def seen(self) -> Seen | None:
        """The last frame that the page shows, with its numbers; None before the first."""
        seen: Seen | None = self._page.seen
        return seen

    def go_to(self, pose: HeadPose | ArrayLike) -> None:
        """Put the head at a pose: a `HeadPose`, or ``world_from_head`` (4, 4), m.

        Raises:
            omma.Error: it is no pose.
        """
        there = pose if isinstance(pose, HeadPose) else pose_from_matrix(as_pose(pose, "pose"))
        self._page.go_to(there)

    def close(self) -> None:
        """End the page, and its threads; a second time does nothing."""
        if not self._open:
            return
        self._open = False
        atexit.unregister(self.close)
        self._page.close()
        with _quiet_viser():
            self._server.stop()
        self._door.close()

    def __enter__(self) -> Window:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<omma.view.Window {self._url}{'' if self._open else ', closed'}>"

    def _repr_html_(self) -> str:
        address = html.escape(self._url, quote=True)
        return (
            f'<iframe src="{address}" width="100%" height="{_HEIGHT}" style="border:0"></iframe>'
            f'<div><a href="{address}" target="_blank">{address}</a></div>'
        )


@dataclass(frozen=True)
class WindowOptions:
    """How a window is asked for; `show` says what each is."""

    pose: ArrayLike | None = None
    samples: int = 4
    path: ArrayLike | str | None = None
    ultraviolet: ArrayLike | None = None
    animation: str | int | None = None
    threads: int = 0
    host: str = "127.0.0.1"
    port: int | None = None
    proxy: str | None = None


@checked
def show(
    world: World | Scene,
    eye: Eye | Sequence[Eye] | None = None,
    *,
    pose: ArrayLike | None = None,
    samples: int = 4,
    path: ArrayLike | str | None = None,
    ultraviolet: ArrayLike | None = None,
    animation: str | int | None = None,
    threads: int = 0,
    host: str = "127.0.0.1",
    port: int | None = None,
    proxy: str | None = None,
) -> Window:
    """Show what an eye sees in a world on a page for browsers, live; returns at once.

    The page shows the scene in 3D with the head in it, which can be dragged, turned and flown, and
    beside it what the animal sees (docs/view.md). All engine work is done in a thread of its own;
    while the page is open the world is its alone: it moves things to the time that is set there.

    Args:
        world: what there is to see: a `World`, as it is lit, or a scene, of which one is made.
        eye: who sees it; a list of eyes is merged as `omma.eye.merge_eyes` does. None: the eye that
            the scene's first compound camera names, which is then where the head is.
        pose: where the head is at first, ``world_from_head`` (4, 4), m; None: at the scene's first
            camera, else at the origin. Its scale is left out.
        samples: rays of each ommatidium while things move, 1 to 256.
        path: poses that can be played, (P, 4, 4), or a file that `omma.load_poses` reads; where
            that has times, ``t_s``, the scene's animations go by them.
        ultraviolet: of receptors, as `Renderer.render_receptors` takes it.
        animation: which of the scene's animations the time is of; None: all.
        threads: that render; 0 takes one per hardware thread.
        host: address to listen at. Other than 127.0.0.1 others can reach it, and the address of
            the page then holds a random token without which nothing is answered. What goes over
            the network is not encrypted.
        port: None takes the first free one from 8090 on, 0 any that is free.
        proxy: the address at which browsers find the page where a proxy stands before it, as
            ``https://lab.example/bees/``; it then has a token too.

    Example:
        >>> world = omma.World(omma.load_scene(omma.examples.meadow()))
        >>> window = omma.view.show(world, omma.species.drosophila().eye, port=0)
        >>> window.url.startswith("http://127.0.0.1:")
        True
        >>> window.close()

    Raises:
        omma.Error: viser is missing (``omma[view]``), the port is in use, a pose or a path that is
            none.
    """
    if isinstance(world, Scene):
        world = World(world, threads=threads)
    expect(world, World, "world", "omma.World(omma.load_scene(...)) makes one")
    unit = "mm"
    if eye is None:
        eye, node, unit = own_eye(world.scene)
        pose = node.world_from_camera if pose is None else pose
    eyes = [eye] if isinstance(eye, Eye) else list(eye)
    head = eye if isinstance(eye, Eye) else merge_eyes(eyes)
    files = _files_of(world, eyes, unit)
    asked = WindowOptions(
        pose, samples, path, ultraviolet, animation, threads, host=host, port=port, proxy=proxy
    )
    return open_window(world, head, files, asked)


def open_window(world: World, eye: Eye, sources: Sources, asked: WindowOptions) -> Window:
    """What `show` does, with the files that world and eye came from."""
    viser = load_viser()
    from omma.view.door import Door
    from omma.view.hands import Hands
    from omma.view.page import Page
    from omma.view.page_tabs import Tabs

    if asked.port is not None:
        whole(asked.port, "port", 0, 65535)
    given = None if asked.ultraviolet is None else ultraviolet_mix(asked.ultraviolet)
    looker = Looker(world, eye, ultraviolet=given, animation=asked.animation, threads=asked.threads)
    cameras = world.scene.cameras
    if asked.pose is not None:
        first = as_pose(asked.pose, "pose")
    else:
        first = cameras[0].world_from_camera if cameras else np.eye(4)
    poses = times_s = None
    if isinstance(asked.path, str):
        poses, times_s = load_timed_poses(asked.path)
    elif asked.path is not None:
        poses = as_poses(asked.path)
    look = Look(pose_from_matrix(first), asked.samples)
    sources = replace(
        sources,
        lit=world.light is not None,
        ultraviolet=None if given is None else tuple(given.tolist()),
    )
    shown_at = None if asked.proxy is None else proxy_address(asked.proxy)
    # Whom a proxy lets come to here nobody knows here.
    open_to_others = shown_at is not None or not is_loopback(asked.host)
    rules = Rules(secrets.token_urlsafe(24), shown_at) if open_to_others else Rules()
    secret = secrets.token_urlsafe(24)
    listener = listening_socket(asked.host, asked.port)
    server = None
    try:
        with _quiet_viser():
            server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        _lock(server, secret)
        page = Page(server, looker, look, sources)
        tabs = Tabs(page, poses, times_s)
        page.equip(tabs, Hands(page, tabs))
    except BaseException:
        listener.close()
        if server is not None:
            with _quiet_viser():
                server.stop()
        raise
    door = Door(
        listener,
        server.get_port(),
        secret=secret,
        rules=rules,
        settings=page_settings(),
        on_message=page.hands.take,
    )
    page.start(door)
    shown = f"[{asked.host}]" if ":" in asked.host else asked.host
    before = f"http://{shown}:{door.port}/" if shown_at is None else shown_at.geturl()
    url = f"{before}{rules.word}/"
    return Window(server, page, door, url)


def _files_of(world: World, eyes: Sequence[Eye], unit: str = "mm") -> Sources:
    """The files that give this world and these eyes, where there are such; a command then renders
    the same. What has been changed since it was read is in no file."""
    scene = world.scene
    as_read = (
        scene.path
        and not world._moved
        and world.background == scene.background
        and world.band_from_rgb is None
        and all(one.path for one in eyes)
    )
    try:
        if not as_read or any(load_eye(one.path, unit) != one for one in eyes):
            return Sources()
        if read_scene(scene.path, None) != scene:
            return Sources()
    except Error:  # a file that is gone
        return Sources()
    return Sources(absolute(scene.path), tuple(absolute(one.path) for one in eyes), unit)


def load_viser() -> Any:
    """The package that makes the page.

    Raises:
        omma.Error: it is not installed.
    """
    needs("aiohttp", "view", "the page needs aiohttp")
    needs("PIL.Image", "view", "the page needs Pillow")
    return needs("viser", "view", "the page needs viser")


def _lock(server: Any, secret: str) -> None:
    """Makes viser's own port answer to the door alone: requests without its secret are cut off, and
    sharing the page over the internet is disabled."""
    from omma.view.passing import SECRET_HEADER

    inner = server._websock_server

    async def check(connection: Any) -> None:
        request = inner._live_connections[connection.client_id].request
        found = request.headers.get(SECRET_HEADER, "")
        if not secrets.compare_digest(found.encode(), secret.encode()):
            await inner._live_connections[connection.client_id].close(1008, "not by this door")
            raise ConnectionAbortedError("a connection that did not come by the door")

    inner._client_connect_cb.insert(0, check)
    server.request_share_url = lambda *_, **__: None


@contextmanager
def _quiet_viser() -> Iterator[None]:
    """Silences viser's messages about its own port."""
    import rich

    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before
