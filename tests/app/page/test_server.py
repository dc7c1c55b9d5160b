"""The server answers who knows its address, from no other page, and reads nothing else."""

import http.client
import json
import threading
import time
import webbrowser
from contextlib import closing
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from hairpipe.app.page.report import opened
from hairpipe.app.page.server import Server
from hairpipe.app.page.session import Session
from hairpipe.errors import BadInput

from .conftest import until


@pytest.fixture
def served(shot):
    session = Session(shot)
    server = Server(session, 0)
    thread = threading.Thread(target=server.serve)
    thread.start()
    server.session = session
    yield server
    server.stop()
    thread.join(20)
    assert not thread.is_alive()


def ask(server, path, method="GET", body=None, **headers):
    """Ask for a path below the address, or for a whole one; status and text."""
    place = urlsplit(server.address)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=20)
    connection.request(method, path if path.startswith("/") else place.path + path, body, headers)
    answer = connection.getresponse()
    return answer.status, answer.read().decode("utf-8", "replace"), dict(answer.getheaders())


def test_it_serves_the_page_its_files_and_documents(served):
    status, page, headers = ask(served, "")
    assert status == 200 and 'data-live="true"' in page
    assert "frame-ancestors 'none'" in headers["content-security-policy"]
    assert ask(served, "page/core.js")[0] == 200
    assert ask(served, "page/style.css")[2]["content-type"].startswith("text/css")
    status, text, _ = ask(served, "data/graph.js")
    assert status == 200 and text.startswith('hairpipe.load("graph",{"name":"shot"')


def test_nothing_else_is_there(served):
    below = ["page/../server.py", "page/..%2fserver.py", "page/%2e%2e/assets.py", "other", "page/"]
    for path in ["/", "/guess/", "/data/graph.js", *below]:
        assert ask(served, path)[0] >= 300, path


def test_an_unknown_document_is_a_message(served):
    for name in ("0000.h5.mesh", "../../shot.toml", "%2e%2e/%2e%2e/shot.toml", "index", "graph.x", "<b>"):
        status, text, _ = ask(served, f"data/{name}.js")
        assert status in (200, 404) and "schema = 1" not in text and "<" not in text, name
        assert status == 404 or text.startswith("hairpipe.fail("), name


def test_other_pages_are_refused(served):
    sites, origins = ("cross-site", "same-site"), ("http://evil.example", "null")
    strange = [{"Host": "evil.example"}, *({"Origin": one} for one in origins), *({"Sec-Fetch-Site": s} for s in sites)]
    for headers in strange:
        for method, path in (("GET", ""), ("GET", "data/graph.js"), ("POST", "revert")):
            status, text, _ = ask(served, path, method, "{}", **headers)
            assert status in (400, 403) and "hairpipe.load" not in text, headers


def test_deeds_need_the_page_and_sense(served):
    assert ask(served, "revert", "POST", "{}")[0] == 403
    own = {"Origin": served.origin}
    assert ask(served, "revert", "POST", "{}", **own)[0] == 200
    for deed, body in (("explode", "{}"), ("edit", "{}"), ("edit", "[]"), ("edit", "no json"), ("run", '{"to": 3}')):
        assert ask(served, deed, "POST", body, **own)[0] == 400, (deed, body)
    status, text, _ = ask(served, "edit", "POST", '{"target": "hair.strands", "text": "0"}', **own)
    assert status == 409 and "strands = 0" in text and ">= 1" in text


def test_files_of_the_project_alone_are_listed_and_shown(served, folder, tmp_path):
    from PIL import Image

    (folder / "paint").mkdir(exist_ok=True)
    (tmp_path / "secret.png").write_bytes(b"\x89PNG")
    if not (folder / "paint" / "out").is_symlink():
        (folder / "paint" / "out").symlink_to(tmp_path)
        (folder / ".hidden").mkdir()
    Image.new("L", (2, 2)).save(folder / "paint" / "map.png")
    Image.new("L", (2, 2)).save(folder / ".hidden" / "map.png")
    listed = json.loads(ask(served, "files?path=paint")[1])
    assert listed["folder"] == "paint" and [one["name"] for one in listed["entries"]] == ["..", "map.png"]
    assert [one["path"] for one in listed["entries"]] == [".", "paint/map.png"]
    names = [one["name"] for one in json.loads(ask(served, "files")[1])["entries"]]
    assert "shot.toml" in names and ".." not in names and ".hidden" not in names
    status, _, headers = ask(served, "files?path=paint/map.png")
    assert status == 200 and headers["content-type"] == "image/png"
    outside = [str(tmp_path), "..", "paint/out", "paint/out/secret.png", ".hidden/map.png", "%00", "paint/../../", "/"]
    for path in [*outside, "shot.toml", "paint/none.png", 5000 * "x"]:
        status, text, _ = ask(served, f"files?path={path}")
        assert status == 404 and "entries" not in text, path
    for headers in ({"Origin": "http://evil.example"}, {"Sec-Fetch-Site": "cross-site"}, {"Host": "evil.example"}):
        assert ask(served, "files", **headers)[0] in (400, 403)
        assert ask(served, "files?path=paint/map.png", **headers)[0] in (400, 403)


