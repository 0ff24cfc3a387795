"""The server of the page: Starlette behind ``gate``, served by uvicorn on loopback.

Requests that change or describe something are JSON over HTTP; what is drawn comes as
frames over one WebSocket.  Work is done by one thread, runs by one each.
"""

import secrets
import socket
from collections.abc import Awaitable, Callable, Iterable
from importlib.resources import files
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket

from orchestrator.errors import ScenarioError
from orchestrator.page.gate import Gate, TooLarge
from orchestrator.page.project import Project
from orchestrator.page.session import Session
from orchestrator.page.views import Views
from orchestrator.page.work import Work, refusal

STATIC = Path(str(files("orchestrator.page") / "static"))
Handler = Callable[[Request], Awaitable[Response]]


def application(
    project: Project, work: Work, models: Iterable[str], token: str, port: int
) -> Gate:
    """Return the page of a project as an ASGI application."""
    views = Views(project, work, models)

    def answering(view: Callable[..., Any]) -> Handler:
        """Answer with what a view returns, or with its refusal."""

        async def answer(request: Request) -> Response:
            try:
                body = await request.body() if request.method == "POST" else b""
                found = await work.done(view, dict(request.query_params), body)
            except TooLarge:
                return JSONResponse({"error": "more bytes than are accepted"}, 413)
            except Exception as error:
                return JSONResponse({"error": refusal(error)}, 400)
            if isinstance(found, Path):
                return FileResponse(found)
            if isinstance(found, str):
                return Response(found, media_type="image/svg+xml")
            return JSONResponse(found)

        return answer

    async def start(request: Request) -> Response:
        return FileResponse(STATIC / "index.html")

    async def report(request: Request) -> Response:
        """Answer with a page that a run or a verb wrote into the project."""
        try:
            file = project.inside(request.path_params["name"])
        except ScenarioError as error:
            return Response(str(error), 404)
        if file.suffix != ".html" or not file.is_file():
            return Response("there is no such page in this project", 404)
        return FileResponse(file)

    async def watch(asked: WebSocket) -> None:
        await Session(project, work, asked).go_on()

    routes = [
        Route("/", start),
        Route("/report/{name:path}", report),
        WebSocketRoute("/socket", watch),
        Mount("/static", StaticFiles(directory=STATIC)),
        *(
            Route(f"/api/{name}", answering(view), methods=[method])
            for (method, name), view in views.all().items()
        ),
    ]
    hosts = (f"127.0.0.1:{port}", f"localhost:{port}")
    return Gate(Starlette(routes=routes), token, hosts)


def serve(
    folder: Path, port: int, told: Callable[[str], None], models: Iterable[str] = ()
) -> None:
    """Serve the page of a project until Ctrl-C; ``told`` is told its address.

    ``port`` 0 is any that is free; ``models`` are the names of ours.

    Raises:
        ScenarioError: there is no such folder, or the port is taken.
    """
    import uvicorn

    if not folder.is_dir():
        raise ScenarioError(f"{folder}: no such folder")
    listening = socket.socket()
    try:
        listening.bind(("127.0.0.1", port))
        listening.listen()  # the browser may be quicker than what follows
    except OSError as error:
        raise ScenarioError(
            f"--port {port}: {error.strerror}; give another, or 0 for any"
        ) from None
    port = listening.getsockname()[1]
    token = secrets.token_urlsafe(24)
    with Work() as work:
        app = application(Project(folder.resolve()), work, tuple(models), token, port)
        told(f"http://127.0.0.1:{port}/?token={token}")
        config = uvicorn.Config(
            app,
            log_level="warning",
            access_log=False,
            server_header=False,
            ws="websockets-sansio",
            ws_max_size=1_000_000,
            timeout_graceful_shutdown=2,
        )
        uvicorn.Server(config).run(sockets=[listening])
