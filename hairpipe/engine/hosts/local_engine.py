"""The engine of this machine: its host in the process of the scheduler."""

from collections.abc import Iterable, Iterator
from multiprocessing.connection import wait

from hairpipe.engine.hosts.host import Host
from hairpipe.engine.hosts.member import Member
from hairpipe.engine.hosts.protocol import Job, Reply, Slots

MACHINE = "this machine"


class LocalEngine:
    """Evaluates jobs in the workers of this machine.

    most  largest numbers of jobs at a time; by default a wide one, and as many narrow ones as a wide one has threads
    """

    def __init__(self, host: Host, most: Slots | None = None) -> None:
        self.host, self.most = host, most or Slots(1, host.threads)
        self.machines = {host.machine}
        self._at_once: list[Reply] = []

    @property
    def warnings(self) -> list[str]:
        """Those of the host."""
        return self.host.warnings

    def slots(self) -> Slots:
        """Count the free slots."""
        wide = sum(member.wide for member in self.host.busy)
        return Slots(self.most.wide - wide, self.most.narrow - len(self.host.busy) + wide)

    def submit(self, job: Job) -> None:
        """Begin a job in a free slot."""
        begun = self.host.begin(job)
        if not isinstance(begun, Member):
            self._at_once.append(begun)

    def replies(self, timeout: float | None) -> Iterator[Reply]:
        """Wait for replies; that of a worker that died is a failure."""
        if self._at_once:
            yield self._at_once.pop()
            return
        ready = wait([member.connection for member in self.host.busy], timeout)
        for member in [member for member in self.host.busy if member.connection in ready]:
            yield self.host.reply_of(member)

    def leave_out(self, machine: str) -> None:
        """Give this machine no further jobs."""
        self.machines.discard(machine)

    def cancel(self, keys: Iterable[str]) -> None:
        """Kill the workers of these jobs."""
        self.host.cancel(set(keys))

    def close(self) -> None:
        """End the host."""
        self.host.close()
