"""What a host must have to take the jobs of a run: the same store, code, and versions as the coordinator.

A store has an identity, a random name within, by which machines find out whether they see the same one. A path is not
enough: on another machine it may lead to an empty folder, or to the store of another project.
"""

import json
import re
import secrets
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import hairpipe
from hairpipe import __version__
from hairpipe.child import search_path
from hairpipe.engine.code import INSTALLED, Code
from hairpipe.engine.file.trust import Files, code_in, differing, grant, trust_error
from hairpipe.engine.node.import_paths import OUR_NODES, folder_of
from hairpipe.engine.node.messages import listed
from hairpipe.engine.store.atomic import write_text
from hairpipe.engine.store.digest import digest, digest_bytes
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.plain_file import stamp_of

CLAIM = digest("identity", "")
"""Key of the lease of whoever gives a store its identity: two may find none at one time."""
PAUSE = 0.05
"""Time until the identity that another gives is looked for again [s]."""
_NAME = re.compile(r"[0-9a-f]{32}")


def identity_of(root: Path) -> str | None:
    """Read the identity of a store; None where it has none."""
    with suppress(OSError, UnicodeDecodeError):
        text = (root / "id").read_text(encoding="utf-8").strip()
        return text if _NAME.fullmatch(text) else None
    return None


def claim_identity(store: Store) -> str:
    """Read the identity of a store, which is given one if it has none; OSError where that cannot be written."""
    leases = Leases(store)
    while (known := identity_of(store.root)) is None:
        if leases.acquire(CLAIM):
            if identity_of(store.root) is None:
                write_text(store.room(store.root / "id"), secrets.token_hex(16), store.temporary)
            leases.release(CLAIM)
        else:
            time.sleep(PAUSE)
    return known


VERSIONS = f"hairpipe {__version__}, Python {sys.version_info.major}.{sys.version_info.minor}"


@dataclass(frozen=True)
class Offer:
    """A run as a host sees it, as plain values; folders are absolute.

    modules   of the node types
    trusted   digests of the code in the folder of node types, by path within it, that the user of the coordinator
              trusts; None: the host asks its own user's record
    identity  of the store; None on the machine of the coordinator
    run       random name of the run
    versions  of hairpipe and Python
    """

    store: str
    folder: str
    modules: tuple[str, ...]
    trusted: Files | None = None
    identity: str | None = None
    run: str = ""
    versions: str = VERSIONS


def sent_offer(store: Store, folder: Path, modules: tuple[str, ...]) -> Offer:
    """Make the offer for other machines; OSError where the store cannot be written to."""
    trusted = code_in(folder.resolve()) if folder.is_dir() and trust_error(folder) is None else None
    run = secrets.token_hex(8)
    return Offer(str(store.root), str(folder.absolute()), modules, trusted, claim_identity(store), run)


def accept(offer: Offer, machine: str) -> None:
    """Trust the code of an offer in this process; BadInput where something differs on this machine."""
    if offer.versions != VERSIONS:
        raise BadInput(f"{machine} has {VERSIONS}", right=f"install {offer.versions} there")
    if offer.identity != identity_of(Path(offer.store)):
        what = f"{machine} has another store, or none, at {offer.store}"
        raise BadInput(what, right="mount the same folder at the same path there")
    if offer.trusted is not None:
        found = code_in(Path(offer.folder).resolve())
        if found != offer.trusted:
            names = listed(differing(offer.trusted, found))
            raise BadInput(f"{machine} has other code in {offer.folder}: {names}", right="copy the folder there")
        grant(offer.trusted)


def code_difference(machine: str, node_type: str, own: Code, manifest: str | None) -> BadInput:
    """Make the error for code that differs on a machine; `manifest` is that of the coordinator, where it is known."""
    theirs: dict[str, str] = json.loads(manifest or "{}")
    names = [name for name in differing(theirs, own.parts)] if theirs else []
    for place, name in enumerate(names):
        what, _, is_version = name.partition(" (")
        if is_version:
            names[place] = f"{what} {own.parts.get(name, 'none')} in place of {theirs.get(name, 'none')}"
    what = f"{machine} has other code of '{node_type}': {listed(names)}"
    return BadInput(what, right="install the same versions there, and retry")


def program_digest(*folders: Path) -> str:
    """Digest the stamps of everything that a new process would import: it differs after any change of code or versions.

    folders  of further code
    """
    ours = [Path(hairpipe.__file__).parent, folder_of(OUR_NODES), *folders]
    path = search_path()
    packages = [entry for entry in path if Path(entry).name in INSTALLED]
    files = [str(file) for folder in ours if folder is not None for file in sorted(folder.rglob("*.py"))]
    stamps = {file: stamp_of(file) for file in (sys.executable, *packages, *files)}
    return digest_bytes("program", json.dumps([path, sys.version, stamps]).encode())
