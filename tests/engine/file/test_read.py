"""Places in a graph file: found for messages, and cheaply, since most are never shown."""

import time
import tracemalloc
from contextlib import suppress

import pytest

from hairpipe.engine.file import read
from hairpipe.engine.file.graph import Graph
from hairpipe.engine.file.read import GraphText
from hairpipe.engine.plan.tasks import unroll
from hairpipe.errors import BadInput

TEXT = """schema = 1
frames = [1, 2]  # schema
[a]
type = "make_seed"
[b.in]
seed = "a"
[b]
"value" = 3
"""


@pytest.mark.parametrize(
    ("node", "names", "line"),
    [(None, ["frames"], 2), (None, ["fps"], None), ("a", ["type"], 4), ("b", ["in", "seed"], 6), ("b", ["x"], 5)],
)
def test_a_place_is_the_line_where_it_stands(tmp_path, node, names, line):
    label = f": [{node}]" if node else ""
    at = f":{line}" if line else ""
    assert GraphText(tmp_path, TEXT).place(node, names) == f"{tmp_path}{at}{label}"


@pytest.mark.parametrize("nodes", [30, 3000])
def test_places_of_all_nodes_cost_in_proportion_to_the_lines(tmp_path, monkeypatch, nodes):
    """Each line is matched once to find whose it is, and those of a node alone are searched for a name."""
    header, matched = read.HEADER, []

    class Counting:
        def match(self, line):
            matched.append(line)
            return header.match(line)

    monkeypatch.setattr(read, "HEADER", Counting())
    text = GraphText(tmp_path, "schema = 1\n" + "".join(f'[n{n}]\ntype = "make_seed"\n' for n in range(nodes)))
    places = [text.place(f"n{n}", ["type"]) for n in range(nodes)]
    assert places[-1] == f"{tmp_path}:{2 * nodes + 1}: [n{nodes - 1}]" and len(matched) == 2 * nodes + 1
    assert sum(len(text._owned[f"n{n}"]) for n in range(nodes)) == 2 * nodes


@pytest.mark.parametrize("frames", [20, 2000])
def test_unrolling_costs_in_proportion_to_the_tasks(shot, monkeypatch, frames):
    """Tasks are made about as often as they are there, and none is compared with all."""
    shot.write(shot.path.read_text().replace("[1, 10]", f"[1, {frames}]"))
    graph = shot.load()
    from hairpipe.engine.plan import tasks

    made = []
    real = tasks.Task
    monkeypatch.setattr(tasks, "Task", lambda *given: made.append(given) or real(*given))
    assert isinstance(graph, Graph) and len(unroll(graph, graph.select(None))) == 2 * frames + 2
    assert len(made) < 12 * frames


def test_the_code_of_a_type_is_read_once_however_many_nodes_have_it(shot, monkeypatch):
    from hairpipe.engine.code import CodeReader

    nodes = "".join(f'[n{n}]\ntype = "make_seed"\n' for n in range(50))
    shot.write(f"schema = 1\nframes = [1, 2]\nfps = 24\n{nodes}")
    read, code_of = [], CodeReader.code_of
    monkeypatch.setattr(CodeReader, "code_of", lambda self, module: read.append(module) or code_of(self, module))
    assert len(shot.plan()) == 50 and read == ["make_seed"]


@pytest.mark.parametrize("key", ["a{}", "a . {}", '"a"{}', "['a'{}]", "a = {{ b{} = 1 }}", 'x = "y"\na{}'])
def test_a_key_of_many_names_is_refused_before_it_is_read(tmp_path, key):
    """Python's reader takes 1.6 GB for 20,000 names."""
    text = key.replace("{}", ".b" * 20_000)
    tracemalloc.start()
    with pytest.raises(BadInput, match=r"shot.toml:[12]: a key of more than 16 names"):
        GraphText(tmp_path / "shot.toml", text)
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()


@pytest.mark.parametrize("text", ["a" * 900_000, "a." * 15 + "b = 1", f"a = [{'1.5, ' * 100_000}]", '"' * 300_000])
def test_other_long_texts_are_read_in_proportion(tmp_path, text):
    """A search that begins anew at each letter would take minutes."""
    begun = time.process_time()
    with suppress(BadInput):
        GraphText(tmp_path / "shot.toml", text)
    assert time.process_time() - begun < 10.0
