"""Graph files: what is wrong is said once, with file and line and what would be right; nothing else is ever raised."""

import os
from contextlib import suppress

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hairpipe.engine.file.load import load_graph
from hairpipe.errors import BadInput

HEAD = "schema = 1\nframes = [1, 10]\nfps = 24\n"
SEED = HEAD + '[seed]\ntype = "make_seed"\n'
MOVE = SEED + '[move]\ntype = "move_seed"\nin.seed = "seed"\n'
SUM = MOVE + '[sum]\ntype = "add_up"\nin.number = "move"\n'
LIST = SUM + '[list]\ntype = "write_list"\nin.numbers = "sum"\n'
FULL = LIST + 'publish = "out/list.txt"\n[draw]\ntype = "draw_number"\nin.number = "sum.number"\npublish = "####.png"\n'

HEXADECIMAL = "0x" + "f" * 5000
BAD = {
    "empty": ("", "no schema", "schema = 1"),
    "schema": (SEED.replace("schema = 1", "schema = 9"), ":1: schema = 9", "schema = 1"),
    "no TOML": (SEED + "[seed", "not valid TOML", ""),
    "twice": (SEED + SEED[len(HEAD) :], "not valid TOML", ""),
    "deep": (SEED + "value = " + "[" * 5000, "not valid TOML: nested too deeply", ""),
    "key": (SEED.replace("fps", "fsp"), ":3: unknown key 'fsp'", "did you mean 'fps'?"),
    "no fps": (SEED.replace("fps = 24", ""), "no fps", "fps = 24"),
    "fps 0": (SEED.replace("24", "0"), ":3: fps = 0", "0.01 to 100000"),
    "fps nan": (SEED.replace("24", "nan"), ":3: fps = nan", ""),
    "fps true": (SEED.replace("24", "true"), ":3: fps = True", ""),
    "no frames": (SEED.replace("frames = [1, 10]", ""), "no frames", "frames = [first, last]"),
    "frames back": (SEED.replace("[1, 10]", "[10, 1]"), ":2: frames = [10, 1]", "first <= last"),
    "frames float": (SEED.replace("[1, 10]", "[1.0, 10]"), ":2: frames = [1.0, 10]", "whole numbers"),
    "preroll back": (SEED.replace("fps = 24", "fps = 24\npreroll = -1"), "preroll = -1", "not negative"),
    "preroll float": (SEED.replace("fps = 24", "fps = 24\npreroll = 1.5"), "preroll = 1.5", "a whole number"),
    "cuts of a node": (SEED + "cuts = [5]\n", ":6: [seed] make_seed: unknown setting 'cuts'", "above all tables"),
    "cuts number": (SEED.replace("fps = 24", "fps = 24\ncuts = 5"), ":4: cuts = 5", "ascending"),
    "cuts back": (SEED.replace("fps = 24", "fps = 24\ncuts = [7, 5]"), "cuts = [7, 5]", "frame numbers"),
    "cuts float": (SEED.replace("fps = 24", "fps = 24\ncuts = [7.0]"), "cuts = [7.0]", "frame numbers"),
    "frames huge": (SEED.replace("[1, 10]", "[1, 99999999999]"), ":2: frames", "at most 1000000"),
    "no nodes": (HEAD, "no nodes", "[head]"),
    "array": (HEAD + '[[seed]]\ntype = "make_seed"\n', "unknown key 'seed'", "a table [seed]"),
    "name": (HEAD + '["a.b"]\ntype = "make_seed"\n', ":4: ['a.b']".replace("'", ""), "a letter"),
    "no type": (HEAD + "[seed]\n", ":4: [seed]: no type", "hairpipe nodes"),
    "type 3": (HEAD + "[seed]\ntype = 3\n", ":5: [seed]: type = 3", ""),
    "type": (HEAD + '[seed]\ntype = "make_sead"\n', ":5: [seed]: no node type 'make_sead'", "'make_seed'?"),
    "type path": (HEAD + '[seed]\ntype = "../make_seed"\n', "no node type", ""),
    "no node in file": (HEAD + '[seed]\ntype = "tally"\n', "declares no node", "@node"),
    "setting": (SEED + "valeu = 3\n", ":6: [seed] make_seed: unknown setting 'valeu'", "'value'?"),
    "text": (SEED + 'value = "3"\n', ':6: [seed] make_seed: value = "3"', "a number"),
    "bool": (SEED + "value = true\n", ":6: [seed] make_seed: value = true", "a number"),
    "nan": (SEED + "value = nan\n", "value = NaN is not a finite number", "a number"),
    "inf": (SEED + "value = -inf\n", "not a finite number", "a number"),
    "date": (SEED + "value = 2020-01-01\n", "a date", ""),
    "huge": (SEED + "value = 1" + "0" * 4000, "value = 1000", "a number"),
    "huger": (SEED + "value = 1" + "0" * 9000, "", ""),
    "range": (MOVE + "step = -1\n", ":9: [move] move_seed: step = -1", "a number in m, >= 0, default 1.0"),
    "fraction": (MOVE + "turn = 1.5\n", ":9: [move] move_seed: turn = 1.5", "a whole number"),
    "group": (
        SEED + "[seed.bent]\nstrenght = 1\n",
        ":7: [seed] make_seed: unknown setting 'bent.strenght'",
        "'strength'?",
    ),
    "no group": (SEED + "bent = 3\n", ":6: [seed] make_seed: bent = 3", "a group"),
    "file": (SEED + 'file = "no.bvh"\n', ":6: [seed]: file = 'no.bvh' does not exist", "relative to"),
    "folder": (SEED + 'file = "nodes"\n', ":6: [seed]: file = 'nodes' is a folder", "a file"),
    "escape": (SEED + 'file = "clips\\head.bvh"\n', "not valid TOML: Unescaped", "is an escape: write / or '...'"),
    "hex escape": (
        SEED + 'file = "C:\\Users\\a.bvh"\n',
        "not valid TOML: Invalid hex",
        "is an escape: write / or '...'",
    ),
    "tab": (SEED + 'file = "clips\\turn.bvh"\n', ":6: [seed]: file = 'clips\\turn.bvh' has a control", "is an escape"),
    "backslash": (SEED + "file = 'clips\\turn.bvh'\n", "does not exist: / separates folders", "'clips/turn.bvh'"),
    "drive": (SEED + "file = 'C:\\clips\\turn.bvh'\n", "is on a drive of Windows", "a path on this machine, with /"),
    "publish tab": (FULL.replace("out/list", "out\\tlist"), "has a control character", "is an escape"),
    "publish backslash": (FULL.replace('"out/list.txt"', "'out\\list.txt'"), "/ separates", "'out/list.txt'"),
    "NUL": (SEED + 'file = "a\\u0000b"\n', ":6: [seed]: file", "a file"),
    "in": (MOVE.replace("in.seed =", "in ="), "[move] move_seed: in = 'seed' is not a table", "in.body"),
    "socket": (MOVE.replace("in.seed", "in.sead"), ":8: [move] move_seed: no socket 'sead'", "'seed'?"),
    "socket by its type": (
        LIST.replace("in.numbers", "in.numeral"),
        "[list] write_list: no socket 'numeral'",
        "did you mean 'numbers'? sockets: numbers (Numeral)",
    ),
    "unconnected": (
        MOVE.replace('in.seed = "seed"', ""),
        "[move] move_seed: socket 'seed' is not connected, it takes Numeral",
        'in.seed = "seed", which gives Numeral',
    ),
    "output of one": (MOVE.replace('= "seed"', '= "seed.number"'), "'seed' has no output 'number'", "without a name"),
    "edge 3": (MOVE.replace('in.seed = "seed"', "in.seed = 3"), ":8: [move] move_seed: in.seed = 3", '"node"'),
    "no such node": (MOVE.replace('= "seed"', '= "sead"'), ":8: [move] move_seed: in.seed: no node 'sead'", "'seed'?"),
    "output": (LIST.replace('"sum"', '"sum.numbr"'), "no output 'numbr'", "'number'?"),
    "edge type": (
        LIST.replace('"sum"', '"sum.state"'),
        "in.numbers takes Numeral, 'sum' gives Sum",
        '"seed" or "move" or "sum", which gives Numeral',
    ),
    "once": (
        MOVE.replace('in.seed = "seed"', 'in.seed = "list"') + LIST[len(MOVE) :],
        "in.seed takes Numeral, 'list' gives File",
        "which gives Numeral",
    ),
    "itself": (MOVE.replace('= "seed"', '= "move"'), "a cycle: move -> move", "without a cycle"),
    "publish nothing": (SEED + 'publish = "a"\n', ":6: [seed] make_seed: make_seed has no file", "a File"),
    "publish mark": (FULL.replace("out/list", "out/####"), "does not fit write_list", "no ####"),
    "publish no mark": (FULL.replace("####.png", "a.png"), "does not fit draw_number", "####"),
    "publish folder": (FULL.replace("####.png", "####/a.png"), "frames go in one place", "####.png"),
    "publish 3": (FULL.replace('"out/list.txt"', "3"), "publish = 3 is not a path", ""),
    "publish dir": (FULL.replace("out/list.txt", "out/"), "is not a path", ""),
    "publish graph": (FULL.replace("out/list.txt", "bad.toml"), "is the graph file", "a path of its own"),
    "publish nodes": (FULL.replace("out/list.txt", "nodes/a.txt"), "in the folder of its node types", "a path of"),
    "publish twice": (
        FULL + '[two]\ntype = "write_list"\nin.numbers = "sum"\npublish = "./out/../out/list.txt"\n',
        "published by 'list' too",
        "a path of its own",
    ),
    "schema of digits": (SEED.replace("schema = 1", f"schema = {HEXADECIMAL}"), ":1: schema = (too long", "schema = 1"),
    "fps of digits": (SEED.replace("fps = 24", f"fps = {HEXADECIMAL}"), ":3: fps = (too long", "0.01 to"),
    "frames of digits": (SEED.replace("10]", f"{HEXADECIMAL}]"), ":2: frames = (too long", "first <= last"),
    "type of digits": (SEED.replace('"make_seed"', HEXADECIMAL), ":5: [seed]: type = (too long", ""),
    "type deep": (SEED.replace("type", "type" + ".a" * 3000), ":5: a key of more than 16 names", ""),
    "checkpoint": (SUM + "checkpoint = 0\n", ":12: [sum] add_up: checkpoint = 0", ">= 1"),
    "no scan": (SEED + "checkpoint = 3\n", ":6: [seed] make_seed: make_seed keeps no state", "a scan"),
}


