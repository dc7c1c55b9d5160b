"""Edits of the text of graph files: what is written is what a person would have written."""

import random
import tomllib
from collections import Counter

import pytest

from hairpipe.app.api.source import shipped_graphs
from hairpipe.app.page.edits import Edit, History
from hairpipe.engine import edit as verbs
from hairpipe.engine.file.overrides import nodes_of
from hairpipe.errors import BadInput

GRAPHS = {name: path.read_bytes().decode() for name, path in shipped_graphs().items()}
TEXT = """# The shot.
schema = 1
frames = [1, 5]
fps = 24

[head]
type = "make_bust" # ours

# What is simulated.
[hair]
type = "simulate_hair"
in = { groom = "groom", body = "head" }
# Each hair stands for many.
stiction = { reach = 0.9e-3, force = 2e-6 }

[groom]
type = "grow_groom"
in.scalp = "head"
length = 0.27 # long

[copy]
like = "hair"

[wedge.feel]
axes.hair.stiction.force = [1, 2]
show = ["hair"]
"""


def difference(before, after):
    """Lines that went and lines that came, without order."""
    old, new = before.splitlines(), after.splitlines()
    gone = [line for line in old if old.count(line) > new.count(line)]
    come = [line for line in new if new.count(line) > old.count(line)]
    return sorted(set(gone)), sorted(set(come))


def test_a_node_is_added_above_the_wedges():
    text = verbs.with_node(TEXT, "usd", "export_usd", {"hair": "hair", "body": "head"})
    block = '[usd]\ntype = "export_usd"\nin = { hair = "hair", body = "head" }\n\n'
    assert text == TEXT.replace("[wedge.feel]", block + "[wedge.feel]")
    assert verbs.without_nodes(text, ["usd"]) == TEXT


def test_a_node_is_removed_with_its_comment_and_its_edges():
    text = verbs.without_nodes(TEXT, ["groom"])
    assert "[groom]" not in text and "# What is simulated.\n[hair]" in text
    assert 'in = { body = "head" }' in text and tomllib.loads(text)["hair"]["in"] == {"body": "head"}
    with pytest.raises(BadInput, match="'copy' is like 'hair'"):
        verbs.without_nodes(TEXT, ["hair"])


def test_a_name_is_changed_wherever_it_is_used():
    text = verbs.renamed(TEXT, "hair", "curls")
    lines = ["[curls]", "axes.curls.stiction.force = [1, 2]", 'like = "curls"', 'show = ["curls"]']
    assert difference(TEXT, text)[1] == lines
    assert verbs.renamed(text, "curls", "hair") == TEXT
    for new in ("groom", "hair"):
        with pytest.raises(BadInput, match="exists"):
            verbs.renamed(TEXT, "hair", new)


def test_edges_are_connected_and_cut():
    cut = verbs.without_value(TEXT, "groom.in.scalp")
    assert difference(TEXT, cut) == (['in.scalp = "head"'], [])
    again = verbs.with_value(cut, "groom.in.scalp", '"head"')
    assert tomllib.loads(again) == tomllib.loads(TEXT)
    left = verbs.without_value(TEXT, "copy.in.body")
    assert difference(TEXT, left) == ([], ['without = ["in.body"]'])


def test_a_copy_lies_below_and_publishes_nothing():
    text = verbs.duplicated(TEXT.replace('"head"\nlength', '"head"\npublish = "x.usd"\nlength'), "groom", "groom_2")
    assert tomllib.loads(text)["groom_2"] == {"type": "grow_groom", "in": {"scalp": "head"}, "length": 0.27}
    assert tomllib.loads(verbs.duplicated(TEXT, "hair", "curls", like=True))["curls"] == {"like": "hair"}


def test_a_plain_value_becomes_a_group_and_groups_come_and_go():
    text = verbs.with_value(TEXT, "groom.length.variation", "0.1")
    assert difference(TEXT, text)[1] == ["length = { value = 0.27, variation = 0.1 } # long"]
    on = verbs.with_value(TEXT, "hair.wind", "{}")
    assert difference(TEXT, on) == ([], ["wind = {}"]) and verbs.without_value(on, "hair.wind") == TEXT
    off = verbs.without_value(TEXT, "hair.stiction")
    assert "# Each hair stands for many." in off and "stiction =" not in off


def test_positions_are_a_table_of_their_own_and_no_node():
    text = verbs.placed(TEXT, {"hair": [120, 40], "head": [-10, 0]})
    assert text == TEXT + "\n[layout]\nhair = [120, 40]\nhead = [-10, 0]\n"
    assert "layout" not in nodes_of(tomllib.loads(text))
    assert verbs.placed(text, {"hair": None, "head": None}) == TEXT
    assert "curls = [120, 40]" in verbs.renamed(text, "hair", "curls")


