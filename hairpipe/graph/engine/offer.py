"""What a host must have to take the jobs of a run: the same store, code, and versions as the coordinator."""

import json
import secrets
import sys
from dataclasses import dataclass
from pathlib import Path

from hairpipe import __version__
from hairpipe.errors import BadInput
from hairpipe.graph.file.trust import Files, code_in, differing, grant, listed, trust_error
from hairpipe.graph.key.code import Code
from hairpipe.graph.store.identity import claim_identity, identity_of
from hairpipe.graph.store.store import Store

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
    codec: str
    folder: str
    modules: tuple[str, ...]
    trusted: Files | None = None
    identity: str | None = None
    run: str = ""
    versions: str = VERSIONS


def sent_offer(store: Store, codec: str, folder: Path, modules: tuple[str, ...]) -> Offer:
    """Make the offer for other machines; OSError where the store cannot be written to."""
    trusted = code_in(folder.resolve()) if folder.is_dir() and trust_error(folder) is None else None
    run = secrets.token_hex(8)
    return Offer(str(store.root), codec, str(folder.absolute()), modules, trusted, claim_identity(store), run)


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
    reported = [
        f"{name.partition(' (')[0]} {own.parts.get(name, 'none')} in place of {theirs.get(name, 'none')}"
        if name.endswith(")")
        else name
        for name in names
    ]
    return BadInput(
        f"{machine} has other code of '{node_type}': {listed(reported)}",
        right="install the same versions there, and retry",
    )
