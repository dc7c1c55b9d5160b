"""The graph of a shot as plain tables, and which object of Blender each table is of.

`hairpipe bridge` writes them to a file: tables with other names in it, and comments, are kept.
"""

from typing import Any, NamedTuple

OWNED = [
    *("body", "body_rest", "surface", "groom", "guides", "hair"),
    *("groom_*", "shape_*", "shown_*", "usd_*", "pins_*", "collider_*", "surface_*"),
]
"""Names of tables that are the extension's: those that it does not need any more are removed."""

CHECKPOINT = 8
"""A run that goes on, or that follows a later change, computes at most so many frames again."""


class Collider(NamedTuple):
    """An object that stops hair: its name here and in Blender, whether it is a sheet, and how thick [m]."""

    slug: str
    name: str
    sheet: bool
    thickness: float


class HairObject(NamedTuple):
    """Curves of a shot: name here and in Blender, and places of pins along the strands of a group."""

    slug: str
    name: str
    pins: dict[str, list[float]]


class Shot(NamedTuple):
    """What the graph depends on.

    body     name of the object that carries the hair
    range    first and last frame of the graph, and frames per second
    samples  of a surface in a frame
    roots, surface, simulation, interpolation  settings of nodes, see `settings.values_of`
    every    simulate every n-th curve, and interpolate the others
    """

    hairs: list[HairObject]
    body: str
    colliders: list[Collider]
    first: int
    last: int
    fps: float
    samples: int
    roots: dict[str, Any]
    surface: dict[str, Any]
    simulation: dict[str, Any]
    interpolation: dict[str, Any]
    pins: dict[str, Any]
    every: int


def head_of(shot: Shot) -> dict[str, Any]:
    return {"frames": [shot.first, shot.last], "fps": shot.fps}


def tables_of(shot: Shot) -> dict[str, dict[str, Any]]:
    """Return the tables of a shot, in the order in which one reads them."""
    tables: dict[str, dict[str, Any]] = {
        "body_rest": {"type": "load_body", "file": "body/rest.ply"},
        "body": {"type": "load_mesh_cache", "in": {"rest": "body_rest"}, **sequence("body", shot)},
        "surface": {"type": "bake_levelset", "in": {"body": "body"}, **shot.surface},
    }
    surfaces = ["surface"]
    for item in shot.colliders:
        mesh, level = f"collider_{item.slug}", f"surface_{item.slug}"
        tables[mesh] = {"type": "load_mesh_cache", **sequence(mesh, shot)}
        socket = "sheets" if item.sheet else "body"
        thick = {"thickness": item.thickness} if item.sheet and item.thickness else {}
        tables[level] = {"type": "bake_levelset", "in": {socket: mesh}, **shot.surface, **thick}
        surfaces.append(level)
    scalp = {"scalp": "body_rest"}
    for item in shot.hairs:
        shape = f"curves/{item.slug}.usda"
        file = f"curves/{item.slug}.pins.usda" if item.pins else shape
        tables[f"groom_{item.slug}"] = {"type": "load_groom", "in": scalp, "file": file, **shot.roots}
        reach = {"reach": shot.roots["reach"]} if "reach" in shot.roots else {}
        tables[f"shape_{item.slug}"] = {"type": "load_groom", "in": scalp, "file": shape, "points": "file", **reach}
    groom = f"groom_{shot.hairs[0].slug}"
    if len(shot.hairs) > 1:
        groom = "groom"
        tables[groom] = {"type": "join_grooms", "in": {"grooms": [f"groom_{item.slug}" for item in shot.hairs]}}
    if shot.every > 1:
        tables["guides"] = {"type": "thin_groom", "in": {"groom": groom}, "every": shot.every}
        groom = "guides"
    held = {"pins": [*pin_tables(shot, groom, tables)]}
    edges = {"groom": groom, "body": "body", "surface": surfaces if len(surfaces) > 1 else "surface"}
    edges |= held if held["pins"] else {}
    tables["hair"] = {"type": "simulate_hair", "in": edges, "checkpoint": CHECKPOINT, **shot.simulation}
    for item in shot.hairs:
        shape, shown = f"shape_{item.slug}", f"shown_{item.slug}"
        edges = {"hair": "hair", "keys": groom, "groom": shape, "body": "body", "surface": surfaces}
        tables[shown] = {"type": "interpolate_hair", "in": edges, **shot.interpolation}
        tables[f"usd_{item.slug}"] = {
            "type": "export_groom",
            "in": {"groom": shape, "hair": shown},
            "target": "blender",
            "publish": f"{item.slug}.usdc",
        }
    return tables


def pin_tables(shot: Shot, groom: str, tables: dict[str, dict[str, Any]]) -> list[str]:
    """Add a table for each group of pinned strands; return their names."""
    places = {group: at for item in shot.hairs for group, at in item.pins.items()}
    for group, at in places.items():
        edges = {"groom": groom, "body": "body"}
        tables[group] = {"type": "pin_hair", "in": edges, "group": group, "at": at, **shot.pins}
    return [*places]


def sequence(name: str, shot: Shot) -> dict[str, Any]:
    """Return the settings that read the samples of a surface: file 0 is at the first frame."""
    fast = {"speed": float(shot.samples)} if shot.samples > 1 else {}
    return {"file": f"{name}/{name}.####.ply", "at": shot.first, "start": 0.0, **fast}


def object_of(node: str, shot: Shot) -> str:
    """Return the name of the object of Blender that a node of the graph is of."""
    for item in (*shot.hairs, *shot.colliders):
        if node.partition("_")[2] == item.slug:
            return item.name
    return shot.body if node in ("body", "body_rest", "surface") else shot.hairs[0].name