def random_edit(draw, text, tables):
    """An edit of a text with these tables as a page makes it: a verb and what it is given."""
    nodes = nodes_of(tables)
    node = draw.choice([*nodes]) if nodes else ""
    table = nodes.get(node, {})
    settings = [key for key, value in table.items() if key not in ("type", "in", "like", "without")]
    new = f"new_{draw.randrange(10**6)}"
    value = draw.choice(["0.25", '"text"', "[1, 2.5]", "true"])
    edits = [
        lambda: verbs.with_node(text, new, "make_bust", {"a": node, "b": node} if draw.random() < 0.5 else {}),
        lambda: verbs.without_nodes(text, [node]),
        lambda: verbs.renamed(text, node, new),
        lambda: verbs.duplicated(text, node, new, like=draw.random() < 0.3),
        lambda: verbs.with_value(text, f"{node}.mute", "true"),
        lambda: verbs.without_value(text, f"{node}.mute"),
        lambda: verbs.with_value(text, f"{node}.in.extra", f'"{draw.choice([*nodes])}"'),
        lambda: verbs.without_value(text, f"{node}.in.{draw.choice([*table.get('in', {}), 'none'])}"),
        lambda: verbs.with_value(text, f"{node}.{draw.choice([*settings, new])}", value),
        lambda: verbs.with_value(text, f"{node}.{draw.choice([*settings, new])}.inner", value),
        lambda: verbs.without_value(text, f"{node}.{draw.choice([*settings, new])}"),
        lambda: verbs.placed(text, {node: [draw.randrange(900), 3]}),
    ]
    return draw.choice(edits)()


@pytest.mark.parametrize("name", GRAPHS)
def test_many_random_edits_of_a_shipped_graph_parse_and_most_are_made(name):
    draw = random.Random(name)
    text = GRAPHS[name]
    history = History(text, text)
    refused = []
    number_of_edits = 10 if name.startswith("experiments/") else 40
    tables = tomllib.loads(text)
    for number in range(number_of_edits):
        try:
            text = random_edit(draw, text, tables)
            history.push(Edit("", text))
        except BadInput as fault:
            refused.append(str(fault))
        tables = tomllib.loads(text.replace("\r\n", "\n"))
        assert tables["schema"] == 1, number
    layout = [fault for fault in refused if "layout of the" in fault or "change of the layout" in fault]
    assert len(layout) <= 1, layout
    assert len(refused) < 0.3 * number_of_edits, refused
    for _ in range(number_of_edits - len(refused)):
        history.at -= 1
    assert history.text == GRAPHS[name]


@pytest.mark.parametrize("name", GRAPHS)
def test_edits_that_undo_each_other_leave_the_bytes(name):
    text = GRAPHS[name]
    nodes = [*nodes_of(tomllib.loads(text))]
    for node in random.Random(name).sample(nodes, 2):
        assert verbs.renamed(verbs.renamed(text, node, "other_name"), "other_name", node) == text
        assert verbs.without_value(verbs.with_value(text, f"{node}.mute", "true"), f"{node}.mute") == text
        assert verbs.without_nodes(verbs.duplicated(text, node, "other_name"), ["other_name"]) == text
        assert verbs.placed(verbs.placed(text, {node: [1, 2]}), {node: None}) == text
    assert verbs.without_nodes(verbs.with_node(text, "other_name", "make_bust", {}), ["other_name"]) == text


def test_nodes_are_pasted_with_their_comments_and_wires_between_them():
    sources = verbs.sources_of(TEXT)
    block = sources["hair"] + "\n" + sources["groom"]
    assert sources["hair"].startswith("# What is simulated.\n[hair]")
    text, names = verbs.pasted(TEXT, block)
    assert names == {"hair": "hair_2", "groom": "groom_2"}
    hair = sources["hair"].replace("[hair]", "[hair_2]").replace('groom = "groom", body = "head"', 'groom = "groom_2"')
    groom = '[groom_2]\ntype = "grow_groom"\nlength = 0.27 # long\n'
    assert verbs.sources_of(text) == verbs.sources_of(TEXT) | {"hair_2": hair, "groom_2": groom}
    head = "schema = 1\nframes = [1, 5]\nfps = 24\n"
    other, names = verbs.pasted(head, block)
    assert names == {"hair": "hair", "groom": "groom"}
    assert other == f"{head}\n" + block.replace(', body = "head"', "").replace('in.scalp = "head"\n', "")


def test_only_a_pasted_node_of_a_new_name_publishes_nothing():
    block = '[usd]\ntype = "export_usd"\npublish = "out/a.usd"\n'
    first, _ = verbs.pasted(TEXT, block)
    again, names = verbs.pasted(first, block)
    assert tomllib.loads(first)["usd"] == {"type": "export_usd", "publish": "out/a.usd"}
    assert tomllib.loads(again)["usd_2"] == {"type": "export_usd"} and names == {"usd": "usd_2"}