def write(shot, data: bytes | str):
    path = shot.folder / "bad.toml"
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return path


@pytest.mark.parametrize("name", BAD)
def test_faults_are_reported_with_their_place(shot, name):
    text, reported, right = BAD[name]
    path = write(shot, text)
    with pytest.raises(BadInput) as caught:
        load_graph(path)
    message = str(caught.value)
    assert message.startswith(str(path)) and reported in message and right in message, message
    assert len(message) < len(str(path)) + 500


def test_publishing_a_frame_over_an_input_is_refused(shot):
    (shot.folder / "in").mkdir()
    (shot.folder / "in" / "0007.txt").write_text("mine")
    text = FULL.replace('"make_seed"', '"make_seed"\nfile = "in/0007.txt"').replace("####.png", "in/####.txt")
    with pytest.raises(BadInput, match=r"in/0007\.txt is an input of 'seed'"):
        load_graph(write(shot, text))


def test_publishing_over_a_folder_is_refused(shot):
    (shot.folder / "out" / "list.txt").mkdir(parents=True)
    with pytest.raises(BadInput, match=r"publish: .*out/list\.txt is a folder"):
        load_graph(write(shot, FULL))


def test_a_value_per_frame_does_not_go_into_one_for_the_shot(shot):
    (shot.nodes / "copy_seed.py").write_text(
        'from hairpipe.engine import node\nfrom numeral import Numeral\n@node(frames="once")\n'
        'def copy_seed(seed: Numeral) -> Numeral:\n    """Copy."""\n    return seed\n'
    )
    with pytest.raises(BadInput, match="'move' gives a value per frame"):
        load_graph(write(shot, MOVE + '[copy]\ntype = "copy_seed"\nin.seed = "move"\n'))


