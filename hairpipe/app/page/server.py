"""Server of a live page on this machine, only for clients with its address.

The address contains a random token. Requests for other host names are refused, against DNS rebinding, and so are those
of other pages. Only files of the page, results of the shot by the names of objects in the cache, and folders and images
of its project are read.
"""
# pyright: reportCallIssue=false

import asyncio
import json
import os
import secrets
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import MutableHeaders
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from hairpipe.app.api.shot import Graph, project_of
from hairpipe.app.page.assets import asset, page_html
from hairpipe.app.page.edits import EDITS
from hairpipe.app.page.playing import Playing
from hairpipe.app.page.session import Session
from hairpipe.app.page.values import TYPES, script, suffix_of
from hairpipe.errors import BadInput

MOST_ENTRIES = 2000  # largest number of listed files of a folder
LARGEST_IMAGE = 1 << 24  # largest size of a shown image [bytes]
HOST = "127.0.0.1"
LONGEST_WAIT = 20.0  # timeout of a request for a newer revision [s]
GUARD = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
KINDS = {".js": "text/javascript", ".css": "text/css", ".txt": "text/plain"}
MOST_DIGITS = 18  # largest length of a number of a page
MOST_BYTES = 1 << 20  # largest size of the body of a request
UNKNOWN = (KeyError, TypeError, ValueError, AttributeError, RecursionError)
"""Exceptions at a request for a missing thing, or with values of other types than those of the page."""
PATIENCE = 1  # time after which pending requests are cancelled at the end [s]


def read_path(graph: Graph, given: str) -> dict[str, Any] | tuple[bytes, str]:
    """List a folder of the project, folders first, or read an image in it, with its suffix."""
    project = project_of(graph.path).resolve()
    try:
        path = graph.file(given).resolve()
        if not any(name.startswith(".") for name in path.relative_to(project).parts):
            if path.is_dir():
                return listed(path, project, graph.path.parent.resolve())
            suffix = suffix_of(path) if path.is_file() else None
            if suffix not in (None, ".svg") and path.stat().st_size <= LARGEST_IMAGE:
                return path.read_bytes(), str(suffix)
    except (OSError, ValueError):  # outside, unreadable, or not a path
        pass
    raise BadInput("not a folder or image of the project", where=given[:80], right=f"a path below {project}")


def listed(folder: Path, project: Path, home: Path) -> dict[str, Any]:
    """List a folder, and the one above it, by paths relative to `home`; links are left out."""
    found = sorted(folder.iterdir(), key=lambda path: (not path.is_dir(), path.name.casefold()))
    named = (path for path in found if not path.name.startswith(".") and path.name.isprintable())
    shown = [path for path in islice(named, MOST_ENTRIES) if path.resolve() == path]
    entries = [
        {"name": path.name, "path": os.path.relpath(path, home), "folder": path.is_dir(), "bytes": path.stat().st_size}
        for path in [*([folder / ".."] if folder != project else []), *shown]
    ]
    return {"folder": os.path.relpath(folder, project), "entries": entries}


class Server:
    """A served page.

    address  of the page, token included; anybody with it may edit and save the graph, and start runs
    """

    def __init__(self, session: Session, port: int) -> None:
        """Listen on a port, 0 for a free one; BadInput where it is taken."""
        self._session = session
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._socket.bind((HOST, port))
            self._socket.listen()  # so that an early browser waits
        except OSError as error:
            self._socket.close()
            what = f"port {port} cannot be used: {error.strerror}"
            raise BadInput(what, where="--port", right="another one") from None
        token = secrets.token_urlsafe(24)
        self.origin = f"http://{HOST}:{self._socket.getsockname()[1]}"
        self.address = f"{self.origin}/{token}/"
        config = uvicorn.Config(
            application(session, token, self.origin),
            log_level="critical",  # no tracebacks of requests that are cancelled at the end
            lifespan="off",
            access_log=False,
            timeout_graceful_shutdown=PATIENCE,
        )
        self._server = Closing(config, session)

    def serve(self) -> None:
        """Serve until `stop` or an interrupt."""
        try:
            self._server.run([self._socket])
        finally:
            self._session.close()

    def stop(self) -> None:
        """End `serve`."""
        self._server.should_exit = True


