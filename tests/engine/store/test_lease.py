"""Leases of keys: exactly one holder, whatever stops, and whatever the order of system calls."""

import os
import random
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from hairpipe.engine.store import holder as renewal
from hairpipe.engine.store import lease
from hairpipe.engine.store.lease import EMPTY, EXPIRY, Leases, read_lease
from hairpipe.engine.store.store import Store
from tests.sources import HOME

ONE, OTHER = "0123456789abcdef0123" * 2, "fedcba9876543210fedc" * 2
HOLD = """
import sys
from pathlib import Path
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.store import Store
leases = Leases(Store(Path(sys.argv[1])))
print(leases.acquire(sys.argv[2]), flush=True)
sys.stdin.read()
leases.close()
"""
LEFT = """
import os, sys
from pathlib import Path
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.store import Store
leases = Leases(Store(Path(sys.argv[1])))
leases.acquire(sys.argv[2])
os.rename(leases._folder / sys.argv[2], leases._folder / sys.argv[3])
os._exit(0)
"""


class Clock:
    """The clock of a watcher."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "store")


@pytest.fixture
def clock():
    return Clock()


def files_of(store):
    return sorted(path.name for path in (store.root / "lease").glob("*"))


def hold(store, key):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, store.root, key], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    return process, process.stdout.readline().strip() == "True"


def test_a_key_is_held_by_one_process_until_it_ends(store):
    process, held = hold(store, ONE)
    leases = Leases(store)
    assert held and not leases.acquire(ONE) and leases.acquire(OTHER)
    process.kill()
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
    assert leases.acquire(ONE), "a process of this machine that was killed is known to have ended, collected or not"
    process.communicate()
    assert not leases.acquire(ONE), "not twice by the same process"
    second, held = hold(store, OTHER)
    second.communicate()
    assert not held
    leases.close()
    third, held = hold(store, OTHER)
    third.communicate()
    assert held and files_of(store) == []


def test_leases_of_some_keys_are_found_by_one_look_at_the_folder(store):
    """As the lease of a key is found by itself; keys that nobody has leased have none."""
    leases = Leases(store)
    assert leases.holders([ONE]) == {}
    assert leases.acquire(ONE)
    assert list(leases.holders([ONE, OTHER])) == [ONE] and leases.holders([OTHER]) == {}
    assert leases.holders([ONE])[ONE] == leases.holder(ONE)


def test_leases_of_ended_processes_are_given_back_and_those_of_others_stay(store):
    held = Leases(store)
    assert held.acquire(ONE)
    process, taken = hold(store, OTHER)
    Leases(store).sweep()
    assert taken and files_of(store) == [ONE, OTHER]
    process.kill()
    process.communicate()
    Leases(store).sweep()
    assert files_of(store) == [ONE]


def test_no_lock_of_the_file_system_is_used():
    """Many network file systems grant one to each machine, and machines share a store.

    A graph file that is saved, and a kernel that is compiled, are locked in a folder of their user, against other
    processes of this user: no store depends on it.
    """
    apart = {"edit.py", "worker/machine_code.py"}
    graph = HOME / "hairpipe/engine"
    sources = [path for path in graph.rglob("*.py") if str(path.relative_to(graph)) not in apart]
    assert len(sources) > 30
    assert not [path for path in sources if "fcntl" in path.read_text() or "flock" in path.read_text()]


def test_a_holder_elsewhere_expires_by_the_clock_of_the_watcher(store, clock, monkeypatch):
    """Neither the age of its file nor the clock of its machine counts, only that nothing changes."""
    with monkeypatch.context() as elsewhere:
        elsewhere.setattr("hairpipe.engine.store.holder.machine", lambda: "0123456789ab")
        assert Leases(store).acquire(ONE)
    path = store.root / "lease" / ONE
    watcher = Leases(store, clock)
    for hours in (0, -5, 3, -4):
        os.utime(path, (1e9 + hours * 3600,) * 2)  # it is renewed by a machine whose clock is off
        assert not watcher.acquire(ONE)
        clock.now += EXPIRY - 1
        assert not watcher.acquire(ONE)
    clock.now += 1
    assert watcher.acquire(ONE)


def test_holder_is_the_last_of_those_that_took_over_and_nothing_is_written(store, clock):
    watcher = Leases(Store(store.root, read_only=True), clock)
    assert watcher.holder(ONE) is None and not store.root.exists()
    slow = Leases(store)
    slow.acquire(ONE)
    taker = Leases(store, clock)
    assert watcher.holder(ONE).path.name == ONE and not taker.acquire(ONE)
    clock.now += EXPIRY
    assert watcher.holder(ONE) is None, "its stamp has not changed"
    assert taker.acquire(ONE)
    before = files_of(store)
    assert len(before) == 2 and watcher.holder(ONE).path.name == before[1]
    assert files_of(store) == before
    taker.release(ONE)
    assert watcher.holder(ONE) is None


def test_a_lease_is_renewed_while_it_is_held(store):
    leases = Leases(store)
    leases.acquire(ONE)
    path = store.root / "lease" / ONE
    os.utime(path, (0, 0))
    renewal.renewal.renew()
    assert read_lease(path).stamp > 0
    assert "renewal" in [thread.name for thread in threading.enumerate()]
    leases.release(ONE)
    path.write_text("")
    os.utime(path, (0, 0))
    renewal.renewal.renew()
    assert path.stat().st_mtime == 0, "what was given back is left alone"


def test_a_slow_holder_leaves_the_lease_to_the_one_that_took_over(store, clock):
    slow = Leases(store)
    slow.acquire(ONE)
    taker = Leases(store, clock)
    assert not taker.acquire(ONE)
    clock.now += EXPIRY
    assert taker.acquire(ONE)
    slow.release(ONE)
    assert not Leases(store).acquire(ONE), "that of the taker stands"
    taker.release(ONE)
    assert files_of(store) == []


def put_future(path):
    path.write_text("no lease")
    os.utime(path, (4e9, 4e9))


DAMAGE = {
    "folder": lambda path: (path / "within").mkdir(parents=True),
    "pipe": os.mkfifo,
    "a stamp of the future": put_future,
    "link to nothing": lambda path: path.symlink_to("nowhere"),
    "link to itself": lambda path: path.symlink_to(ONE),
    "link to a lease": lambda path: path.symlink_to(OTHER),
    "bytes": lambda path: path.write_bytes(b"\xff\x00garbage"),
    "zeros": lambda path: path.write_bytes(bytes(64)),
    "a list": lambda path: path.write_bytes(b"[1, 2]"),
    "a name of a wrong type": lambda path: path.write_bytes(b'{"holder": 7, "host": "a"}'),
    "half a lease": lambda path: path.write_bytes(b'{"holder": "0123456789ab-1-1-0123'),
}


@pytest.mark.parametrize("put", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_lease_is_taken_over_at_once(store, put, clock):
    """By exactly one of several, who all see it."""
    assert Leases(store).acquire(OTHER)
    put(store.root / "lease" / ONE)
    contenders = [Leases(store, clock) for _ in range(3)]
    assert contenders[0].holder(ONE) is None
    assert [leases.acquire(ONE) for leases in contenders] == [True, False, False]
    contenders[0].close()
    assert files_of(store) == [OTHER]
    put(store.root / "lease" / ONE)
    assert Leases(store).sweep() == [store.root / "lease" / ONE] and files_of(store) == [OTHER]


def test_a_lease_without_bytes_may_be_in_the_making_and_expires_soon(store, clock):
    (store.root / "lease").mkdir(parents=True)
    (store.root / "lease" / ONE).touch()
    leases = Leases(store, clock)
    assert leases.sweep() == [] and not leases.acquire(ONE)
    clock.now += EMPTY
    assert EMPTY < EXPIRY / 10 and leases.acquire(ONE)


def test_files_of_others_in_the_folder_of_leases_stay(store):
    (store.root / "lease").mkdir(parents=True)
    (store.root / "lease" / "README").write_text("of somebody")
    assert Leases(store).sweep() == [] and files_of(store) == ["README"]


def test_a_store_that_may_not_be_written_to_is_an_error_and_nothing_to_wait_for(store, monkeypatch):
    def refuse(*arguments):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(PermissionError):
        Leases(store).acquire(ONE)


class Stopped(BaseException):
    """A process that ends between two system calls."""


class Calls:
    """System calls of leases: `before` is called before each."""

    def __init__(self, monkeypatch, before):
        self.before = before
        for name in ("open", "write", "close", "fchmod"):
            monkeypatch.setattr(os, name, self._guarded(getattr(os, name)))
        monkeypatch.setattr(Path, "unlink", self._guarded(Path.unlink))
        monkeypatch.setattr(lease, "read_lease", self._guarded(lease.read_lease))
        monkeypatch.setattr(lease, "is_at", self._guarded(lease.is_at))

    def _guarded(self, function):
        def call(*given, **named):
            self.before()
            return function(*given, **named)

        return call


@pytest.mark.parametrize("taken", [False, True], ids=["free", "expired"])
def test_whoever_stops_between_two_calls_is_followed_by_exactly_one(tmp_path, taken, monkeypatch, clock):
    """At every call of acquiring, taking over and giving back, until nothing is left to stop at."""
    left = None

    def stop():
        nonlocal left
        if left is not None:
            left -= 1
            if left < 0:
                raise Stopped

    with monkeypatch.context() as patch:
        Calls(patch, stop)
        for number in range(100):
            store = Store(tmp_path / str(number))
            if taken:
                Leases(store).acquire(ONE)
            stopped = Leases(store, clock)
            stopped.acquire(ONE)  # sees it for the first time
            stopped.release(ONE)
            clock.now += EXPIRY
            left = number
            try:
                stopped.acquire(ONE)
                stopped.release(ONE)
            except Stopped:
                pass
            ended = left >= 0
            left = None
            watchers = [Leases(store, clock) for _ in range(3)]
            got = []
            for _ in range(4):  # as long a chain as there may be
                got += [watcher.acquire(ONE) for watcher in watchers]
                clock.now += 0 if any(got) else EXPIRY
            assert sum(got) == 1
            for watcher in watchers:
                watcher.close()
            assert Leases(store).acquire(ONE)
            if ended:
                break
    assert ended and number > 5


SEEDS = 120


class Turns:
    """Threads of which one runs at a time, from one system call to the next, in an order drawn at random."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.changed = threading.Condition()
        self.waiting = {}
        self.alive = set()
        self.stopped = set()

    def pause(self):
        """Wait for a turn; some stop for ever."""
        me = threading.current_thread().name
        if me not in self.alive:
            return
        gate = threading.Event()
        with self.changed:
            self.waiting[me] = gate
            self.changed.notify_all()
        gate.wait()
        if me in self.stopped:
            raise Stopped

    def run(self, programs):
        def serve(name, program):
            try:
                self.pause()
                program()
            except Stopped:
                pass
            finally:
                with self.changed:
                    self.alive.discard(name)
                    self.changed.notify_all()

        self.alive = set(programs)
        threads = [threading.Thread(target=serve, args=item, name=item[0]) for item in programs.items()]
        for thread in threads:
            thread.start()
        while True:
            with self.changed:
                self.changed.wait_for(lambda: self.alive <= self.waiting.keys())
                if not self.alive:
                    break
                name = self.random.choice(sorted(self.alive))
                if name != "slow" and self.random.random() < 0.005:
                    self.stopped.add(name)
                self.waiting.pop(name).set()
        for thread in threads:
            thread.join()


