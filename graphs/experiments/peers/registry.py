"""The solvers by name, and which of them are installed."""

from collections.abc import Callable, Iterable
from importlib.util import find_spec
from typing import NamedTuple

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.peers import elastica_rods, newton_cables, ours, pbd_rods
from hairpipe.graphs.experiments.peers.hanging import Hanging, Peer, Strands


class Adapter(NamedTuple):
    """How a solver is used.

    library    that has to be installed
    peers      the settings that are compared
    converged  a strand that is resolved beyond all others; None where the solver is not used for that
    """

    library: str
    peers: Callable[[], list[Peer]]
    converged: Callable[[Hanging], Strands] | None = None


ADAPTERS = {
    "hairpipe": Adapter("hairpipe", ours.peers, ours.converged),
    "pyelastica": Adapter("elastica", elastica_rods.peers, elastica_rods.converged),
    "pypbd": Adapter("pypbd", pbd_rods.peers),
    "newton": Adapter("newton", newton_cables.peers),
}


def installed(
    names: Iterable[str] | None, echo: Callable[[str], None], adapters: dict[str, Adapter] = ADAPTERS
) -> dict[str, Adapter]:
    """Return the adapters of these solvers, or of all, without those of absent libraries; each of them is a line.

    BadInput where a name is not one of a solver.
    """
    found = dict[str, Adapter]()
    for name in adapters if names is None else names:
        if name not in adapters:
            raise BadInput(f"unknown solver {name!r}", where="--peers", right=", ".join(adapters))
        if find_spec(adapters[name].library) is None:
            echo(f"{name} is not installed and is left out; all are in the extra `peers`")
        else:
            found[name] = adapters[name]
    return found
