"""Third-party files: `file.data = "NAME"` is a path relative to the data folder.

The variable HAIRPIPE_DATA names the folder; its default in a checkout is `shared/data` next to the checkout.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

import hairpipe
from hairpipe.errors import BadInput
from hairpipe.graph.node.fields import Field

VARIABLE = "HAIRPIPE_DATA"
KEY = "data"
"""Key of a table that replaces the path of a file."""
RIGHT = f"a file below the folder that {VARIABLE} names; `hairpipe data check` lists those that shipped graphs read"
Place = Callable[[Sequence[str]], str]


def data_folder() -> Path | None:
    """Return the data folder, which may not exist; None outside of a checkout if the variable is not set."""
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given).absolute()
    checkout = Path(hairpipe.__file__).resolve().parents[1]
    return checkout.parent / "shared" / "data" if (checkout / "pyproject.toml").is_file() else None


def known_folder() -> Path:
    """Return the data folder; BadInput if it is not known."""
    folder = data_folder()
    if folder is None:
        raise BadInput(f"{VARIABLE} is not set", right="the folder of third-party data")
    return folder


def located(
    fields: Iterable[Field], given: dict[str, Any], place: Place, above: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Return settings in which each `{ data = NAME }` in place of a file is replaced by the path; pure.

    place  returns the line of a setting

    BadInput if the data folder is not known, or the name is outside of it.
    """
    changed = dict(given)
    for field in fields:
        value = given.get(field.name)
        names = (*above, field.name)
        if isinstance(value, dict) and field.group:
            changed[field.name] = located(field.group, value, place, names)
        elif isinstance(value, dict) and field.base is Path and value.keys() == {KEY}:
            changed[field.name] = path_of(value[KEY], ".".join(names), place(names))
    return changed


def path_of(name: Any, setting: str, where: str) -> str:
    """Return the path of a file in the data folder; BadInput as above."""
    inside = isinstance(name, str) and not PurePosixPath(name).is_absolute() and ".." not in PurePosixPath(name).parts
    if not inside:
        raise BadInput(f"{setting}.{KEY} = {str(name)[:200]!r} is outside of the data folder", where=where, right=RIGHT)
    try:
        return str(known_folder() / name)
    except BadInput as fault:
        raise BadInput(f"{setting}.{KEY} = {name[:200]!r}: {fault.what}", where=where, right=RIGHT) from None


def is_data(file: str) -> bool:
    """Whether the path of a setting is in the data folder."""
    folder = data_folder()
    return folder is not None and Path(file).is_relative_to(folder)
