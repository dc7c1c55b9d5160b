"""Serves a live page on this machine, to who knows its address, and to nobody else.

The address holds a random token. Requests for other hosts are refused, which a foreign page can make a browser send to
127.0.0.1 under a name of its own (DNS rebinding), and so are those that come from other pages. Nothing is read but the
files of the page, and what the shot has made, by the names that the cache gives its objects.
"""

import secrets
import socket
from collections.abc import Awaitable, Callable
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.base import BaseHTTPMiddleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Mount, Route

from hairpipe.errors import BadInput
from hairpipe.page.assets import asset, page_html
from hairpipe.page.packing import script
from hairpipe.page.session import Session
from hairpipe.page.values import TYPES

HOST = "127.0.0.1"
LONGEST_WAIT = 20.0
"""After which a page that waits for news is told that there are none [s]."""
GUARD = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
KINDS = {".js": "text/javascript", ".css": "text/css", ".txt": "text/plain"}
Next = Callable[[Request], Awaitable[Response]]


class Server:
    """A page that is served.

    address  of the page, token included; whoever knows it may change settings and start runs
    """

    def __init__(self, session: Session, port: int) -> None:
        """Listen on a port, 0 for a free one; BadInput where it is taken."""
        self._session = session
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._socket.bind((HOST, port))
            self._socket.listen()  # a browser that is quicker than the server waits
        except OSError as error:
            self._socket.close()
            raise BadInput(
                f"port {port} cannot be used: {error.strerror}", where="--port", right="another one"
            ) from None
        token = secrets.token_urlsafe(24)
        self.origin = f"http://{HOST}:{self._socket.getsockname()[1]}"
        self.address = f"{self.origin}/{token}/"
        config = uvicorn.Config(
            application(session, token, self.origin), log_level="error", lifespan="off", access_log=False
        )
        self._server = uvicorn.Server(config)

    def serve(self) -> None:
        """Serve until it is stopped, or interrupted."""
        try:
            self._server.run([self._socket])
        finally:
            self._session.close()

    def stop(self) -> None:
        """End `serve`."""
        self._server.should_exit = True


def application(session: Session, token: str, origin: str) -> Starlette:
    """Make the application: what is asked for below the token, and nothing else."""
    handler = Handler(session)
    routes = [
        Route("/", handler.page),
        Route("/page/{name}", handler.asset),
        Route("/data/{name:path}.js", handler.document),
        Route("/pictures/{name}", handler.picture),
        Route("/wait", handler.wait),
        Route("/explain", handler.explain),
        Route("/play/{node}", handler.play),
        Route("/{deed}", handler.act, methods=["POST"]),
    ]

    async def guarded(request: Request, call_next: Next) -> Response:
        foreign = request.headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none")
        if foreign or request.headers.get("origin", origin) != origin:
            return PlainTextResponse("from another page", 403)
        if request.method == "POST" and request.headers.get("origin") != origin:
            return PlainTextResponse("from no page", 403)
        response = await call_next(request)
        response.headers.update(GUARD)
        return response

    middleware = [
        Middleware(TrustedHostMiddleware, allowed_hosts=[HOST]),
        Middleware(BaseHTTPMiddleware, dispatch=guarded),
    ]
    return Starlette(routes=[Mount(f"/{token}", routes=routes)], middleware=middleware)


class Handler:
    """Answers requests; starlette calls plain methods in threads."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def page(self, request: Request) -> Response:
        """The page."""
        return Response(page_html([], live=True), media_type="text/html")

    def asset(self, request: Request) -> Response:
        """A file of the page."""
        try:
            found = asset(request.path_params["name"])
        except KeyError:
            return PlainTextResponse("no such file", 404)
        return Response(found.read_bytes(), media_type=KINDS[f".{found.name.rpartition('.')[2]}"])

    def document(self, request: Request) -> Response:
        """A document as a script; where there is none, a script that says so."""
        name = request.path_params["name"]
        try:
            text = script(name, *self._session.document(name))
        except KeyError:
            text = script(name, f"{name} is no result of this graph").replace("hairpipe.load", "hairpipe.fail", 1)
        except BadInput as fault:
            text = script(name, str(fault)).replace("hairpipe.load", "hairpipe.fail", 1)
        return Response(text, media_type="text/javascript")

    def picture(self, request: Request) -> Response:
        """A picture."""
        try:
            data, suffix = self._session.picture(request.path_params["name"].rpartition(".")[0])
        except (KeyError, BadInput):
            return PlainTextResponse("no such picture", 404)
        return Response(data, media_type=TYPES[suffix])

    def wait(self, request: Request) -> Response:
        """The latest revision, once it is newer than the one that was seen."""
        seen = request.query_params.get("seen", "0")
        return JSONResponse({"revision": self._session.wait(int(seen) if seen.isdecimal() else 0, LONGEST_WAIT)})

    def explain(self, request: Request) -> Response:
        """What a result is made of."""
        frame = request.query_params.get("frame", "")
        try:
            text = self._session.explain(request.query_params.get("node", ""), int(frame) if frame else None)
        except (BadInput, ValueError) as fault:
            text = str(fault)
        return PlainTextResponse(text)

    def play(self, request: Request) -> Response:
        """Frames of a node as they are made, for as long as the page listens."""
        frames = self._session.play(request.path_params["node"], request.query_params.get("output", ""))
        return StreamingResponse(frames, media_type="application/octet-stream")

    async def act(self, request: Request) -> Response:
        """Carry out a deed; what is wrong with it is the answer."""
        from starlette.concurrency import run_in_threadpool

        deeds: dict[str, Callable[[dict[str, Any]], None]] = {
            "edit": lambda given: self._session.edit(str(given["target"]), str(given["text"])),
            "revert": lambda given: self._session.revert(),
            "save": lambda given: self._session.save(),
            "run": lambda given: self._session.run([str(name) for name in given.get("to", [])]),
            "stop": lambda given: self._session.stop(),
        }
        try:
            given = await request.json()
            await run_in_threadpool(deeds[request.path_params["deed"]], given)
        except (KeyError, TypeError, ValueError):
            return JSONResponse({"fault": "no such deed"}, 400)
        except BadInput as fault:
            return JSONResponse({"fault": str(fault)}, 409)
        return JSONResponse({})