def test_in_any_order_of_system_calls_one_contender_holds(tmp_path, monkeypatch):
    """Three that take over from a holder that is slow and gives back meanwhile; some stop for ever."""
    taken = 0
    for seed in range(SEEDS):
        with monkeypatch.context() as patch:
            taken += contend(Store(tmp_path / str(seed)), seed, patch)
    assert taken > SEEDS


def contend(store, seed, patch):
    turns = Turns(seed)
    makers = {}
    inside = []
    make = lease.make_name

    def make_name():
        name = make()
        makers[name] = threading.current_thread().name
        return name

    patch.setattr(lease, "make_name", make_name)
    patch.setattr(lease, "has_ended", lambda name: makers.get(name) in {"MainThread", *turns.stopped})
    slow = Leases(store, lambda: 0.0)
    assert slow.acquire(ONE)
    Calls(patch, turns.pause)
    taken = 0

    def contender():
        nonlocal taken
        me = threading.current_thread().name
        leases = Leases(store, lambda: 0.0)
        for _ in range(8):
            if leases.acquire(ONE):
                assert set(inside) <= turns.stopped, f"{inside} and {me} with seed {seed}"
                inside.append(me)
                taken += 1
                for _ in range(turns.random.randrange(20)):
                    turns.pause()
                inside.remove(me)  # of a stopped one it stays
                leases.release(ONE)
            turns.pause()

    def give_back_late():
        for _ in range(turns.random.randrange(100)):
            turns.pause()
        slow.release(ONE)

    faults = []
    patch.setattr(threading, "excepthook", lambda given: faults.append(given.exc_value))
    turns.run({"a": contender, "b": contender, "c": contender, "slow": give_back_late})
    assert not faults, faults
    patch.setattr(lease, "has_ended", lambda name: True)
    after = Leases(store, lambda: 0.0)
    after.acquire(ONE)
    late = Leases(store, lambda: EXPIRY)
    assert ONE in after._held or late.acquire(ONE), files_of(store)
    return taken


def test_a_failure_is_noted_until_it_is_forgotten(store):
    lease.note_failure(store, ONE, "too long")
    assert lease.recall_failure(store, ONE).message == "too long" and lease.recall_failure(store, OTHER) is None
    lease.forget_failure(store, ONE)
    assert lease.recall_failure(store, ONE) is None


def test_files_of_a_holder_that_ended_go_with_its_lease(store):
    """It ended between two removals: its own file is there, the lease that it followed is not."""
    alone = f"{ONE[: lease.KEY]}.{'0' * 8}"
    holder = subprocess.run([sys.executable, "-c", LEFT, str(store.root), ONE, alone], capture_output=True, text=True)
    assert holder.returncode == 0, holder.stderr
    folder = Leases(store)._folder
    assert (folder / alone).exists()
    Leases(store).sweep()
    assert not (folder / alone).exists()
