"""Edits of the live page: nodes, wires, undo, saving, and changes of the file by another program."""

import random
import threading
import tomllib
from contextlib import closing, suppress
from functools import partial

import pytest

import hairpipe
from hairpipe.app.api.draft import EMPTY, load_draft
from hairpipe.app.api.source import shipped_graphs
from hairpipe.app.page.edits import EDITS
from hairpipe.app.page.session import Session
from hairpipe.engine.edit import sources_of
from hairpipe.errors import BadInput

from .conftest import SHOT, until


def graph(session):
    return session.document("graph")[0]


def node(session, name):
    return next(one for one in graph(session)["nodes"] if one["name"] == name)


def test_a_graph_is_built_from_nothing_and_saved(tmp_path, folder, empty):
    (tmp_path / "nodes").symlink_to(folder / "nodes")
    assert graph(empty)["nodes"] == [] and graph(empty)["edits"] == ["a new file"]
    empty.change("add", {"type": "make_plate", "at": [10, 20.4]})
    empty.change("add", {"type": "swing"})
    assert "'plate' is not connected" in node(empty, "swing")["fault"]
    assert [one["name"] for one in graph(empty)["nodes"]] == ["plate", "swing"]
    with pytest.raises(BadInput, match="takes Mesh"):
        empty.change("connect", {"node": "swing", "socket": "plate", "source": "swing"})
    empty.change("connect", {"node": "swing", "socket": "plate", "source": "plate"})
    empty.change("switch", {"target": "swing.wave", "on": False})
    assert node(empty, "swing")["settings"]["wave"] is None and node(empty, "swing")["fault"] is None
    empty.save()
    assert (tmp_path / "new.toml").read_text() == (
        EMPTY + '\n[plate]\ntype = "make_plate"\n\n[swing]\ntype = "swing"\nin.plate = "plate"\n'
        "wave = false\n\n[layout]\nplate = [10, 20]\n"
    )
    assert hairpipe.load(tmp_path / "new.toml", cache=tmp_path / "cache").nodes.keys() == {"plate", "swing"}


def test_every_edit_is_undone_and_redone(session):
    edits = [
        ("rename", {"node": "hair", "name": "curls"}),
        ("duplicate", {"nodes": ["picture"], "at": {"picture": [5, 6]}}),
        ("mute", {"nodes": ["lag"], "on": True}),
        ("remove", {"nodes": ["curls", "reach"]}),
        ("disconnect", {"node": "picture", "plug": "hair"}),
        ("move", {"positions": {"plate": [1, 2], "ball": [3, 4]}}),
    ]
    texts = [session._history.text]
    for verb, given in edits:
        session.change(verb, given)
        if session._history.text != texts[-1]:  # an edge goes with its node
            texts.append(session._history.text)
    for text in reversed(texts[:-1]):
        session.undo()
        assert session._history.text == text
    with pytest.raises(BadInput, match="nothing to undo"):
        session.undo()
    for text in texts[1:]:
        session.undo(1)
        assert session._history.text == text


def test_a_new_graph_is_reverted_to_its_beginning_and_saved(tmp_path, empty):
    empty.change("add", {"type": "make_bust"})
    empty.revert()
    assert empty._history.text == EMPTY and not (tmp_path / "new.toml").exists()
    empty.undo()
    empty.save()
    assert '[bust]\ntype = "make_bust"' in (tmp_path / "new.toml").read_text()


@pytest.mark.parametrize(
    "tables", ['[a]\ntype = "load_groom"\n[b]\nin.x = "a"', '[a]\ntype = "load_groom"\nin = 3', "[a]\nmute = 1"]
)
def test_a_faulty_table_after_an_incomplete_node_is_refused(tables, tmp_path):
    with pytest.raises(BadInput):
        load_draft(str(tmp_path / "new.toml"), EMPTY + tables, cache=tmp_path / "cache")


def test_only_values_of_nodes_are_unset(folder):
    text = SHOT + "\n[wedge.colour]\naxes.picture.red = [0.1, 0.2]\n\n[layout]\nhair = [1, 2]\n"
    with closing(Session(load_draft(str(folder / "unset.toml"), text, cache=folder / "cache"))) as session:
        for target in ("hair", "wedge", "schema", "wedge.colour", "hair.in", "layout.hair", "nothing.red"):
            with pytest.raises(BadInput):
                session.change("unset", {"target": target})
            assert session._history.text == text, target


