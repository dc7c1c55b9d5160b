"""A host refuses what its machine has not got, names it, and looks in the store before it evaluates."""

import errno
import json
import os
import shutil
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from hairpipe.engine.code import CodeReader
from hairpipe.engine.file.trust import _granted
from hairpipe.engine.hosts import offer as offering
from hairpipe.engine.hosts.host import Host, Job, LocalEngine
from hairpipe.engine.hosts.offer import Offer, accept, sent_offer
from hairpipe.engine.plan.key import Resolver
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.store.digest import action_key
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput


@pytest.fixture
def sent(shot) -> Offer:
    """The offer of a shot."""
    shot.store.root.mkdir()
    modules = tuple(path.stem for path in shot.nodes.glob("*.py"))
    yield sent_offer(shot.store, shot.nodes, modules)
    _granted.clear()


def job_of(shot, name="seed", **settings) -> Job:
    """Make the job of a value for the shot that needs no other."""
    graph = shot.load(**settings)
    resolver = Resolver(graph, shot.store, graph.select(None))
    task = Task(name, None)
    parts = resolver.parts(task)
    node = graph.nodes[name]
    outputs = tuple(node.type.outputs)
    files = resolver.files[name]
    given = graph.settings(node)
    time = resolver.time_of(task)
    kind = node.type
    return Job(action_key(parts), name, None, kind.name, kind.module, parts, given, time, files, outputs, None, True)


def host_for(offer: Offer) -> Host:
    """Make a host as on another machine: it knows nothing but the offer."""
    reader = CodeReader(Store(Path(offer.store), read_only=True).remember, Path(offer.folder))
    return Host(offer, "other", 1, reader)


def evaluated(host: Host, job: Job):
    """Give a job to a host and wait for the reply; both go through JSON."""
    engine = LocalEngine(host)
    fields = json.loads(json.dumps(asdict(job)))
    engine.submit(Job(**fields | {"outputs": tuple(fields["outputs"])}))
    (reply,) = engine.replies(60.0)
    return json.loads(json.dumps(reply))


def test_a_job_gives_what_a_run_gives_and_is_found_the_second_time(shot, sent):
    accept(sent, "other")
    host = host_for(sent)
    job = job_of(shot)
    reply = evaluated(host, job)
    assert reply["key"] == job.key and reply["machine"] == "other" and "found" not in reply
    assert evaluated(host, job)["found"]
    host.close()
    assert shot.tally() == {"make_seed": 1}
    other = Store(shot.folder / "undisturbed")
    shot.run(store=other, to=["seed"])
    assert other.find(job.key).outputs == shot.store.find(job.key).outputs
    assert shot.run().exit_code == 0 and shot.tally()["make_seed"] == 1, "that of the undisturbed run alone"


def test_code_runs_where_it_is_trusted_here_or_there(shot, sent, monkeypatch):
    job = job_of(shot)
    monkeypatch.delenv("HAIRPIPE_TRUST")
    host = host_for(replace(sent, trusted=None))
    assert "not trusted" in evaluated(host, job)["failure"]["message"] and not shot.tally()
    host.close()
    accept(sent, "other")
    host = host_for(sent)
    assert "record" in evaluated(host, job)
    host.close()


@pytest.mark.parametrize("name", ["make_seed.py", "tally.py"])
def test_other_code_of_a_node_is_refused_by_name(shot, sent, name):
    """Were it evaluated, the wrong result would be stored under the key of the right one for ever."""
    job = job_of(shot)
    text = (shot.nodes / name).read_text()
    (shot.nodes / name).write_text(text + "\nOTHER = 1\n")
    with pytest.raises(BadInput, match=rf"^other has other code in .*nodes: {name} \(copy the folder there\)$"):
        accept(sent, "other")
    host = host_for(sent)
    failure = evaluated(host, job)["failure"]
    host.close()
    reported = f"other has other code of 'make_seed': {Path(name).stem} (install the same versions there, and retry)"
    assert (failure["kind"], failure["message"]) == ("mismatch", reported)
    assert not shot.tally() and shot.store.find(job.key) is None


@pytest.mark.parametrize(
    ("function", "value", "message"),
    [("version", "99.0", "numba 99.0 in place of 0."), ("processor_class", "z80", "processor z80 in place of ")],
)
def test_other_versions_and_classes_of_processor_are_named_with_both(shot, sent, monkeypatch, function, value, message):
    job = job_of(shot)
    monkeypatch.setattr(f"hairpipe.engine.code.{function}", lambda *name: value)
    failure = evaluated(host_for(sent), job)["failure"]
    assert failure["kind"] == "mismatch" and message in failure["message"]
    monkeypatch.setattr(offering, "VERSIONS", "hairpipe 99, Python 3.11")
    with pytest.raises(BadInput, match=r"other has hairpipe 99, Python 3.11 .install hairpipe "):
        accept(sent, "other")


def test_other_versions_of_what_a_choice_calls_are_named(shot, sent):
    job = job_of(shot)
    keyed = {"group": {"engine": {"choice": "fast", "versions": {"numpy": "0.1"}}}}
    host = host_for(sent)
    failure = evaluated(host, replace(job, parts=job.parts | {"settings": job.parts["settings"] | keyed}))["failure"]
    host.close()
    here = np.__version__
    assert failure["message"].startswith(f"other has other code of 'make_seed': numpy {here} in place of 0.1 (install")


