"""A shot of every kind of result, computed once, and a browser to look at it."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

import hairpipe
from hairpipe.app.api.draft import EMPTY, load_draft
from hairpipe.app.page.session import Session
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.node.import_paths import leave
from hairpipe.engine.worker import machine_code

from ..cli.conftest import START
from .live_page import Page, served

TOYS = Path(__file__).parent / "toys"
SHOT = """schema = 1 # of the file
frames = [1, 5]
fps = 24

[ball]
type = "make_ball"

[plate]
type = "make_plate"

# What is shown.
[hair]
type = "swing"
in.plate = "plate"
strands = 300 # three hundred
wave = { height = 0.03 } # as high as that

[lag]
type = "trail"
in.hair = "hair"

[height]
type = "sense"
in.hair = "hair"

[picture]
type = "paint"
in.hair = "hair"

[reach]
type = "count"
in.hair = "hair"
"""
BROWSER, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
FLAGS = """--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --window-size=1000,900
    --no-first-run --disable-background-networking --disable-component-update --disable-sync --disable-quic"""


def write_shot(folder: Path) -> Path:
    """Write the graph file and its node types."""
    shutil.copytree(TOYS, folder / "nodes", ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "shot.toml").write_text(SHOT)
    return folder / "shot.toml"


@pytest.fixture(scope="session")
def computed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the shot was run once, to copy."""
    folder = tmp_path_factory.mktemp("computed")
    write_shot(folder)
    variables = {"HAIRPIPE_TRUST": str(folder / "nodes"), "HAIRPIPE_CACHE": str(folder / "cache")}
    subprocess.run([*START, "run", "shot.toml", "-j1", "-q"], cwd=folder, env=os.environ | variables, check=True)
    return folder


@pytest.fixture(scope="module")
def folder(computed: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of a shot that was run: its nodes are trusted, and need no kernel of ours."""
    folder = tmp_path_factory.mktemp("page")
    shutil.copytree(computed, folder, dirs_exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HAIRPIPE_TRUST", str(folder / "nodes"))
        patch.setenv("HAIRPIPE_CACHE", str(folder / "cache"))
        patch.setattr(machine_code, "kernel_modules", lambda: iter(()))
        before = set(sys.modules)
        (known,) = (folder / "cache" / "latest").iterdir()
        known.rename(known.with_name(load_graph(folder / "shot.toml").name))
        yield folder
        # From the one path of the process: a session that was just closed may still be reading the code of its graph.
        leave(str(folder / "nodes"))
        for name in set(sys.modules) - before:
            if str(folder) in str(getattr(sys.modules[name], "__file__", "")):
                del sys.modules[name]


@pytest.fixture
def shot(folder: Path) -> hairpipe.Shot:
    """The shot, all of it in the cache."""
    (folder / "shot.toml").write_text(SHOT)
    return hairpipe.load(folder / "shot.toml", cache=folder / "cache")


@pytest.fixture
def session(shot: hairpipe.Shot) -> Iterator[Session]:
    """A session of the shot, without a page."""
    with closing(Session(shot)) as made:
        yield made


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Session]:
    """A session of a new file in the current folder."""
    monkeypatch.chdir(tmp_path)
    with closing(Session(load_draft("new.toml", EMPTY, cache=tmp_path / "cache"))) as made:
        yield made


def until(true: Callable[[], object], most: float = 60.0) -> None:
    """Wait until a condition holds."""
    end = time.monotonic() + most
    while not true():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.02)


@pytest.fixture(scope="session")
def chromium() -> Iterator:
    """A browser without a screen; skipped where there is none."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="no selenium")
    if not (BROWSER and DRIVER):
        absent = "no browser to test pages in: Debian's packages chromium and chromium-driver"
        (pytest.fail if "PAGE_PICTURES" in os.environ else pytest.skip)(absent)
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for flag in FLAGS.split():
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    from .lasting import Driver

    driver = Driver(options=options, service=webdriver.ChromeService(DRIVER))
    driver.set_script_timeout(30)
    yield driver
    driver.quit()


@pytest.fixture
def opened(chromium) -> Callable:
    """Open a page and wait until it is ready; fails where it reports an error."""
    from selenium.webdriver.support.ui import WebDriverWait

    def open_page(address: str):
        chromium.get("about:blank")
        chromium.get_log("browser"), chromium.get_log("performance")
        chromium.get(address)
        ready = "return [document.body.dataset.state, document.body.dataset.errors]"
        WebDriverWait(chromium, 30).until(lambda driver: driver.execute_script(ready)[0] == "ready")
        assert chromium.execute_script(ready) == ["ready", "0"]
        return chromium

    return open_page


@pytest.fixture
def shown(chromium, opened: Callable) -> Callable:
    """Show a page, for tests that only look: one that the browser shows already stays as it is."""
    return lambda address: chromium if chromium.current_url == address else opened(address)


@pytest.fixture(scope="module")
def watched(folder: Path) -> Iterator[tuple[Session, str]]:
    """A session of the shot that computes nothing unasked, and the address of its page."""
    (folder / "shot.toml").write_text(SHOT)
    session = Session(hairpipe.load(folder / "shot.toml", cache=folder / "cache"))
    session.cook = lambda node, frame: None
    with served(session) as address:
        yield session, address


@pytest.fixture
def looked(shown: Callable, watched: tuple[Session, str]) -> Page:
    """One live page of the shot for all tests of a module that change nothing but what is shown."""
    session, address = watched
    return Page(shown(address), session)


@pytest.fixture
def undone(looked: Page) -> Iterator[Page]:
    """The same page for tests that edit the graph, and neither save it nor change what is not in it."""
    yield looked
    looked.undo_all()


@pytest.fixture
def live(opened: Callable, shot: hairpipe.Shot) -> Iterator[Page]:
    """The live page of the shot."""
    session = Session(shot)
    with served(session) as address:
        yield Page(opened(address), session)
