"""Rules for a body that is not drawn under its hair."""

from collections.abc import Iterator

from pxr import Sdf, Usd, UsdGeom

from hairpipe.formats.usd.check.drawn import why_hidden
from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.roots import authored_roots
from hairpipe.formats.usd.check.scene import Scene, notes_of


def body_drawn(scene: Scene) -> Iterator[Fault]:
    """Find a noted body, or the only skin of hair, that is missing or not drawn."""
    noted = _noted(scene.stage)
    body = scene.stage.GetPrimAtPath(noted or Sdf.Path.emptyPath)
    if noted and scene.hair and not body and not scene.meshes:
        yield Fault(str(noted), "is missing: the stage was written with a body there, and has no other mesh")
    hidden = {body.GetPath(): why_hidden(body, UsdGeom.Mesh)} if body else {}
    for roots in filter(None, (authored_roots(scene, track) for track in scene.hair)):
        reason = why_hidden(roots.mesh.prim, UsdGeom.Mesh)
        if reason and not reason[2] and not any(mesh.prim != roots.mesh.prim for mesh in scene.meshes):
            hidden[roots.mesh.prim.GetPath()] = reason
    for path, reason in hidden.items():
        if reason and scene.hair:
            yield Fault(str(path), f"{reason[0]}; hair on it is drawn, and the body is not", reason[1])


def _noted(stage: Usd.Stage) -> Sdf.Path | None:
    """Return the path of the body that we noted in the stage; None without a note."""
    body = notes_of(stage).get("body")
    known = isinstance(body, str) and Sdf.Path.IsValidPathString(body) and body.startswith("/")
    return Sdf.Path(body) if known else None


RULES = (Rule("body-drawn", "warning", body_drawn),)
