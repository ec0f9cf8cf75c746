"""What goes on to viser's own server: its page, with Omma's scripts in it, and its web socket."""

from __future__ import annotations

import asyncio
from importlib import resources
from typing import Any

import aiohttp
from aiohttp import WSMsgType, web

from omma._core import Error
from omma.view.watchers import ALIVE_S

SECRET_HEADER = "X-Omma-Door"
SCRIPTS = ("colours.js", "live.js", "layout.js", "flying.js", "keys.js")
STYLE = "page.css"

_TITLE = "<title>Viser</title>"
_KINDS = {".js": "text/javascript", ".css": "text/css"}
_LARGEST_MESSAGE = 50 << 20  # what viser itself takes


def page_file(name: str) -> web.Response | None:
    """One of Omma's own files of the page; None where there is none of this name."""
    if name not in (*SCRIPTS, STYLE):
        return None
    text = (resources.files("omma.view") / "page_files" / name).read_text("utf-8")
    kind = _KINDS[name[name.rindex(".") :]]
    return web.Response(text=text, content_type=kind, headers={"Cache-Control": "no-cache"})


class Viser:
    """viser's server on a port of 127.0.0.1, which answers to whoever brings the secret.

    Args:
        port: viser's.
        secret: what it is shown with each request.
        settings: JSON that the page's scripts find as ``omma.settings``.
    """

    def __init__(self, port: int, secret: str, settings: str) -> None:
        self._address = f"127.0.0.1:{port}"
        self._headers = {SECRET_HEADER: secret}
        self._settings = settings
        # Of this machine alone: no proxy from the environment, as many as there are browsers.
        self._session = aiohttp.ClientSession(
            connector=aiohttp.TCPConnector(limit=0), trust_env=False
        )

    async def close(self) -> None:
        """End all connections to it."""
        await self._session.close()

    async def page(self) -> web.Response:
        """viser's page; before its own scripts come Omma's."""
        async with self._session.get(f"http://{self._address}/", headers=self._headers) as found:
            text = await found.text()
        if _TITLE not in text:
            raise Error("viser: its page is another than Omma knows; it was made for viser 1.1")
        # What looks like the end of a script may be in the settings.
        settings = self._settings.replace("<", "\\u003c")
        more = [f"<script>window.omma={{settings:{settings}}}</script>"]
        more += [f'<script src="omma/{name}"></script>' for name in SCRIPTS]
        more += [f'<link rel="stylesheet" href="omma/{STYLE}">', "<title>Omma</title>"]
        answer = web.Response(
            text=text.replace(_TITLE, "".join(more), 1),
            content_type="text/html",
            headers={"Cache-Control": "no-store", "Referrer-Policy": "no-referrer"},
        )
        answer.enable_compression()
        return answer

    async def file(self, path: str) -> web.Response:
        """Another file of viser's."""
        address = f"http://{self._address}/{path}"
        async with self._session.get(address, headers=self._headers) as found:
            kind = found.headers.get("Content-Type", "application/octet-stream")
            return web.Response(
                status=found.status, body=await found.read(), headers={"Content-Type": kind}
            )

    async def socket(self, request: web.Request) -> web.StreamResponse:
        """viser's web socket, both ways until one of them ends it."""
        wanted = request.headers.get("Sec-WebSocket-Protocol", "")
        protocols = [one.strip() for one in wanted.split(",") if one.strip()]
        async with self._session.ws_connect(
            f"http://{self._address}/",
            protocols=protocols,
            headers=self._headers,
            max_msg_size=0,
            compress=0,
        ) as inner:
            outer = web.WebSocketResponse(
                protocols=[inner.protocol] if inner.protocol else [],
                max_msg_size=_LARGEST_MESSAGE,
                heartbeat=ALIVE_S,
                compress=False,
            )
            await outer.prepare(request)
            ways = [
                asyncio.ensure_future(_copy(inner, outer)),
                asyncio.ensure_future(_copy(outer, inner)),
            ]
            try:
                await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for way in ways:
                    way.cancel()
                await asyncio.gather(*ways, return_exceptions=True)
            await outer.close(code=inner.close_code or 1000)
            return outer


async def _copy(source: Any, target: Any) -> None:
    async for message in source:
        if message.type is WSMsgType.BINARY:
            await target.send_bytes(message.data)
        elif message.type is WSMsgType.TEXT:
            await target.send_str(message.data)
