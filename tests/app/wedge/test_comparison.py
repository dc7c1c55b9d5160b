"""The table of a wedge, compared with the numbers that each variant gives by itself."""

import json

import numpy as np
import pytest

import hairpipe
from hairpipe.app.wedge import compare, document, markdown, text
from hairpipe.errors import BadInput

WEDGE = """
[weight]
type = "weigh"
in.number = "sum"
[wedge.steps]
axes.move.step = [1.0, 2.0]
axes.seed.value = [3, 4]
measures = ["weight"]
stop = [["weight.weight [kg]", ">", 35]]
"""


@pytest.fixture
def wedge(shot):
    shot.write_text(shot.read_text() + WEDGE)
    return hairpipe.load(shot).wedge("steps")


def test_before_a_run_the_comparison_is_empty(wedge):
    rows = compare(wedge)
    assert [row.state for row in rows] == ["0 of 26 results"] * 4
    assert all(not row.metrics and row.seconds == row.bytes == 0 for row in rows)
    assert "0 of 26 results" in text(rows)


def test_a_row_sums_a_variant_up(wedge):
    report = wedge.run(jobs=1)
    rows = compare(wedge)
    for row, variant in zip(rows, wedge.variants.values(), strict=True):
        alone = hairpipe.load(wedge.path).changed(variant.settings)
        last = int(row.state.split()[-1]) if row.state else 6
        truth = [alone.get(f"sum@{frame}").value for frame in range(1, last + 1)]
        assert row.metrics["mean weight [kg]"] == pytest.approx(np.mean(truth))
        assert row.metrics["largest weight [kg]"] == pytest.approx(max(truth))
        assert (max(truth) > 35) == bool(row.state) == (row.variant in report.stopped)
        assert row.state in ("", f"stopped: {report.stopped.get(row.variant)}")
    assert [row.settings for row in rows][1] == {"step": 1.0, "value": 4}


def test_seconds_and_bytes_exclude_shared_results(wedge, shot):
    one = shot.with_name("one.toml")
    one.write_text(shot.read_text().replace("axes.seed.value = [3, 4]", ""))
    wedge = hairpipe.load(one).wedge("steps")
    wedge.run(jobs=1)
    records = wedge.results()
    for row, variant in zip(compare(wedge), wedge.variants.values(), strict=True):
        last = int(row.state.rpartition(" ")[2]) if row.state.startswith("stopped") else 6
        own = {
            target: record
            for target, record in records.items()
            if target.partition("@")[0] in variant.names.values()
            and "[" in target
            and int(target.partition("@")[2] or 0) <= last  # others may have been computed before it was stopped
        }
        assert "seed" not in own and any(target.startswith("move[") for target in own)
        objects = {name: size for record in own.values() for name, size in record.objects()}
        states = {name for r in own.values() for name, _ in set(r.objects()) - set(r.objects(without=r.state))}
        there = {name for name in objects if wedge._store.object_path(name).exists()}
        assert objects.keys() - there <= states  # Those of a simulation that are not kept.
        assert row.bytes == sum(objects[name] for name in there)
        assert 0.0 < row.seconds <= sum(record.seconds for record in own.values()) * 1.5


def test_it_is_written_for_people_for_markdown_and_for_programs(wedge):
    wedge.run(jobs=1)
    rows = compare(wedge)
    lines = text(rows).splitlines()
    assert lines[1].split()[:2] == ["weight", "weight"] and lines[2].split()[:4] == ["step", "value", "[kg]", "[kg]"]
    head, rule, *body = markdown(rows).splitlines()
    assert head.startswith("| step | value | mean weight [kg] | largest weight [kg] | seconds | size |")
    assert len(body) == 4 and {line.count("|") for line in (head, rule, *body)} == {head.count("|")}
    found = json.loads(json.dumps(document(wedge, rows), allow_nan=False))
    assert found["wedge"] == "steps" and found["variants"][0]["variant"] == "step=1,value=3"


def test_a_measure_must_be_a_table(wedge, shot):
    shot.write_text(shot.read_text().replace('measures = ["weight"]', 'measures = ["sum"]'))
    wedge = hairpipe.load(shot).wedge("steps")
    wedge.run(jobs=1)
    with pytest.raises(BadInput, match="is not a table"):
        compare(wedge)