def test_a_request_renews_the_page_once(session, folder):
    edit, redo = partial(session.edit, "picture.red", "0.75"), partial(session.undo, 1)
    for request in (edit, session.undo, redo, session.revert):
        with session._lock:  # nothing polls meanwhile
            revision = session.revision
            request()
            assert session.revision == revision + 1


def test_a_muted_node_is_passed_by(session):
    session.change("add", {"type": "paint", "edges": {"hair": "lag"}})
    session.change("mute", {"nodes": ["lag"], "on": True})
    assert node(session, "lag")["muted"]
    assert session._shot.graph.nodes["paint"].edges["hair"] == ("hair", "")


def test_a_change_by_another_program_is_a_conflict_until_a_version_is_chosen(session, folder):
    theirs = SHOT.replace("strands = 300", "strands = 250")
    session.edit("picture.red", "0.75")
    (folder / "shot.toml").write_text(theirs)
    with pytest.raises(BadInput, match="another program"):
        session.save()
    assert (folder / "shot.toml").read_text() == theirs
    assert "+strands = 250 # three hundred" in graph(session)["conflict"]
    session.resolve("both")
    assert graph(session)["conflict"] is None
    session.save()
    assert (folder / "shot.toml").read_text() == theirs.replace(
        '"paint"\nin.hair = "hair"\n', '"paint"\nin.hair = "hair"\nred = 0.75\n'
    )
    for end in (lambda: session.resolve("file"), session.revert):
        session.edit("picture.red", "0.5")
        (folder / "shot.toml").write_text(SHOT.replace("300", "200"))
        until(lambda: graph(session)["conflict"])
        end()
        assert "strands = 200" in session._history.text and graph(session)["edits"] == []
        (folder / "shot.toml").write_text(SHOT)
        until(lambda: session._history.text == SHOT)
    assert session._history.text == SHOT and graph(session)["edits"] == []