def test_a_port_that_is_taken_is_a_message(served, shot):
    port = urlsplit(served.address).port
    with closing(Session(shot)) as session, pytest.raises(BadInput, match=f"port {port} cannot be used"):
        Server(session, port)


def test_the_address_is_a_secret(shot):
    with closing(Session(shot)) as session:
        addresses = {Server(session, 0).address for _ in range(3)}
    assert len(addresses) == 3 and all(len(urlsplit(a).path) > 30 for a in addresses)


def test_a_player_ends_with_its_page(served):
    """Whether the page reads what it is sent, or has stopped to."""
    place = urlsplit(served.address)
    for read in (True, False):
        connection = http.client.HTTPConnection(place.hostname, place.port, timeout=60)
        connection.request("GET", f"{place.path}play/lag")
        answer = connection.getresponse()
        assert answer.status == 200 and (not read or len(answer.read(100)) == 100)
        player = served.session._players[-1]
        assert not player.ended
        answer.close()
        connection.close()
        until(lambda player=player: player.ended)


def test_the_end_waits_for_no_page(served):
    """Neither for one that waits for news, up to 20 s, nor for one that plays."""
    waiting = [threading.Thread(target=ask, args=(served, path)) for path in ("wait?seen=999", "play/lag")]
    for thread in waiting:
        thread.start()
    until(lambda: served.session._players)
    time.sleep(0.2)
    begun = time.monotonic()
    served.stop()
    for thread in waiting:
        thread.join(10)
        assert not thread.is_alive()
    assert time.monotonic() - begun < 10 and served.session._players[-1].ended


def test_many_waiting_pages_delay_no_request(served):
    """More than there are threads for requests that work."""
    waiting = [threading.Thread(target=ask, args=(served, "wait?seen=999")) for _ in range(60)]
    for thread in waiting:
        thread.start()
    time.sleep(0.3)
    begun = time.monotonic()
    assert ask(served, "data/graph.js")[0] == 200
    assert time.monotonic() - begun < 5
    served.session.edit("hair.strands", "301")  # news for all
    for thread in waiting:
        thread.join(10)
        assert not thread.is_alive()


def test_numbers_and_bodies_that_no_page_sends_are_refused(served):
    for seen in ("9" * 5000, "-1", "", "x", "1e3"):
        status, text, _ = ask(served, f"wait?seen={seen}")
        assert status == 400 and text == "seen: not the number of a revision"
    for body in ("[" * 100_000, '{"a":' * 100_000, "9" * 5000, '{"to": ["' + "x" * (2 << 20) + '"]}'):
        status, text, _ = ask(served, "run", "POST", body, Origin=served.origin)
        assert status == 400 and text == '{"fault":"no such deed"}'


def test_only_a_person_opens_the_page_from_elsewhere(served):
    opening = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document"}
    assert ask(served, "", **opening)[0] == 200
    assert ask(served, "revert", "POST", "{}", **opening)[0] == 403
    assert ask(served, "", **opening | {"Sec-Fetch-Dest": "iframe"})[0] == 403
    assert ask(served, "", **opening | {"Sec-Fetch-Mode": "no-cors"})[0] == 403


def test_the_secret_is_in_no_command_line(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    asked = []
    monkeypatch.setattr(webbrowser, "open", asked.append)
    with opened("http://127.0.0.1:1/0123abcd/"):
        (address,) = asked
        path = Path(unquote(address.removeprefix("file://")))
        assert "0123abcd" not in address and "url=http://127.0.0.1:1/0123abcd/" in path.read_text()
        assert path.stat().st_mode & 0o077 == 0 and path.is_relative_to(tmp_path)
    assert not path.exists() and not list((tmp_path / "hairpipe" / "pages").iterdir())
