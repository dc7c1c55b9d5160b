"""Provenance of figures: the commit of the code, and the machine."""

import subprocess
from pathlib import Path

from hairpipe.bench.machine import this_machine
from hairpipe.errors import BadInput
from hairpipe.processor import processor_class
from hairpipe.results.file import FOLDER, Machine

LAYER = "threading layer"


def repository_of(folder: Path) -> Path:
    """Find the root of the git repository of a folder; BadInput if there is none."""
    return Path(git(folder, "rev-parse", "--show-toplevel"))


def commit_of(folder: Path) -> str:
    """Find the commit of the repository of a folder; BadInput if its code has uncommitted changes.

    Pages, films and results may have changes: no result depends on them.
    """
    found = git(folder, "status", "--porcelain", "--untracked-files=all", "--no-renames", "-z").split("\0")
    changed = [name for line in found if (name := line[3:]) and not is_written(name)]
    if changed:
        more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
        raise BadInput(f"uncommitted changes: {changed[0]}{more}", where=folder, right="figures of committed code")
    return git(folder, "rev-parse", "HEAD")


def is_written(name: str) -> bool:
    """Whether a file of a repository is a page, a film or a results file."""
    path = Path(name)
    return path.suffix in (".md", ".webp") or (path.suffix == ".json" and path.parent.name == FOLDER)


def recording_machine(bandwidth: float | None = None) -> Machine:
    """Describe this machine.

    bandwidth  of memory [GB/s], None if it was not measured
    """
    found = this_machine()
    versions = {name: version for name, version in found.versions.items() if name != LAYER}
    return Machine(found.processor, found.cores, bandwidth, processor_class(), found.versions[LAYER], versions)


def git(folder: Path, *words: str) -> str:
    """Return the output of git; BadInput if it fails or is missing."""
    try:
        done = subprocess.run(["git", "-C", folder, *words], capture_output=True, text=True, check=True)
    except FileNotFoundError:
        raise BadInput("git is not installed", where=folder, right="figures name the commit of the code") from None
    except subprocess.CalledProcessError:
        raise BadInput("not in a git repository", where=folder, right="figures name the commit of the code") from None
    return done.stdout.strip("\n")
