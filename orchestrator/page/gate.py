"""Who may talk to the page: this machine's user, with the token, from the page itself.

Every request, a WebSocket's too, has to name our own host (else a foreign name that
resolves to 127.0.0.1 could read it), to come from our own origin where it changes
anything, and to carry the token: in the address once, in a cookie afterwards.  A body
is limited before it is read.
"""

import secrets
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any, TypeAlias
from urllib.parse import parse_qs

Scope: TypeAlias = MutableMapping[str, Any]
Message: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[Message]]
Send: TypeAlias = Callable[[Message], Awaitable[None]]
App: TypeAlias = Callable[[Scope, Receive, Send], Awaitable[None]]

LARGEST = 200_000_000  # bytes of a body: an FMU with binaries for every platform
REPORT = (  # a report has scripts of its own, which see nothing of the page
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:"
)
_PAGE = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; connect-src 'self'; frame-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)
_HEADERS = (
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cache-control", b"no-store"),
)


class TooLarge(Exception):
    """A body has more bytes than are accepted."""


class Gate:
    """Passes requests of the page's user on to ``app``; refuses all others.

    ``hosts`` are what ``Host`` may say, with the port.
    """

    def __init__(self, app: App, token: str, hosts: Iterable[str]) -> None:
        self._app, self._token, self._hosts = app, token, tuple(hosts)
        self._cookie = f"feeddrive-{self._hosts[0].rpartition(':')[2]}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = {
            k.decode("latin-1"): v.decode("latin-1") for k, v in scope["headers"]
        }
        if why := self._refusal(scope, headers):
            await _refused(scope, send, *why)
        elif scope["type"] == "http" and scope["path"] == "/" and self._asked(scope):
            await self._entered(send)
        else:
            await self._passed(scope, receive, send)

    def _refusal(
        self, scope: Scope, headers: MutableMapping[str, str]
    ) -> tuple[int, str] | None:
        host = headers.get("host", "")
        if host not in self._hosts:
            return 421, "this page is served to its own address only"
        reads = scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
        origin = headers.get("origin")
        if origin != f"http://{host}" and (origin is not None or not reads):
            return 403, "asked by another page"
        token = self._asked(scope) if reads else None
        if not secrets.compare_digest(token or self._held(headers), self._token):
            return 403, "open the address that feeddrive serve printed"
        if int(headers.get("content-length") or 0) > LARGEST:
            return 413, f"more than {LARGEST // 10**6} MB"
        return None

    def _asked(self, scope: Scope) -> str | None:
        """Return the token in the address, if there is one."""
        query = parse_qs(scope["query_string"].decode("latin-1"))
        return query.get("token", [None])[0] if scope["path"] == "/" else None

    def _held(self, headers: MutableMapping[str, str]) -> str:
        """Return the token in the cookie, nothing without one."""
        try:
            found = SimpleCookie(headers.get("cookie", "")).get(self._cookie)
        except CookieError:
            return ""
        return found.value if found and found.value.isascii() else ""

    async def _entered(self, send: Send) -> None:
        """Put the token into a cookie and out of the address."""
        cookie = f"{self._cookie}={self._token}; HttpOnly; SameSite=Strict; Path=/"
        headers = [(b"location", b"/"), (b"set-cookie", cookie.encode()), *_HEADERS]
        await send({"type": "http.response.start", "status": 303, "headers": headers})
        await send({"type": "http.response.body", "body": b""})

    async def _passed(self, scope: Scope, receive: Receive, send: Send) -> None:
        taken = 0

        async def counted() -> Message:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body") or b"")
            if taken > LARGEST:
                raise TooLarge
            return message

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                report = scope["path"].startswith("/report/")
                policy = (REPORT if report else _PAGE).encode()
                own = [*_HEADERS, (b"content-security-policy", policy)]
                message["headers"] = [*message.get("headers", ()), *own]
            await send(message)

        await self._app(scope, counted, guarded)


async def _refused(scope: Scope, send: Send, status: int, why: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": why})
        return
    headers = [(b"content-type", b"text/plain"), (b"connection", b"close"), *_HEADERS]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": f"refused: {why}\n".encode()})
