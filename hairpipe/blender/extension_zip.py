"""The extension for Blender as a zip file: a manifest, the files of `extension`, and what the nodes declare."""

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hairpipe import __version__
from hairpipe.errors import BadInput

FOLDER = Path(__file__).with_name("extension")
NODES = ("simulate_hair", "bake_levelset", "load_groom", "interpolate_hair")
"""Node types whose settings the extension shows."""
MANIFEST = """schema_version = "1.0.0"
id = "hairpipe"
version = "{version}"
name = "Hairpipe"
tagline = "Simulates hair on a moving body"
maintainer = "The authors of hairpipe"
type = "add-on"
blender_version_min = "4.2.0"
license = ["SPDX:GPL-3.0-or-later"]
tags = ["Animation", "Physics"]

[permissions]
files = "Write hair and bodies next to the .blend file"
"""
DATE = (1980, 1, 1, 0, 0, 0)
"""Of all files in the zip: the same code gives the same bytes."""


def declaration(describe: Callable[[str], Any]) -> str:
    """Return `declaration.json`: the version, and the documents of node types."""
    return json.dumps({"hairpipe": __version__, "types": {name: describe(name) for name in NODES}}, indent=1)


def contents(describe: Callable[[str], Any]) -> dict[str, bytes]:
    """Return the files of the extension by their names; `describe` gives the document of a node type."""
    files = {path.name: path.read_bytes() for path in sorted(FOLDER.glob("*.py"))}
    files["blender_manifest.toml"] = MANIFEST.format(version=__version__).encode()
    files["declaration.json"] = declaration(describe).encode()
    return files


def write_extension(output: Path, describe: Callable[[str], Any]) -> None:
    """Write the zip file; BadInput for a name that does not end like one."""
    if output.suffix.lower() != ".zip":
        raise BadInput("it does not end like a zip file", where=output, right=".zip")
    output.parent.mkdir(parents=True, exist_ok=True)
    part = output.with_name(f".{output.name}.part")
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in contents(describe).items():
            archive.writestr(zipfile.ZipInfo(name, DATE), data, zipfile.ZIP_DEFLATED)
    part.replace(output)