def test_no_edit_of_two_servers_on_one_file_is_lost(shot, folder):
    def edit(session, names):
        for name in names:
            session.change("annotate", {"name": name, "value": {"text": name, "at": [0, 0]}})
            while graph(session)["edits"]:
                try:
                    session.save()
                except BadInput:
                    with suppress(BadInput):  # resolved by the poll meanwhile
                        session.resolve("both")

    names = [[f"{side}{number}" for number in range(10)] for side in "ab"]
    with closing(Session(shot)) as one, closing(Session(shot)) as other:
        threads = [threading.Thread(target=edit, args=given) for given in zip((one, other), names, strict=True)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
    assert tomllib.loads((folder / "shot.toml").read_text())["layout"].keys() == {*names[0], *names[1]}


def test_a_deleted_file_is_saved_again_under_its_name(session, folder):
    session.edit("picture.red", "0.75")
    (folder / "shot.toml").unlink()
    session.save()
    assert "red = 0.75" in (folder / "shot.toml").read_text() and graph(session)["edits"] == []
    (folder / "shot.toml").unlink()
    until(lambda: graph(session)["edits"] == ["a new file"])
    session.save()
    assert "red = 0.75" in (folder / "shot.toml").read_text()


def test_a_copy_is_saved_within_the_project_only_and_becomes_the_file_of_the_page(session, folder):
    outside = ["../out.toml", "nodes/x.toml", ".x.toml", "x.py", "shot.toml", "no/x.toml", f"{300 * 'x'}.toml"]
    for name in (*outside, "\0.toml"):
        with pytest.raises(BadInput):
            session.save_as(name)
    session.edit("picture.red", "0.75")
    session.save_as("other.toml")
    session.edit("picture.red", "0.25")
    session.save()
    assert "red = 0.25" in (folder / "other.toml").read_text() and (folder / "shot.toml").read_text() == SHOT
    (folder / "other.toml").unlink()


def test_no_edit_publishes_outside_of_the_project(session):
    session.change("add", {"type": "paint", "edges": {"hair": "hair"}})
    for place in ("../../x.####.png", "nodes/x.####.png"):
        with pytest.raises(BadInput):
            session.edit("paint.publish", f'"{place}"')


def test_nodes_are_pasted_at_their_places(session):
    text = node(session, "picture")["text"] + node(session, "hair")["text"]
    assert text.startswith('[picture]\ntype = "paint"') and "# What is shown.\n[hair]" in text
    session.change("paste", {"text": text, "at": {"hair": [5, 6]}})
    assert session.draft.tables["picture_2"]["in"] == {"hair": "hair_2"}
    assert graph(session)["layout"] == {"hair_2": [5, 6]}
    assert session.draft.faults.keys() == {"hair_2", "picture_2"}
    with pytest.raises(BadInput, match="no node type 'rm'"):
        session.change("paste", {"text": '[x]\ntype = "rm"'})
    block = '[p]\ntype = "make_plate"\n[h]\ntype = "swing"\nin.plate = "p"\n[x]\ntype = "paint"\nin.hair = "h"\n'
    with pytest.raises(BadInput, match="leaves"):
        session.change("paste", {"text": f'{block}publish = "../../x.####.png"'})


def test_frames_and_notes_change_no_key(session):
    keys = [entry.key for entry in session._plan]
    session.change("annotate", {"value": {"title": "All of it", "nodes": ["hair", "lag"]}})
    session.change("annotate", {"value": {"text": "slow", "at": [1, 2]}})
    assert graph(session)["layout"].keys() == {"frame", "note"}
    session.change("annotate", {"name": "note", "value": {"text": "slower", "at": [1, 2]}})
    assert [entry.key for entry in session._plan] == keys
    for value in ({"text": "x"}, {"text": 3, "at": [1, 2]}, {"title": "x", "nodes": [3]}, {"nodes": 3, "title": "x"}):
        with pytest.raises(BadInput):
            session.change("annotate", {"value": value})
    with pytest.raises(BadInput, match="is a node"):
        session.change("annotate", {"name": "hair", "value": {"text": "x", "at": [1, 2]}})
    session.change("annotate", {"name": "frame", "value": None})
    session.change("annotate", {"name": "note", "value": None})
    assert session._history.text == SHOT


def test_frames_of_the_shot_are_set(session):
    session.change("shot", {"name": "frames", "text": "[1, 7]"})
    session.change("shot", {"name": "preroll", "text": "2"})
    assert graph(session)["frames"] == [1, 7] and graph(session)["preroll"] == 2
    for name, text in (("frames", "[7, 1]"), ("fps", "-1"), ("schema", "2"), ("fps", "24\nx = 1")):
        with pytest.raises(BadInput):
            session.change("shot", {"name": name, "text": text})


def random_deed(draw, draft):
    """An edit as the page asks for it; many are refused."""
    nodes = [*draft.tables]
    one, other = draw.choice(nodes), draw.choice(nodes)
    fields = [*draft.types[one].settings] or ["none"]
    target = f"{one}.{draw.choice(fields)}"
    socket = draw.choice([*draft.types[one].sockets] or ["none"])
    return draw.choice(
        [
            ("add", {"type": draw.choice(["make_bust", "simulate_hair", "grow_groom"]), "at": [draw.randrange(99), 2]}),
            ("remove", {"nodes": [one]}),
            ("rename", {"node": one, "name": f"n{draw.randrange(999)}"}),
            ("duplicate", {"nodes": [one], "like": draw.random() < 0.5}),
            ("mute", {"nodes": [one, other], "on": draw.random() < 0.5}),
            ("connect", {"node": one, "socket": socket, "source": other}),
            ("disconnect", {"node": one, "plug": socket}),
            ("switch", {"target": target, "on": draw.random() < 0.5}),
            ("edit", {"target": target, "text": draw.choice(["1", "0.5", "rod", "true"])}),
            ("unset", {"target": target}),
            ("paste", {"text": sources_of(draft.text)[one], "at": {one: [3, 4]}}),
            ("annotate", {"value": {"title": other, "nodes": [one, other]}}),
            ("annotate", {"name": "note", "value": draw.choice([{"text": one, "at": [3, 4]}, None])}),
            ("shot", {"name": "fps", "text": str(draw.randrange(1, 99))}),
            ("move", {"positions": {one: draw.choice([[1, 2], None])}}),
        ]
    )


@pytest.mark.parametrize("name", ["wedges/tuft"])
def test_random_edits_are_undone_to_the_same_bytes(name, tmp_path):
    draw, made = random.Random(name), 0
    with closing(Session(load_draft(name, cache=tmp_path))) as session:
        for _ in range(40):
            verb, given = random_deed(draw, session.draft)
            before = session._history.text
            try:
                session.change(verb, given)
            except BadInput:
                assert session._history.text == before
            made += session._history.text != before
        assert made > 10
        for _ in range(made):
            session.undo()
        assert session._history.text.encode() == shipped_graphs()[name].read_bytes()
        assert {*EDITS} >= {verb for verb, _ in [random_deed(draw, session.draft) for _ in range(50)]}
