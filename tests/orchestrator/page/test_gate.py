"""The page attacked: what is not its user's, or not from itself, is refused."""

import asyncio
import http.client
from types import SimpleNamespace
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from orchestrator.page import gate

UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec_WebSocket_Version": "13",
    "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


def ask(
    site: SimpleNamespace,
    path: str = "/api/project",
    method: str = "GET",
    *,
    cookie: str | None = None,
    **headers: str,
) -> tuple[int, str]:
    """Return status and body of a request with the user's cookie, or another."""
    host, _, port = site.host.partition(":")
    asked = http.client.HTTPConnection(host, int(port), timeout=20)
    own = f"feeddrive-{port}={site.token}" if cookie is None else cookie
    given = {"Cookie": own, **{k.replace("_", "-"): v for k, v in headers.items()}}
    try:
        asked.putrequest(method, path, skip_host="Host" in given)
        for name, value in given.items():
            asked.putheader(name, value)
        asked.endheaders()
        answer = asked.getresponse()
        return answer.status, answer.read().decode()
    finally:
        asked.close()


def test_the_user_is_answered(site: SimpleNamespace) -> None:
    status, body = ask(site)
    assert status == 200
    assert "tests/speed_step.toml" in body


@pytest.mark.parametrize("cookie", ["", "feeddrive-1=x", "feeddrive-{port}=wrong", "é"])
@pytest.mark.parametrize("path", ["/", "/api/project", "/static/app.js", "/report/x"])
def test_without_the_token_nothing_is_answered(
    site: SimpleNamespace, cookie: str, path: str
) -> None:
    port = site.host.partition(":")[2]
    status, body = ask(site, path, cookie=cookie.format(port=port))
    assert status == 403
    assert body == "refused: open the address that feeddrive serve printed\n"


def test_a_wrong_token_in_the_address_is_refused(site: SimpleNamespace) -> None:
    assert ask(site, f"/?token={site.token}", cookie="")[0] == 303
    assert ask(site, f"/?token={site.token}x", cookie="")[0] == 403
    assert ask(site, f"/api/project?token={site.token}", cookie="")[0] == 403


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Host": "evil.example"}, 421),
        ({"Host": "evil.example:{port}"}, 421),
        ({"Host": "127.0.0.1"}, 421),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": "http://localhost:{port}"}, 403),
    ],
)
def test_another_origin_or_host_is_refused(
    site: SimpleNamespace, headers: dict[str, str], status: int
) -> None:
    port = site.host.partition(":")[2]
    given = {name: value.format(port=port) for name, value in headers.items()}
    assert ask(site, **given)[0] == status
    assert ask(site, "/socket", **UPGRADE, **given)[0] == 403


def test_a_change_or_a_socket_without_an_origin_is_refused(
    site: SimpleNamespace,
) -> None:
    assert ask(site, method="POST")[0] == 403
    assert ask(site, "/socket", **UPGRADE)[0] == 403


def test_a_socket_needs_the_token_and_sense(site: SimpleNamespace) -> None:
    origin = f"http://{site.host}"
    assert ask(site, "/socket", **UPGRADE, Origin=origin, cookie="")[0] == 403
    own = f"feeddrive-{site.host.partition(':')[2]}={site.token}"
    address = f"ws://{site.host}/socket"
    cookie = {"Cookie": own}
    with connect(address, origin=origin, additional_headers=cookie, proxy=None) as one:
        one.send("no JSON")
        with pytest.raises(ConnectionClosed, match="1003"):
            one.recv(timeout=20)


@pytest.mark.parametrize(
    "path",
    [
        "/static/../server.py",
        "/static/%2e%2e/server.py",
        "/static/..%2f..%2ferrors.py",
        "/static//etc/passwd",
        "/report/../outside.html",
        "/report/pyproject.toml",
        "/report/..%2foutside.html",
        "/report/..%2f..%2fpyproject.toml",
        "/report/%2fetc%2fpasswd",
        "/api/scenario?name=../outside.toml",
        "/api/scenario?name=/etc/passwd",
        "/api/scenario?name=%2fetc%2fpasswd.toml",
        "/api/scenario?name=link.toml",
        "/api/scenario?name=a%00.toml",
    ],
)
def test_nothing_outside_of_the_project_is_read(
    site: SimpleNamespace, path: str
) -> None:
    outside = site.folder.parent / "outside.toml"
    outside.write_text('title = "secret"')
    outside.with_suffix(".html").write_text("secret")
    link = site.folder / "link.toml"
    if not link.is_symlink():
        link.symlink_to(outside)
    status, body = ask(site, path)
    assert status in (400, 404)
    assert "secret" not in body
    assert "root:" not in body


def test_a_body_of_two_gigabytes_is_refused_before_it_is_sent(
    site: SimpleNamespace,
) -> None:
    origin = f"http://{site.host}"
    status, body = ask(
        site, "/api/upload", "POST", Origin=origin, Content_Length="2000000000"
    )
    assert (status, body) == (413, "refused: more than 200 MB\n")


def test_a_body_that_does_not_say_its_size_is_cut_off(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(gate, "LARGEST", 1000)
    taken = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        while True:
            taken.append(len((await receive())["body"]))

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": b"x" * 300, "more_body": True}

    scope = {
        "type": "http",
        "method": "POST",
        "path": "/api/upload",
        "query_string": b"",
        "headers": [
            (b"host", b"127.0.0.1:1"),
            (b"origin", b"http://127.0.0.1:1"),
            (b"cookie", b"feeddrive-1=t"),
        ],
    }
    guarded = gate.Gate(app, "t", ["127.0.0.1:1"])
    with pytest.raises(gate.TooLarge):
        asyncio.run(guarded(scope, receive, app))
    assert taken == [300, 300, 300]