def test_another_store_at_the_same_path_is_refused(shot, sent):
    accept(sent, "other")
    shutil.rmtree(shot.store.root)
    for _ in range(2):
        with pytest.raises(BadInput, match=r"other has another store, or none, at .* .mount the same folder"):
            accept(sent, "other")
        shot.store.root.mkdir(exist_ok=True)
        (shot.store.root / "id").write_text("0" * 32)


def test_an_input_file_with_other_bytes_is_refused(shot, sent):
    file = shot.folder / "clip.txt"
    file.write_text("four")
    shot.write(shot.path.read_text().replace("value = 3", 'file = "clip.txt"'))
    job = job_of(shot)
    file.write_text("more than four")
    failure = evaluated(host_for(sent), job)["failure"]
    assert (failure["kind"], failure["message"].startswith(str(file))) == ("mismatch", True)
    file.unlink()
    assert "cannot be read on other" in evaluated(host_for(sent), job)["failure"]["message"]
    file.write_text("four")
    host = host_for(sent)
    assert "record" in evaluated(host, job)
    host.close()


def test_tasks_of_other_processes_are_not_evaluated(shot, sent):
    job = job_of(shot)
    leases = Leases(shot.store)
    host = host_for(sent)
    assert leases.acquire(job.key)
    assert evaluated(host, job)["leased"]
    leases.release(job.key)
    assert "record" in evaluated(host, job)
    host.close()


@pytest.fixture
def remembering(monkeypatch):
    """Be a client of NFS: a record that was missing stays missing until its folder is opened."""
    stat, opened, missing = Path.stat, os.open, set()

    def look(path, **words):
        if path in missing:
            raise FileNotFoundError(errno.ENOENT, "missing when last looked up", str(path))
        try:
            return stat(path, **words)
        except FileNotFoundError:
            missing.update([path] if path.parent.parent.name == "actions" else [])
            raise

    def refresh(path, *words, **named):
        missing.difference_update([name for name in missing if str(name.parent) == str(path)])
        return opened(path, *words, **named)

    monkeypatch.setattr(Path, "stat", look)
    monkeypatch.setattr(os, "open", refresh)


def test_a_result_is_found_though_it_was_missing_a_moment_ago(shot, sent, remembering):
    other = Store(shot.folder / "other")
    shot.run(store=other, to=["seed"])
    job = job_of(shot)
    host = host_for(sent)
    assert host.store.find(job.key) is None
    shutil.copytree(other.root, shot.store.root, dirs_exist_ok=True)
    assert host.store.find(job.key) is None, "remembered as missing"
    assert evaluated(host, job)["found"]
    host.close()
    assert shot.tally() == {"make_seed": 1}


def test_two_scans_run_side_by_side_and_give_what_one_machine_gives(shot, machines):
    shot.add('[moved]\nlike = "move"\nstep = 2.0\n[other]\nlike = "sum"\nin.number = "moved"\n')
    undisturbed = Store(shot.folder / "undisturbed")
    shot.run(store=undisturbed)
    counts = shot.tally()
    shot.run(to=["move", "moved"])  # so that both scans are ready at once
    made = machines()
    widest = 0

    def watch(event):
        nonlocal widest
        widest = max(widest, sum(m.wide for e in made[-1].engines.values() for m in e.host.busy) if made else 0)

    assert shot.run(report=watch).exit_code == 0
    assert widest == 2 and len(made[-1].given) == 2
    assert shot.tally() == counts and shot.results() == shot.results(store=undisturbed)


def test_a_killed_worker_is_replaced_once_on_another_machine(shot, machines):
    """Killed at its first attempt: the other machine evaluates it. Killed at each: a failure."""
    shot.add('[wrong]\ntype = "go_wrong"\nin.number = "move"\nhow = "kill"\n')
    machines()
    outcome = shot.run(keep_going=True)
    assert [(failure.kind, failure.task.frame) for failure in outcome.failures] == [("crash", 3)]
    assert shot.tally()["go_wrong"] == 11
    first = """if how == "kill" and open(os.environ["TOY_TALLY"]).read().count("go_wrong 3") == 1:"""
    shot.edit("go_wrong.py", 'if how == "kill":', first)
    assert shot.run().exit_code == 0
    assert shot.tally()["go_wrong"] == 11
    ((_, message),) = shot.warned
    assert message.startswith("the worker process was ended by SIGKILL") and message.endswith("other machines go on")


def test_a_machine_with_other_code_is_omitted_with_one_warning(shot, machines):
    made = machines(refuse=["a"])
    assert shot.run().exit_code == 0
    ((_, message),) = shot.warned
    assert message.startswith("a has other code of 'make_seed'") and message.endswith("other machines go on")
    assert made[-1].machines == {"b"} and shot.tally()["add_up"] == 10


def test_a_run_fails_where_no_machine_has_its_code(shot, machines):
    machines(refuse=["a", "b"])
    (failure,) = shot.run().failures
    assert failure.kind == "mismatch" and "has other code of 'make_seed'" in failure.message
    assert not shot.tally()
