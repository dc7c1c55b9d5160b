"""Time from an edit on the page to the first new frame in its viewport, by part."""

import json
import statistics
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

from hairpipe.app.api.draft import Draft, load_draft
from hairpipe.app.page.documents import draft_document, state_document
from hairpipe.app.page.edits import edited
from hairpipe.app.page.server import Server
from hairpipe.app.page.session import Session
from hairpipe.app.page.values import script
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.engine.first_frame import HAIR
from hairpipe.graphs.experiments.bench.pictures.browser import browser_path, open_browser
from hairpipe.graphs.experiments.bench.report import Case, Report, make_report

FRAMES = 4
"""Number of frames of the shot: the plan contains them, and their inputs are computed before."""
REPEATS = 5
EDITED, ASKED, RECEIVED, SHOWN = "edit is answered", "run is accepted", "page has the result", "frame is drawn"
BEGUN = "run reaches the node"
PATIENCE = 120.0
"""Time after which a frame counts as not coming [s]."""
IN_PAGE = """(async (target, text, node, frame, patience, runs) => {{
  const now = () => (performance.timeOrigin + performance.now()) / 1000;
  const ended = () => app.base.verdict.last?.number;
  const until = async (holds, idle = false) => {{
    for (const end = now() + patience; !holds(); await new Promise((done) => setTimeout(done, 4))) {{
      if (now() > end || (idle && ended() !== runs)) throw new Error("no new frame");
    }}
    return now();
  }};
  if (app.node !== node) selectNode(node);
  app.set({{ frame }});
  await until(() => ended() === runs);
  const output = () => app.document(node, app.output, "strands"), old = output(), begun = now();
  const fault = await act("edit", {{ target, text }}), edited = now();
  if (fault) throw new Error(fault);
  await act("run", {{ to: [node] }});
  const asked = now(), received = await until(() => output() && output() !== old, true);
  const draws = () => Number(document.body.dataset.drawn), before = draws();
  const shown = await until(() => viewer.items.at(-1)?.document === output() && draws() > before);
  return [begun, edited, asked, received, shown];
}})({})"""
"""Edits, runs and waits as the page does, once it knows of the last run; moments in seconds since 1970."""

Edit = Callable[[str], list[float]]
"""Makes an edit of a text, and returns its `Moments`."""


class Moments(NamedTuple):
    """Moments of an edit in seconds since 1970: its beginning, answers to edit and run, new state, drawn frame."""

    begun: float
    edited: float
    asked: float
    received: float
    shown: float


class Way(NamedTuple):
    """A node of a page, and the setting that is edited."""

    node: str
    frame: int
    target: str


def measure_page_frame(graph: str, overrides: Mapping[str, str], target: str, node: str = HAIR) -> Report:
    """Measure edits of a number on the page of a graph, up to the first new frame of a node; medians.

    The page is in a browser, where there is one; else a client asks the server as the page does, and draws nothing.
    BadInput if the setting is not a number, or the graph cannot be computed.
    """
    with tempfile.TemporaryDirectory() as folder:
        draft = load_draft(graph, cache=folder)
        first = draft.shot.graph.begin
        session = Session(draft, range(first, first + FRAMES))
        try:
            for name, text in overrides.items():
                session.edit(name, text)
            way = Way(node, first, target)
            finish(session, node)
            with served(session) as server, client(session, server, way) as (name, edit):
                values = values_of(session.draft, target)
                cases = [measured(session, edit, way, next(values)) for _ in range(REPEATS + 1)][1:]
            server_case = server_parts(session.draft, way, next(values))
        finally:
            session.close()
    parts = {part: statistics.median(case[part] for case in cases) for case in cases for part in case}
    whole = sum(parts.values())
    rows: list[Case] = [{"part": part, "time [s]": s, "share [%]": 100.0 * s / whole} for part, s in parts.items()]
    return make_report(__name__, {f"page, {name}": rows, "server, of an edit and its answer": server_case})


def values_of(draft: Draft, target: str) -> Iterator[str]:
    """Iterate over numbers near that of a setting, each another one; BadInput if it is not a number."""
    name, *inner = target.split(".")
    value: Any = draft.shot.graph.node(name).settings
    for word in inner:
        value = value.get(word) if isinstance(value, dict) else None
    if isinstance(value, dict):
        value = value.get("value")  # of a table
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise BadInput("not a number", where=target, right="a setting such as hair.material.diameter")
    step = 1 if isinstance(value, int) else 1e-3 * value or 1e-6
    return (repr(value + k * step) for k in range(1, 1000))