@pytest.mark.parametrize(
    ("block", "what"),
    [
        ("", "no nodes"),
        ("A sentence, from a letter.", "not valid TOML"),
        ("schema = 1\n[a]\ntype = 'preview'\n", "'schema' is not a node"),
        ("[layout]\nhair = [1, 2]\n", "'layout' is not a node"),
        ("[a]\nin = 3\n", "'a' is not a node"),
        ("[b]\nlike = 'hair'\n", "'b' is like 'hair'"),
        ("a.type = 'preview'\n", "cannot be written"),
        ("[[a]]\ntype = 'preview'\n", "'a' is not a node"),
    ],
)
def test_another_text_is_not_pasted(block, what):
    with pytest.raises(BadInput, match=what):
        verbs.pasted(TEXT, block)


def test_frames_of_the_page_follow_their_nodes():
    frame = {"title": "hair", "nodes": ["hair", "groom"]}
    text = verbs.placed(TEXT, {"frame": frame, "note": {"text": 'the "hair" of x', "at": [1, 2]}, "hair": [3, 4]})
    assert verbs.placed(text, {"frame": None, "note": None, "hair": None}) == TEXT
    text = verbs.renamed(text, "hair", "fur")
    layout = tomllib.loads(text)["layout"]
    assert layout["frame"] == {"title": "hair", "nodes": ["fur", "groom"]} and layout["fur"] == [3, 4]
    assert layout["note"]["text"] == 'the "hair" of x'
    text = verbs.without_nodes(text, ["copy", "fur"])
    assert tomllib.loads(text)["layout"]["frame"]["nodes"] == ["groom"]
    assert "frame" not in tomllib.loads(verbs.without_nodes(text, ["groom"]))["layout"]
    with pytest.raises(BadInput, match="exists"):
        verbs.renamed(text, "groom", "note")
    _, names = verbs.pasted(text, '[note]\ntype = "preview"\n')
    assert names == {"note": "note_2"}


def test_values_of_the_shot_are_set_above_the_tables():
    assert verbs.with_header(TEXT, "frames", "[2, 9]") == TEXT.replace("[1, 5]", "[2, 9]")
    assert verbs.with_header(TEXT, "preroll", "3") == TEXT.replace("fps = 24\n", "fps = 24\npreroll = 3\n")


def changed_table(draw, table):
    """A copy of a table with some values changed, removed or added, as another program might write it."""
    found = {}
    for key, value in table.items():
        if isinstance(value, dict):
            found[key] = changed_table(draw, value)
        elif draw.random() < 0.8:
            found[key] = value if draw.random() < 0.6 else draw.choice([0.25, "text", True, [1, 2.5], {"inner": 1}])
    return found | ({"added": draw.choice([2, {"a": 1e-3, "b": "x"}])} if draw.random() < 0.5 else {})


@pytest.mark.parametrize("name", GRAPHS)
def test_tables_are_written_whole_and_all_others_are_kept(name):
    draw = random.Random(name)
    text = GRAPHS[name]
    tables = tomllib.loads(text)
    assert verbs.with_tables(text, {}, nodes_of(tables), ["*"]) == text
    chosen = draw.sample([*nodes_of(tables)], min(3, len(nodes_of(tables))))
    for node in chosen:
        table = changed_table(draw, tables[node])
        edited = verbs.with_tables(text, {}, {node: table}, [])
        assert tomllib.loads(edited) == tables | {node: table}
        kept = [one.text for one in verbs.read_statements(text) if one.kind == "comment" or node not in one.path[:1]]
        assert not Counter(kept) - Counter(one.text for one in verbs.read_statements(edited))
    without = verbs.with_tables(text, {}, {}, chosen)
    assert tomllib.loads(without) == {key: value for key, value in tables.items() if key not in chosen}


def test_new_table_has_a_value_a_line_and_long_groups_below():
    group = {f"number_{number}": number / 8 for number in range(8)}
    table = {"type": "simulate_hair", "in": {"groom": "groom"}, "wave": {"height": 0.1, "on": True}, "long": group}
    text = verbs.with_tables("schema = 1\n", {"frames": [1, 2]}, {"curls": table}, [])
    lines = ['type = "simulate_hair"', 'in.groom = "groom"', "wave = { height = 0.1, on = true }", "", "[curls.long]"]
    numbers = [f"number_{number} = {number / 8}" for number in range(8)]
    assert text.splitlines() == ["schema = 1", "frames = [1, 2]", "", "[curls]", *lines, *numbers]
    assert verbs.with_tables(text, {"frames": [1.0, 2]}, {"curls": table}, ["cu*"]) == text
    assert verbs.with_tables(text, {}, {}, ["cu*"]) == "schema = 1\nframes = [1, 2]\n"


def test_equal_numbers_keep_their_text_and_a_flag_is_not_a_number():
    text = "schema = 1\nfps = 24\n[a]\nb = 1_000 # many\nc = true\n"
    assert verbs.with_tables(text, {"fps": 24.0}, {"a": {"b": 1000.0, "c": True}}, []) == text
    assert "c = 1" in verbs.with_tables(text, {}, {"a": {"b": 1000, "c": 1}}, [])
