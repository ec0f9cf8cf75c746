"""Who may come in: the token in the address, the name by which the page is asked for, and the page
that asks. Nothing here listens or answers."""

from __future__ import annotations

import hmac
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import SplitResult, urlsplit

from omma._core import Error
from omma.view.ports import LOOPBACK

#: What addresses of a page begin with that only this machine can reach.
PLAIN_WORD = "view"
_HOW = "docs/view.md, 'Behind a proxy', says how"


@dataclass(frozen=True)
class Rules:
    """word: the first part of each address, a random token unless the page is this machine's alone;
    proxy: where browsers find the page if a proxy stands before it, of `proxy_address`."""

    word: str = PLAIN_WORD
    proxy: SplitResult | None = None

    @property
    def has_token(self) -> bool:
        """Whether the word is a secret."""
        return self.word != PLAIN_WORD


def proxy_address(text: str) -> SplitResult:
    """The address at which a proxy shows the page, taken apart; its path ends with a slash.

    Raises:
        omma.Error: it is no address of the web.
    """
    try:
        found = urlsplit(text)
        good = found.scheme in ("http", "https") and found.hostname and found.port != 0
    except ValueError:
        good = False
    if not good or found.query or found.fragment:
        raise Error(
            "proxy: expected the address at which a browser finds the page, as "
            f"https://lab.example/bees/, found '{text}'"
        )
    return found._replace(path=found.path.rstrip("/") + "/")


def path_inside(rules: Rules, raw_path: str) -> tuple[str, str | None]:
    """The first part of an address, and what follows its slash; None where there is no slash.
    Proxies take their own path away, or leave it: both are understood."""
    path = raw_path.split("?")[0]
    before = rules.proxy.path if rules.proxy is not None else "/"
    if before != "/" and path.startswith(before):
        path = path[len(before) - 1 :]
    word, slash, rest = path[1:].partition("/")
    return word, rest if slash else None


def refusal(rules: Rules, word: str, headers: Mapping[str, str]) -> str | None:
    """Why a request may not pass, in words for whoever reads them; None where it may.

    A page of the web that had its own name lead here (DNS rebinding) is told by the Host; one that
    opens web sockets to here by the Origin.
    """
    host = headers.get("Host", "")
    if rules.has_token:
        if not hmac.compare_digest(word.encode(), rules.word.encode()):
            return (
                "This page needs the address with its token, which was printed where 'omma view' "
                "was started."
            )
    elif _name(host) not in LOOPBACK:
        return (
            f"This page was asked for as {host or 'nothing'}, and as it was started it answers "
            "to 127.0.0.1 and localhost only. If a proxy or a tunnel of yours leads here, start it "
            f"again with --proxy and the address that browsers use; {_HOW}."
        )
    return refusal_of_origin(rules, headers.get("Origin"), headers)


def refusal_of_origin(
    rules: Rules, origin: str | None, headers: Mapping[str, str], folder: str = "/"
) -> str | None:
    """Why a page of that origin may not use this one; None where it may, or is not said.
    folder: where the page is there, as it says itself."""
    if origin is None:
        return None
    # A proxy that puts a Host of its own may say which was asked for. No page of the web can set
    # this header in a web socket or in a request to another address.
    known = {headers.get("Host", ""), headers.get("X-Forwarded-Host", "").split(",")[0].strip()}
    if rules.proxy is not None:
        known.add(rules.proxy.netloc)
    if urlsplit(origin).netloc in known - {""}:
        return None
    return (
        f"This page is open at {origin}, but was asked for as {headers.get('Host', 'nothing')}: "
        "another page may not use it. If a proxy of yours stands in between, start it again with "
        f"--proxy {origin}{folder} and open the address that it prints; {_HOW}."
    )


def _name(host: str) -> str:
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""