def measured(session: Session, edit: Edit, way: Way, text: str) -> dict[str, float]:
    """Measure an edit: time of each part [s], whose sum is the whole; the run ends after it."""
    at = Moments(*edit(text))
    records = session.draft.shot.plan(session.frames, to=way.node).records
    made = sorted(
        (r for t, r in records.items() if r.created > at.begun and t.frame in (None, way.frame)),
        key=lambda r: r.created,
    )
    if not made:
        raise BadInput(f"the edit changes no result of '{way.node}'", where=way.target, right="a number that it uses")
    start = made[0].created - made[0].seconds
    nodes = {f"node {record.node}": record.seconds for record in made}
    between = made[-1].created - start - sum(nodes.values())
    finish(session, way.node)
    parts = {EDITED: at.edited - at.begun, ASKED: at.asked - at.edited, BEGUN: start - at.asked, **nodes}
    return parts | {"between nodes": between, RECEIVED: at.received - made[-1].created, SHOWN: at.shown - at.received}


def finish(session: Session, node: str) -> None:
    """Compute all frames of a node; BadInput where that fails."""
    with_state = lambda: session.document("state")[0]["verdict"]  # noqa: E731
    if not with_state()["running"]:
        session.run([node])
    while (verdict := with_state())["running"]:
        time.sleep(0.02)
    if verdict["failures"]:
        raise BadInput(verdict["failures"][0], where="the run")


def server_parts(draft: Draft, way: Way, text: str) -> list[Case]:
    """Measure the parts of the server's answers in processor seconds: an edit, the plan, the documents."""
    plan = draft.shot.plan()
    parts: dict[str, Callable[[], Any]] = {
        "edit the text": lambda: edited(draft, "edit", {"target": way.target, "text": text}),
        "read and check the graph": lambda: draft.with_text(draft.text),
        "plan: keys and results": draft.shot.plan,
        "costs of earlier results": lambda: draft.shot.costs(draft.shot.nodes),
        "document of the graph": lambda: script("graph", draft_document(draft)),
        "document of the state": lambda: script("state", state_document(draft.shot, plan, lambda name: None)),
    }
    cases: list[Case] = []
    for part, work in parts.items():
        begun = time.process_time()
        for _ in range(REPEATS):
            work()
        cases.append({"part": part, "processor [s]": (time.process_time() - begun) / REPEATS})
    return cases


@contextmanager
def served(session: Session) -> Iterator[Server]:
    """Serve a session in a thread."""
    server = Server(session, 0)
    thread = threading.Thread(target=server.serve)
    thread.start()
    try:
        yield server
    finally:
        server.stop()
        thread.join()


@contextmanager
def client(session: Session, server: Server, way: Way) -> Iterator[tuple[str, Edit]]:
    """Yield a client of the page, and its name: a browser, or requests of this process."""
    path = browser_path()
    if path is None:
        yield "requests without a browser", lambda text: ask(server, way, text)
        return
    with open_browser(path, server.address) as browser:

        def edit(text: str) -> list[float]:
            runs = session.document("state")[0]["verdict"]["last"]["number"]
            given = way.target, text, way.node, way.frame, PATIENCE, runs
            return browser.evaluate(IN_PAGE.format(", ".join(map(json.dumps, given))))

        yield "in a browser", edit


def ask(server: Server, way: Way, text: str) -> list[float]:
    """Edit, run and wait by requests, as the page does; BadInput for a refusal."""

    def get(path: str) -> bytes:
        return urllib.request.urlopen(server.address + path).read()

    def post(deed: str, given: dict[str, Any]) -> None:
        words = server.address + deed, json.dumps(given).encode(), {"Origin": server.origin}
        try:
            urllib.request.urlopen(urllib.request.Request(*words)).read()
        except urllib.error.HTTPError as error:
            raise BadInput(json.loads(error.read())["fault"]) from None

    def result() -> tuple[Any, int]:
        state = json.loads(get("data/state.js").decode().partition(",")[2].rpartition(',"')[0])
        cells = {cell["frame"]: cell for cell in state["nodes"][way.node]["cells"]}
        return cells[way.frame].get("outputs"), state["verdict"]["last"]["number"]

    old, runs = result()
    revision = json.loads(get("wait?seen=0"))["revision"]
    moments = [time.time()]
    post("edit", {"target": way.target, "text": text})
    moments.append(time.time())
    post("run", {"to": [way.node]})
    moments.append(time.time())
    while (after := result())[0] in (None, old) and after[1] == runs and time.time() < moments[0] + PATIENCE:
        revision = json.loads(get(f"wait?seen={revision}"))["revision"]
    found = after[0]
    if found in (None, old):
        raise BadInput("no new frame", where=f"{way.target} = {text}", right="an edit that changes it, and a run of it")
    moments.append(time.time())
    for name in found.values():
        get(f"data/{name}.strands.js")
    return [*moments, time.time()]
