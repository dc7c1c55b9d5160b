"""Strokes of a brush on a body: each writes a picture next to the graph, which a setting reads."""

import base64
from typing import Any

import numpy as np

from hairpipe.api.draft import Draft
from hairpipe.io.image import encoded_image
from hairpipe.page.editing.edits import painted_group

FOLDER = "paint"
"""Folder of the pictures, next to the graph file."""


def write_stroke(draft: Draft, given: dict[str, Any]) -> str:
    """Write the picture of a request into a new file; return its path from the graph.

    ValueError for values that are not those of a picture; BadInput for a setting that reads none, and as `write_new`.
    """
    target = str(given["target"])
    painted_group(draft, target)
    values = np.frombuffer(base64.b64decode(given["values"], validate=True), np.uint8)
    data = encoded_image(values.reshape(int(given["height"]), -1))
    name = target.replace(".", "_")
    numbers = [path.stem.rpartition("_")[2] for path in (draft.shot.path.parent / FOLDER).glob(f"{name}_*.png")]
    number = 1 + max((int(found) for found in numbers if found.isdecimal()), default=0)
    return draft.write_new(f"{FOLDER}/{name}_{number}.png", data)