class Closing(uvicorn.Server):
    """A server that closes its session before its end, so that waiting requests are answered."""

    def __init__(self, config: uvicorn.Config, session: Session) -> None:
        super().__init__(config)
        self._session = session

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        await run_in_threadpool(self._session.close)
        await super().shutdown(sockets)


def application(session: Session, token: str, origin: str) -> Starlette:
    handler = Handler(session)
    routes = [
        Route("/", handler.page),
        Route("/page/{name}", handler.asset),
        Route("/data/{name:path}.js", handler.document),
        Route("/pictures/{name}", handler.picture),
        Route("/wait", handler.wait),
        Route("/files", handler.files),
        Route("/explain", handler.explain),
        Route("/work", handler.work),
        Route("/play/{node}", handler.play),
        Route("/try", handler.trial, methods=["POST"]),
        Route("/{deed}", handler.act, methods=["POST"]),
    ]
    middleware = [Middleware(TrustedHostMiddleware, allowed_hosts=[HOST]), Middleware(Guard, origin=origin)]
    faults = {BadInput: refuse, **dict.fromkeys(UNKNOWN, refuse_unknown)}
    return Starlette(routes=[Mount(f"/{token}", routes=routes)], middleware=middleware, exception_handlers=faults)


def refuse(request: Request, fault: Exception) -> Response:
    return JSONResponse({"fault": str(fault)}, 409 if request.method == "POST" else 404)


def refuse_unknown(request: Request, fault: Exception) -> Response:
    """Answer a request for a missing thing, or with a body that describes nothing."""
    posted = request.method == "POST"
    if not posted and not isinstance(fault, KeyError | ValueError):
        raise fault  # no address can cause it: it is a fault of ours
    return JSONResponse({"fault": "no such deed" if posted else "no such thing"}, 400 if posted else 404)


class Guard:
    """Middleware that refuses requests of other pages, and adds headers to every answer."""

    def __init__(self, inner: ASGIApp, origin: str) -> None:
        self._inner, self._origin = inner, origin

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(GUARD)
            await send(message)

        fault = self._fault(Request(scope)) if scope["type"] == "http" else None
        await (PlainTextResponse(fault, 403) if fault else self._inner)(scope, receive, guarded)

    def _fault(self, request: Request) -> str | None:
        """Return why a request is refused; None for one of the page itself, or to open the page."""
        headers = request.headers
        opens = request.method == "GET" and headers.get("sec-fetch-mode") == "navigate"
        opens = opens and headers.get("sec-fetch-dest") == "document"  # also from the file of `report.redirecting`
        foreign = headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none")
        if (foreign and not opens) or headers.get("origin", self._origin) != self._origin:
            return "from another page"
        return "from no page" if request.method == "POST" and "origin" not in headers else None


async def played(player: Playing) -> AsyncIterator[bytes]:
    """Yield what a process plays, which ends with the connection: also a thread that waits for more of it."""
    try:
        while part := await asyncio.to_thread(player.read):
            yield part
    finally:
        player.close()


async def given_in(request: Request) -> Any:
    """Read the body of a request, which is JSON; ValueError for another one."""
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > MOST_BYTES:
            raise ValueError(f"more than {MOST_BYTES} bytes")
    return json.loads(body)


def read_most(text: str) -> int | None:
    """Read a maximum number of strands; None for the standard one, also in place of another text."""
    return max(1, int(text)) if text.isdecimal() and len(text) <= MOST_DIGITS else None