def test_a_value_of_a_derived_type_does_not_go_into_a_socket(shot):
    """What a consumer gets is built of exactly the fields of its own type: it would fail when it is run."""
    (shot.nodes / "count_seed.py").write_text(
        "from dataclasses import dataclass\nfrom hairpipe.engine import node\nfrom numeral import Numeral\n"
        "@dataclass(frozen=True)\nclass Counted(Numeral):\n    count: int\n"
        '@node(frames="once")\ndef count_seed() -> Counted:\n    """Count."""\n'
    )
    text = '[count]\ntype = "count_seed"\n' + MOVE[len(SEED) :].replace('= "seed"', '= "count"')
    with pytest.raises(BadInput, match=r"'count' gives Counted \(a node that gives Numeral: add_up, "):
        load_graph(write(shot, HEAD + text))


def test_binary_file_is_refused(shot):
    for data, reported in (
        (b"\xff\xfe\x00", ":1: not UTF-8"),
        (b"# \n\xe4", ":2: not UTF-8"),
        (b"#" * 2_000_000, "too many"),
    ):
        with pytest.raises(BadInput, match=reported):
            load_graph(write(shot, data))
    os.mkfifo(shot.folder / "pipe")
    for path in (shot.folder, shot.folder / "missing.toml", shot.folder / "pipe", shot.folder / ("x" * 300)):
        with pytest.raises(BadInput):
            load_graph(path)


