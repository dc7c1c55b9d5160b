"""Causes of findings: the node and settings of the graph by which a file became what it is, and what to write there.

The root prim of a shot has the graph in its metadata (`noted` of `hairpipe/formats/usd/shot.py`). What no row of CAUSES
explains, hairpipe writes right: the file was changed later on.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

from pxr import Sdf, Usd

from hairpipe.formats.usd.check.clients import CLIENTS
from hairpipe.formats.usd.check.scene import FAULTS, Cause, Finding
from hairpipe.formats.usd.stage import NOTES

SHOT = "shot"
"""Type of the row whose settings are those of the graph, not of a node."""
GROOM = ("hairId", "pref", "st", "skinprim", "skinprimuv")
SOCKETS = {**dict.fromkeys(GROOM, "groom"), "lockId": "states", "groom_guide": "keys"}
"""Input of `export_usd` that an attribute of hair is written from, without its prefix; `hair` for all others."""
PRIMS = {"body": "body", "levelset": "volume"}
"""The same for the prims of a shot."""


class Row(NamedTuple):
    """A possible cause of the findings of a rule.

    types     types of the nodes, of which the nearest before the attribute is named
    settings  by which they cause it
    write     what to write, with {node} in place of its name
    values    values that the settings have then; none: any
    """

    types: tuple[str, ...]
    settings: tuple[str, ...]
    write: str
    values: Mapping[str, Any] = {}


EXPORT = ("export_usd",)
BASIS = Row(EXPORT, ("curve",), '{node}.curve = "catmull_rom"', {"curve": "bspline"})
HAIR = ("simulate_hair",)
STEPS = Row(
    ("simulate_hair", "simulate_particles"), ("steps.longest", "steps.most"), "half of {node}.steps.longest [s]"
)
LIMIT = Row(HAIR, ("strain.tolerance", "steps.longest"), "{node}.strain.tolerance = 0.02, or half of steps.longest")
GROWN = Row(
    ("grow_groom", "make_strands"), ("segments", "segment_length", "curl"), "more {node}.segments, 8 or more a turn"
)
LOADED = Row(
    ("load_groom",), ("file", "points", "shortest"), '{node}.points = "equal", and a larger {node}.shortest [m]'
)
GROOM_FILE = Row(("load_groom",), ("file",), "another {node}.file, mended in the program that wrote it")
BODY_FILE = Row(("load_body", "load_mesh_cache"), ("file",), "another {node}.file, mended in the program that wrote it")
UNITS = Row(("load_body", "load_groom", "load_mesh_cache"), ("unit", "up"), "{node}.unit: metres per unit of its file")
WIDTHS = Row(EXPORT, ("hairs",), "{node}.hairs: number of hairs that the strands represent; absent: of single hairs")
DIAMETER = Row(HAIR, ("material.diameter",), "{node}.material.diameter [m], such as 8e-5")
FIELDS = Row(("export_vdb", "bake_levelset"), ("voxel",), "{node}.voxel [m], smaller than the thinnest part")
FOLDERS = Row(EXPORT, ("layout", "name"), "the folders NAME.clips and NAME.volume next to the file: publish again")
CUTS = Row((SHOT,), ("cuts",), "cuts = [FRAME] of the graph, if the shot is cut there")
START = Row((SHOT,), ("preroll", "cuts"), "preroll = 24 of the graph, if hair starts from rest, or cuts, if it is cut")
CAUSES: dict[str, tuple[Row, ...]] = {
    **dict.fromkeys(("hair-basis", *(f"{name}-basis" for name in CLIENTS)), (BASIS,)),
    "collapsed": (LOADED, GROWN, STEPS),
    "spike": (STEPS, LOADED),
    "zigzag": (STEPS, LOADED, GROWN),
    "stretch": (LIMIT, STEPS),
    "finite": (STEPS,),
    "strand-jumps": (CUTS,),
    "velocity-match": (START,),
    "acceleration-match": (START,),
    "widths": (WIDTHS, DIAMETER, GROOM_FILE),
    "taper": (GROOM_FILE, DIAMETER),
    "widths-uneven": (GROOM_FILE, DIAMETER),
    "widths-steady": (DIAMETER,),
    "size": (UNITS, DIAMETER, WIDTHS),
    "precision": (Row(("move_mesh", "load_motion"), ("at", "unit"), "{node}: a shot near the origin"), UNITS),
    "rounded": (Row(("load_groom", "load_body"), ("file", "unit"), "another {node}.file, in single precision"),),
    "up-axis": (UNITS,),
    "holes": (BODY_FILE,),
    "normals": (BODY_FILE,),
    "doubled": (Row(("join_grooms",), ("groups",), "{node}.in.grooms: each groom once"), GROOM_FILE),
    "root-uv": (BODY_FILE, GROOM_FILE),
    "rest": (UNITS, GROOM_FILE),
    "roots": (Row(("load_groom",), ("reach", "roots", "unit"), "{node}.unit, or a smaller {node}.reach [m]"),),
    "lock-ids": (Row(HAIR, ("locks",), "{node}.locks, and in.states of the same simulation"),),
    "volume-size": (FIELDS,),
    "volume-still": (FIELDS,),
    "openvdb-grid": (FIELDS,),
    "missing-file": (FOLDERS,),
    "broken-layer": (FOLDERS,),
    "frame-names": (FOLDERS,),
}
"""Rows by rule, the likeliest first. Rules that are not listed are kept by every file that `export_usd` writes."""
PROGRAMS = {name: Row(EXPORT, (), f'a node export_groom with target = "{name}"') for name in CLIENTS}
"""Row of all other rules of a program that does not read the files of `export_usd`."""
CROSSED = {"roots": "body", "rest": "groom", "skin-range": "groom", "hair-ids": "groom", "root-uv": "groom"}
"""Input by rule that the export and the simulation have to share."""


@dataclass(frozen=True)
class Lineage:
    """The graph behind a shot, from its metadata.

    version  of hairpipe
    node     name of the node that wrote it
    key      digest of the graph up to it
    shot     settings of the graph
    nodes    `type`, `in` and `settings` by name
    """

    version: str
    node: str
    key: str
    shot: dict[str, Any]
    nodes: dict[str, dict[str, Any]]

    def upstream(self, *sockets: str) -> list[str]:
        """List the export and the nodes before it, those behind the sockets first, the nearest first."""
        ways = [self.behind(socket) for socket in (*sockets, *self.nodes[self.node]["in"])]
        return list(dict.fromkeys([self.node, *(name for way in ways for name in way)]))

    def behind(self, socket: str) -> list[str]:
        """List the nodes behind an input of the export, the nearest first; none where it is not connected."""
        begin = self.nodes[self.node]["in"].get(socket)
        queue = [begin] if begin else []
        found = list[str]()
        while queue:
            name = queue.pop(0).partition(".")[0]
            if name in self.nodes and name not in found:
                found.append(name)
                queue += self.nodes[name]["in"].values()
        return found

    def settings(self, name: str) -> dict[str, Any]:
        """Return the settings of a node, or of the graph for SHOT, by their full names."""
        values = self.shot if name == SHOT else self.nodes[name]["settings"]
        return dict(_flat("" if name == SHOT else f"{name}.", values))


def _flat(prefix: str, values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, dict) and not is_file(value):
            yield from _flat(f"{prefix}{name}.", value)
        else:
            yield f"{prefix}{name}", value


def is_file(value: Any) -> bool:
    """Whether a setting is a file, of which the metadata have digest and suffix."""
    return isinstance(value, dict) and value.keys() == {"file", "suffix"}


def lineage_of(stage: Usd.Stage, path: str = "/") -> Lineage | None:
    """Return the lineage of a prim or attribute, or of the only shot of a stage; None where there is none."""
    place = Sdf.Path(path) if Sdf.Path.IsValidPathString(path) else Sdf.Path.absoluteRootPath
    prims = [stage.GetPrimAtPath(above) for above in reversed(place.GetPrimPath().GetPrefixes())]
    default = stage.GetDefaultPrim()
    for prim in (*prims, *([default] if default and place == Sdf.Path.absoluteRootPath else ())):
        lineage = _read(prim.GetCustomDataByKey(NOTES)) if prim else None
        if lineage:
            return lineage
    return None


def _read(notes: Any) -> Lineage | None:
    """Read the metadata of a prim; None for those of another program, or damaged ones."""
    with suppress(KeyError, TypeError, ValueError, AttributeError, RecursionError):
        nodes = {name: json.loads(text) for name, text in notes["nodes"].items()}
        whole = all(isinstance(node[part], dict) for node in nodes.values() for part in ("in", "settings"))
        sources = [source for node in nodes.values() for source in node["in"].values()]
        shot = json.loads(notes["shot"])
        texts = (notes["version"], notes["node"], notes["key"], *sources, *(node["type"] for node in nodes.values()))
        if whole and isinstance(shot, dict) and all(isinstance(text, str) for text in texts):
            version, node, key, *_ = texts
            return Lineage(version, node, key, shot, nodes) if node in nodes else None
    return None


def cause_of(finding: Finding, stage: Usd.Stage) -> Cause | None:
    """Return the cause of a finding; None for a file that does not state its graph."""
    lineage = lineage_of(stage, finding.path)
    if lineage is None or finding.severity not in FAULTS:
        return None
    order = lineage.upstream(*socket_of(finding.path))
    if crossed := _crossed(finding.rule, lineage, order):
        return crossed
    program = PROGRAMS.get(finding.rule.partition("-")[0])
    for row in CAUSES.get(finding.rule, (program,) if program else ()):
        names = [SHOT] if SHOT in row.types else [n for n in order if lineage.nodes[n]["type"] in row.types]
        for name in names:
            values = lineage.shot if name == SHOT else lineage.nodes[name]["settings"]
            chosen = {setting: _at(values, setting) for setting in row.settings}
            if all(chosen.get(setting) == value for setting, value in row.values.items()):
                prefix = "" if name == SHOT else f"{name}."
                shown = {f"{prefix}{setting}": value for setting, value in chosen.items()}
                write = row.write.format(node=name)
                return Cause(
                    name, shown, write if finding.time is None else write.replace("FRAME", f"{finding.time:g}")
                )
    write = f"nothing in the graph: {lineage.node} writes this right, and the file was changed later; publish it again"
    return Cause(lineage.node, {}, write)


def socket_of(path: str) -> tuple[str, ...]:
    """Return the input of the export from which an attribute is written; nothing for the stage."""
    prim, _, name = path.partition(".")
    if path == "/":
        return ()
    found = [socket for part, socket in PRIMS.items() if part in prim.split("/")[2:]]
    return (found[0] if found else SOCKETS.get(name.removeprefix("primvars:"), "hair"),)


def _crossed(rule: str, lineage: Lineage, order: list[str]) -> Cause | None:
    """Return the cause of a finding where the export has another body, or groom, than what moves the hair."""
    socket = CROSSED.get(rule)
    node = lineage.node
    own = lineage.nodes[node]["in"].get(socket)
    sources = ((name, lineage.nodes[name]["in"].get(socket)) for name in lineage.upstream("hair") if name != node)
    name, used = next(((name, source) for name, source in sources if source), (node, own))
    if own is None or own == used:
        return None
    return Cause(node, {f"{node}.in.{socket}": own, f"{name}.in.{socket}": used}, f'{node}.in.{socket} = "{used}"')


def _at(values: Any, setting: str) -> Any:
    """Return a setting by its dotted name; None where it, or its group, is absent."""
    for name in setting.split("."):
        values = values.get(name) if isinstance(values, dict) else None
    return values