class Handler:
    """Handlers of requests; starlette calls plain methods in threads."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def page(self, request: Request) -> Response:
        return Response(page_html([], live=True), media_type="text/html")

    def asset(self, request: Request) -> Response:
        found = asset(request.path_params["name"])
        return Response(found.read_bytes(), media_type=KINDS[f".{found.name.rpartition('.')[2]}"])

    def document(self, request: Request) -> Response:
        """A document as a script, `NAME@N` with at most N strands; for a missing one a script with a message."""
        name = request.path_params["name"]
        plain, _, most = name.partition("@")
        try:
            text = script(name, *self._session.document(plain, read_most(most)))
        except (KeyError, BadInput) as fault:
            what = str(fault) if isinstance(fault, BadInput) else f"{name} is not a result of this graph"
            text = script(name, what).replace("hairpipe.load", "hairpipe.fail", 1)
        return Response(text, media_type="text/javascript")

    def picture(self, request: Request) -> Response:
        data, suffix = self._session.picture(request.path_params["name"].rpartition(".")[0])
        return Response(data, media_type=TYPES[suffix])

    def files(self, request: Request) -> Response:
        found = read_path(self._session.draft.shot.graph, request.query_params.get("path", "."))
        return JSONResponse(found) if isinstance(found, dict) else Response(found[0], media_type=TYPES[found[1]])

    async def wait(self, request: Request) -> Response:
        """The latest revision, once it is newer than that of the page, and the one of the graph.

        A page that waits holds no thread: there are few of them, for requests that work.
        """
        seen = request.query_params.get("seen", "0")
        if not seen.isdecimal() or len(seen) > MOST_DIGITS:
            return PlainTextResponse("seen: not the number of a revision", 400)
        session = self._session
        loop = asyncio.get_running_loop()
        news = asyncio.Event()
        with session.heard(lambda: loop.call_soon_threadsafe(news.set)):
            if session.revision <= int(seen) and not session.closed:
                with suppress(TimeoutError):
                    await asyncio.wait_for(news.wait(), LONGEST_WAIT)
        return JSONResponse({"revision": session.revision, "graph": session.drawn})

    def work(self, request: Request) -> Response:
        query = request.query_params
        return JSONResponse(self._session.work(query.get("node", ""), int(query.get("frame", "")[:MOST_DIGITS])))

    def explain(self, request: Request) -> Response:
        frame = request.query_params.get("frame", "")
        try:
            text = self._session.explain(request.query_params.get("node", ""), int(frame) if frame else None)
        except (BadInput, ValueError) as fault:
            text = str(fault)
        return PlainTextResponse(text)

    def play(self, request: Request) -> Response:
        query = request.query_params
        most = read_most(query.get("strands", ""))
        player = self._session.play(request.path_params["node"], query.get("output", ""), most)
        return StreamingResponse(played(player), media_type="application/octet-stream")

    async def trial(self, request: Request) -> Response:
        given = await given_in(request)
        names = [str(given[name]) for name in ("target", "text", "node")]
        return JSONResponse(await run_in_threadpool(self._session.trial, *names, int(given["frame"])))

    async def act(self, request: Request) -> Response:
        """Do an action; the answer is the revision of the graph after it, or a fault."""
        session = self._session
        deeds: dict[str, Callable[[dict[str, Any]], None]] = {
            **{verb: lambda given, verb=verb: session.change(verb, dict(given)) for verb in EDITS},
            "undo": lambda given: session.undo(),
            "redo": lambda given: session.undo(1),
            "save_as": lambda given: session.save_as(str(given["name"])),
            "resolve": lambda given: session.resolve(str(given["keep"])),
            "revert": lambda given: session.revert(),
            "save": lambda given: session.save(),
            "run": lambda given: session.run([str(name) for name in given.get("to", [])]),
            "cook": lambda given: session.cook(str(given["node"]), int(given["frame"])),
            "stop": lambda given: session.stop(),
            "begin": lambda given: session.begin(str(given["name"])),
            "stroke": lambda given: session.stroke(given),
            "drop": lambda given: session.drop(int(given["number"])),
        }

        await run_in_threadpool(deeds[request.path_params["deed"]], await given_in(request))
        return JSONResponse({"revision": session.drawn})
