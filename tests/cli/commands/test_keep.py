"""`hairpipe run --keep`: a worker that outlives its run, and everything that ends it."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hairpipe.child import command
from hairpipe.engine.hosts.keeper import BOOT

from ..conftest import START

NODE = '''"""Names the process that evaluates it."""

import os
import time
from pathlib import Path
from typing import Annotated

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Suffixes


@node(frames="once")
def name_process(workspace: Workspace, *, value: int, pause: float) -> Annotated[File, Suffixes((".txt",))]:
    """Write the number of the process.

    value  any number
    pause  time to wait
    """
    path = Path(workspace, "process.txt")
    path.write_text(f"{os.getpid()} {os.environ.get('FLAVOUR')}")
    print("printed by a node")
    Path(os.environ["STARTED"]).write_text(str(os.getpid()))
    time.sleep(pause)
    return File(path)
'''
SHOT = """schema = 1
frames = [1, 1]
fps = 24
[name]
type = "name_process"
value = 0
pause = 0.0
publish = "out/process.txt"
"""


class Desk:
    """A folder with a shot, from which commands are called."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "nodes").mkdir()
        (folder / "nodes" / "name_process.py").write_text(NODE)
        (folder / "shot.toml").write_text(SHOT)
        (folder / "run").mkdir(mode=0o700)
        own = {"HAIRPIPE_TRUST": "nodes", "HAIRPIPE_CACHE": "cache", "XDG_RUNTIME_DIR": "run", "STARTED": "started"}
        self.environment = os.environ | {name: str(folder / value) for name, value in own.items()}
        self.value = 0

    def call(self, *words: str, **variables: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*START, *words],
            cwd=self.folder,
            env=self.environment | variables,
            capture_output=True,
            text=True,
            timeout=120,
        )

    def words(self, pause: float = 0.0) -> list[str]:
        self.value += 1
        return ["run", "shot.toml", "--keep", "--set", f"name.value={self.value}", "--set", f"name.pause={pause}", "-q"]

    def run(self, **variables: str) -> tuple[int, str]:
        """Run with a new setting; the number of the process that has computed, and what it sees of a variable."""
        done = self.call(*self.words(), **variables)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
        process, flavour = (self.folder / "out" / "process.txt").read_text().split()
        return int(process), flavour

    @property
    def sockets(self) -> list[Path]:
        return sorted((self.folder / "run").glob("hairpipe/*.workers"))

    def keepers(self) -> list[int]:
        """Find the keepers of these sockets."""
        found = []
        for entry in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                text = entry.read_bytes().decode(errors="replace")
            except OSError:
                continue
            if "engine.keeper" in text and str(self.folder) in text:
                found.append(int(entry.parent.name))
        return found


@pytest.fixture
def desk(tmp_path):
    desk = Desk(tmp_path)
    yield desk
    desk.call("workers", "--end")
    assert not desk.sockets and ends(*desk.keepers())


def ends(*processes: int) -> bool:
    """Wait for the end of processes."""
    end = time.monotonic() + 30.0
    while any(is_alive(process) for process in processes):
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def is_alive(process: int) -> bool:
    """Whether a process runs: one that has ended may still wait for its parent."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_worker_serves_runs_until_variables_or_code_change(desk):
    first = desk.run()
    assert desk.run() == first
    assert desk.sockets[0].stat().st_mode & 0o777 == 0o600
    assert "1 idle worker" in desk.call("workers").stdout
    other = desk.run(FLAVOUR="sour")
    assert other[0] != first[0] and other[1] == "sour" and ends(first[0])
    with (desk.folder / "nodes" / "name_process.py").open("a") as file:
        file.write("OTHER = 1\n")
    changed, _ = desk.run(FLAVOUR="sour")
    assert changed != other[0]
    assert desk.call("workers", "--end").stdout == "2 workers ended\n"
    assert ends(changed, other[0])
    assert desk.call("workers").stdout == "no idle workers\n"


def test_a_worker_ends_with_a_run_that_is_killed(desk):
    kept, _ = desk.run()
    (desk.folder / "started").unlink()
    run = subprocess.Popen([*START, *desk.words(pause=600.0)], cwd=desk.folder, env=desk.environment)
    while not (desk.folder / "started").is_file():
        assert run.poll() is None
        time.sleep(0.02)
    run.kill()
    run.wait()
    assert ends(kept)
    assert desk.run()[0] != kept


def test_workers_end_with_a_keeper_that_is_killed_and_the_next_run_starts_another(desk):
    kept, _ = desk.run()
    (keeper,) = desk.keepers()
    os.kill(keeper, signal.SIGKILL)
    assert ends(kept) and desk.sockets
    assert desk.run()[0] != kept


def test_a_keeper_ends_when_it_is_idle_and_there_is_one_at_a_socket(desk):
    path = desk.folder / "run" / "hairpipe" / "some.workers"
    path.parent.mkdir(mode=0o700)
    one = subprocess.Popen(command(BOOT.format(str(path), 3.0)), env=desk.environment)
    while not path.exists():
        time.sleep(0.02)
    subprocess.run(command(BOOT.format(str(path), 600.0)), env=desk.environment, check=True, timeout=60)
    assert one.wait(timeout=60) == 0 and not path.exists()


def test_a_folder_of_others_is_refused(desk):
    (desk.folder / "run" / "hairpipe").mkdir()
    (desk.folder / "run" / "hairpipe").chmod(0o777)
    done = desk.call(*desk.words())
    assert done.returncode == 2 and "can be written to by others" in done.stderr
    (desk.folder / "run" / "hairpipe").chmod(0o700)


def test_a_pipe_of_a_run_is_not_held_open(desk):
    """A command that reads the output of a run ends with the run, although its worker stays."""
    text = " ".join(["{python}", "-c", "'from hairpipe.app.cli import main; main()'", *desk.words()])
    begun = subprocess.run(
        ["bash", "-c", f"{text.format(python=sys.executable)} 2>&1 | cat"],
        cwd=desk.folder,
        env=desk.environment,
        timeout=120,
        check=True,
        capture_output=True,
    )
    assert begun.stdout == b"" and "1 idle worker" in desk.call("workers").stdout
