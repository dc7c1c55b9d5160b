"""Runs on a Dask cluster: a scheduler and two workers on loopback, each with a home of its own."""

import os
import signal
from threading import Thread

import pytest

from hairpipe.engine.hosts import dask_engine
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput

from ..cluster import Cluster
from ..conftest import wait_for

distributed = pytest.importorskip("distributed", reason="distributed is not installed (the extra `dask`)")
pytestmark = pytest.mark.slow


@pytest.fixture
def cluster(tmp_path, shot):
    """A cluster that sees the folder of the shot."""
    (tmp_path / "cluster").mkdir()
    made = Cluster(tmp_path / "cluster")
    yield made
    made.close()


def run_on(cluster, shot, said=None):
    """Run a shot on a cluster; its warnings are added to a list."""
    set_up, said = Options(scheduler=cluster.address, insecure=True), [] if said is None else said
    report = lambda event: said.append(event.message) if event.kind == "warning" else None  # noqa: E731
    return run(shot.load(), shot.store, None, set_up, report)


TWO = '[moved]\nlike = "move"\nstep = 2.0\n[other]\nlike = "sum"\nin.number = "moved"\n'


def test_a_cluster_gives_what_one_machine_gives(shot, cluster):
    """Equal objects and counts; both machines evaluate; the folder is trusted by the user of the coordinator alone."""
    shot.add(TWO)
    whole = Store(shot.folder / "whole")
    shot.run(store=whole)
    expected, text = shot.tally(), (shot.folder / "out" / "list.txt").read_bytes()
    (shot.folder / "out" / "list.txt").unlink()
    outcome = run_on(cluster, shot)
    assert (outcome.exit_code, outcome.failures) == (0, ())
    assert shot.tally() == expected and shot.results() == shot.results(store=whole)
    assert (shot.folder / "out" / "list.txt").read_bytes() == text
    cluster.close()
    assert run_on(cluster, shot).cached == outcome.evaluated, "a warm run does not connect"


PAUSE = """
def pause(line):
    path = Path(os.environ["TOY_TALLY"] + ".paused")
    if line == "add_up 4" and not path.exists():
        path.with_suffix(".new").write_text(str(os.getppid()))
        path.with_suffix(".new").rename(path)
        __import__("time").sleep(60)


def numeral(value)"""


def test_a_scan_continues_elsewhere_when_its_machine_is_killed(shot, undisturbed, cluster):
    """The machine of the scan is killed within frame 4: the states before were only in its memory."""
    shot.edit("tally.py", "\ndef numeral(value)", PAUSE)
    shot.edit("tally.py", '.strip() + "\\n")', '.strip() + "\\n")\n    pause(f"{name} {frame}")')
    paused = shot.folder / "tally.paused"

    def kill():
        wait_for(paused.exists)
        os.kill(int(paused.read_text()), signal.SIGKILL)

    thread = Thread(target=kill, daemon=True)
    thread.start()
    outcome = run_on(cluster, shot, said := [])
    thread.join()
    assert outcome.exit_code == 0, (outcome.failures, said)
    assert said and all("other machines go on" in message for message in said)
    assert shot.tally()["add_up"] == 4 + 10 and shot.results() == undisturbed["results"]


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_lost_scheduler_ends_the_run_with_one_line(shot, cluster, monkeypatch, capfd, number):
    """Killed, or stopped with its connections open; Dask itself writes nothing."""
    monkeypatch.setattr(dask_engine, "SILENCE", 6.0)
    text = shot.path.read_text()
    shot.path.write_text(text + '[wrong]\ntype = "go_wrong"\nin.number = "move"\nhow = "slow"\n')

    def stop():
        wait_for(lambda: shot.has_called("go_wrong 3"))
        cluster.processes["scheduler"].send_signal(number)

    thread = Thread(target=stop, daemon=True)
    thread.start()
    outcome = run_on(cluster, shot)
    thread.join()
    assert outcome.exit_code == 1
    messages = {failure.message for failure in outcome.failures}
    assert messages == {f"the Dask scheduler {cluster.address} is lost: run again"}
    assert capfd.readouterr().err == ""


def test_other_code_on_the_cluster_is_refused_by_name(shot, cluster, monkeypatch):
    """The coordinator has a file that neither worker has: none evaluates anything."""
    sent = dask_engine.DaskEngine._connect

    def connect(engine):
        client = sent(engine)
        engine._offer = engine._offer.replace('"trusted": {"', '"trusted": {"other.py": "0", "')
        return client

    monkeypatch.setattr(dask_engine.DaskEngine, "_connect", connect)
    outcome = run_on(cluster, shot, said := [])
    assert not shot.tally()
    (failure,) = outcome.failures
    assert failure.kind == "mismatch" and "has other code in" in failure.message and "other.py" in failure.message
    assert len(said) == 1 and outcome.exit_code == 2


def test_a_silent_machine_is_given_up(shot, cluster, monkeypatch):
    """A stopped process answers nothing, though its connection stays open."""
    monkeypatch.setattr(dask_engine, "SILENCE", 6.0)
    cluster.processes["one"].send_signal(signal.SIGSTOP)
    outcome = run_on(cluster, shot)
    assert (outcome.exit_code, outcome.failures) == (0, ())
    assert shot.tally()["add_up"] == 10


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scheduler": "tcp://127.0.0.1:1"}, "whoever reaches this port can run code as you"),
        ({"scheduler": "tls://127.0.0.1:1"}, "needs a certificate"),
        ({"scheduler": "tcp://127.0.0.1:1", "insecure": True}, "no Dask scheduler answers"),
    ],
)
def test_a_scheduler_without_a_word_a_certificate_or_an_answer_is_one_message(shot, monkeypatch, options, message):
    monkeypatch.setattr(dask_engine, "CONNECT", 1.0)
    dask = pytest.importorskip("dask")
    absent = {f"distributed.comm.tls.{name}": None for name in ("ca-file", "client.cert", "client.key")}
    with dask.config.set(absent), pytest.raises(BadInput, match=message):
        run(shot.load(), shot.store, None, Options(**options))