def test_line_ends_and_byte_order_mark_do_not_matter(shot):
    graph = load_graph(write(shot, b"\xef\xbb\xbf" + FULL.replace("\n", "\r\n").encode()))
    assert list(graph.nodes) == ["seed", "move", "sum", "list", "draw"]


def test_overrides_are_typed_and_checked(shot):
    path = write(shot, FULL)
    graph = load_graph(path, {"seed.value": "4", "seed.bent.strength": "2"})
    assert graph.nodes["seed"].settings == {"value": 4.0, "file": None, "bent": {"strength": 2.0}}
    for target, value in (
        ("seed.value", "x"),
        ("seed.value", "5\nfoo = 7"),
        ("seed.value", "9" * 5000),
        ("sead.value", "1"),
        ("seed", "1"),
        ("seed.", "1"),
        ("seed.value.x", "1"),
    ):
        with pytest.raises(BadInput):
            load_graph(path, {target: value})


def test_whole_numbers_become_floats_before_they_are_keyed(shot):
    for text in ("3", "3.0"):
        assert type(load_graph(write(shot, SEED + f"value = {text}\n")).nodes["seed"].settings["value"]) is float


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.integers(0, len(FULL)),
    st.integers(0, 30),
    st.one_of(
        st.text(max_size=8),
        st.sampled_from(
            ["1e999", "[[[", '"""', "{}", "nan", "true", "-9e18", "[x]", "seed", '"sum"', "2020-01-01", "\0"]
        ),
    ),
)
def test_mutated_graphs_load_or_are_refused(shot, at, cut, text):
    with suppress(BadInput):
        load_graph(write(shot, (FULL[:at] + text + FULL[at + cut :]).encode("utf-8", "surrogatepass")))
