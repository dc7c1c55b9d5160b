"""Long work on the page in a real browser: the queue of runs, time left, notifications, warnings with their frames."""

import pytest

import hairpipe
from hairpipe.app.page.session import Session

from .conftest import SHOT
from .live_page import Page, do, served

pytestmark = pytest.mark.slow
NOTIFICATION = """window.told = [];
    window.Notification = class {
        static permission = 'default';
        static requestPermission() {
            told.push('asked');
            Notification.permission = 'granted';
            return Promise.resolve('granted');
        }
        constructor(title, { body }) { told.push(title, body); }
    };"""


def text_of(page, selector):
    return page.ask("document.querySelector(arguments[0])?.innerText ?? ''", selector)


@pytest.fixture
def held(opened, folder):
    """A page whose runs last until a file `go` is written, after all frames of the hair."""
    gate = f'[gate]\ntype = "stay"\nin.hair = "hair"\nuntil = "{folder / "go"}"\n'
    (folder / "held.toml").write_text(SHOT.replace("[picture]", f"{gate}[picture]"))
    session = Session(hairpipe.load(folder / "held.toml", cache=folder / "cache"))
    with served(session) as address:
        yield Page(opened(address), session)
    (folder / "go").touch()


def test_runs_wait_in_a_queue_while_frames_are_looked_at(held):
    driver = held.driver
    do(driver, "selectNode('hair'); app.set({ frame: 1 })")
    assert "disk" in text_of(held, "#work") and not driver.find_elements("css selector", "#work .task")
    held.session.edit("hair.strands", "500")
    held.settle()
    held.find("#do-run").click()
    held.until(lambda: "hair.strands = 500" in text_of(held, "#work b"))
    held.session.edit("picture.red", "0.375")
    held.settle()
    held.find("#do-run").click()
    held.until(lambda: "picture.red = 0.375" in text_of(held, "#work .waiting"))
    held.find("#do-run").click()
    held.until(lambda: "is in progress or waits" in driver.execute_script("return document.body.dataset.refused"))
    held.until(lambda: driver.execute_script("return app.cell('hair', 1).state") in ("computed", "cached"), 60)
    held.until(lambda: "gate 0/1" in text_of(held, "#work"), 60)
    held.until(lambda: driver.execute_script("return viewer?.items.at(-1)?.total") == 500)
    drawn = driver.execute_script("return Number(document.body.dataset.drawn)")
    slider = held.find("#frame")
    do(driver, "arguments[0].value = 2; arguments[0].dispatchEvent(new Event('input'))", slider)
    held.until(lambda: driver.execute_script("return Number(document.body.dataset.drawn)") > drawn)
    assert driver.execute_script("return app.frame") == 2
    held.find("#work .waiting button").click()
    held.until(lambda: not driver.find_elements("css selector", "#work .waiting"))
    assert driver.execute_script("return app.base.verdict.running")
    held.find("#do-stop").click()
    held.until(lambda: not driver.execute_script("return app.base.verdict.running"), 60)
    assert driver.execute_script("return app.base.verdict.last.interrupted")
    assert driver.execute_script("return document.body.dataset.errors") == "0"


def test_the_end_of_a_long_run_is_notified_after_a_question(live):
    driver = live.driver
    do(driver, NOTIFICATION)
    ended = "return app.base.verdict.last.number"
    live.session.edit("picture.red", "0.1875")
    live.settle()
    live.find("#do-run").click()
    live.until(lambda: driver.execute_script(ended) == 1, 60)
    assert driver.execute_script("return told") == []
    driver.execute_script("runs.long = 0")
    live.session.edit("picture.red", "0.3125")
    live.settle()
    live.find("#do-run").click()
    live.until(lambda: driver.execute_script(ended) == 2, 60)
    asked, title, body = driver.execute_script("return told")
    assert (asked, title) == ("asked", "shot is computed")
    assert body.startswith("picture.red = 0.3125: 5 results in ")


def test_frames_of_failures_and_warnings_are_links(opened, folder):
    torn = SHOT.replace("[picture]", '[torn]\ntype = "tear"\nin.hair = "hair"\n[picture]')
    (folder / "torn.toml").write_text(torn)
    session = Session(hairpipe.load(folder / "torn.toml", cache=folder / "cache"))
    with served(session) as address:
        page = Page(opened(address), session)
        page.find("#do-run").click()
        page.until(lambda: "torn@3" in text_of(page, ".failure a"), 60)
        page.find(".failure a").click()
        assert page.ask("[app.node, app.frame]") == ["torn", 3]
        page.until(lambda: page.all("#log summary"))
        page.find("#log summary").click()
        assert "frayed" in text_of(page, "#log p")
        page.find("#log a[data-frame='4']").click()
        assert page.ask("[app.node, app.frame]") == ["torn", 4]
