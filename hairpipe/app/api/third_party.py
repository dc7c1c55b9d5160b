"""Third-party data that some graphs and tests read: source and presence of each file."""

import csv
import hashlib
from pathlib import Path
from typing import Literal, NamedTuple

from hairpipe.engine.file.bounds import known_folder
from hairpipe.errors import BadInput
from hairpipe.plain_file import content

State = Literal["present", "absent", "differs"]
TABLE = "assets/third_party.csv"  # the table of these files, below the folder of the shipped graphs


class DataFile(NamedTuple):
    """A file and its source."""

    name: str  # in the data folder
    repository: str
    commit: str  # of the repository, on GitHub, in which the file has this path
    path: str
    sha256: str  # of its bytes
    licence: str


def third_party_files() -> list[DataFile]:
    import hairpipe.graphs  # pyright: ignore[reportMissingImports] - the folder graphs, once installed

    with (Path(hairpipe.graphs.__file__).parent / TABLE).open(encoding="utf-8", newline="") as file:
        return [DataFile(**row) for row in csv.DictReader(file)]


def check_data() -> tuple[Path, dict[DataFile, State]]:
    """Compare all files in the data folder with their digests; BadInput where the folder is not known."""
    folder = known_folder()
    return folder, {source: state_of(source, folder) for source in third_party_files()}


def state_of(source: DataFile, folder: Path) -> State:
    """Compare a file in a data folder with its digest; a path that is not a regular file differs, and is not read."""
    path = folder / source.name
    if not path.exists():
        return "absent"
    try:
        found = hashlib.sha256(content(path, "a file")).hexdigest()
    except BadInput:
        return "differs"
    return "present" if found == source.sha256 else "differs"
