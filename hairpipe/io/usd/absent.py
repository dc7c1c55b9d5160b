"""Files and prims that a stage names and that do not exist: OpenUSD composes the rest without them."""

import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from pxr import Pcp, Sdf, Usd

from hairpipe.errors import BadInput
from hairpipe.io.usd.layer_files import clip_names, resolve
from hairpipe.plain_file import Absent

DROPPED = (Pcp.ErrorInvalidAssetPath, Pcp.ErrorInvalidSublayerPath, Pcp.ErrorUnresolvedPrimPath)
"""Errors of composition by which a reference, payload or sublayer is left out."""
FORMS = (
    r"Could not open asset @(?P<name>.*?)@ for (?P<kind>\w+) introduced by @(?P<file>.*?)@<(?P<prim>.*?)>",
    r"Could not load (?P<kind>sublayer) @(?P<name>.*?)@ of layer @(?P<file>.*?)@",
    r"Unresolved (?P<kind>\w+) prim path @(?P<name>.*?)@<(?P<target>.*?)> introduced by @(?P<file>.*?)@<(?P<prim>.*?)>",
)
"""Messages of OpenUSD, which has no other account of these errors."""
RIGHT = 'all files of the stage, or absent = "warn" to read the rest'


class Gap(NamedTuple):
    """One file or prim that is absent.

    path   of the prim of the stage that would have it
    what   kind and name
    where  referring layer and prim
    """

    path: Sdf.Path
    what: str
    where: str


def check_whole(stage: Usd.Stage, prim: str | None, absent: Absent) -> None:
    """Raise BadInput for an absent reference, payload, sublayer or value clip, or warn of all.

    Inactive prims and variants that are not selected do not count. Those that a prim does not need are warned of.

    prim  path or pattern of what is read; None for the whole stage
    """
    gaps = list(dict.fromkeys((*_left_out(stage), *_absent_clips(stage))))
    needed = _needed_by(stage, prim)
    for gap in gaps:
        if absent == "refuse" and (needed is None or any(_is_related(gap.path, path) for path in needed)):
            more = f", and {len(gaps) - 1} more" if len(gaps) > 1 else ""
            raise BadInput(f"{gap.what}{more}", where=gap.where, right=RIGHT)
        warnings.warn(f"{gap.where}: {gap.what}, and is left out", stacklevel=2)


def _left_out(stage: Usd.Stage) -> Iterator[Gap]:
    """Yield the references, payloads and sublayers that composition has left out."""
    for error in stage.GetCompositionErrors():
        prim = stage.GetPrimAtPath(error.rootSite.path)
        if isinstance(error, DROPPED) and not (prim and not prim.IsActive()):
            found = next((match for form in FORMS if (match := re.match(form, str(error)))), None)
            yield Gap(
                error.rootSite.path, *(_described(found) if found else (str(error), stage.GetRootLayer().realPath))
            )


def _described(found: re.Match[str]) -> tuple[str, str]:
    """Return what is absent, and where it is named, from a message of OpenUSD."""
    parts = found.groupdict()
    file = Path(parts["file"])
    name = parts["name"]
    where = f"{file} {parts['prim']}" if parts.get("prim", "/") != "/" else str(file)
    if target := parts.get("target"):
        what = "a defaultPrim" if target == "defaultPrim" else f"the prim {target}"
        return f"{name} does not have {what} of a {parts['kind']}", where
    state = "cannot be read" if Path(name).is_absolute() and Path(name).exists() else "does not exist"
    return f"the {parts['kind']} {name} {state}", where


def _absent_clips(stage: Usd.Stage) -> Iterator[Gap]:
    """Yield the value clips that do not exist, which USD does not report."""
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        for spec in prim.GetPrimStack() if prim.HasAuthoredMetadata("clips") else ():
            lost = [name for name in clip_names(spec) if not Path(resolve(spec.layer, name)).exists()]
            if lost:
                more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
                what = f"the value clip {lost[0]}{more} {'do' if more else 'does'} not exist"
                yield Gap(prim.GetPath(), what, f"{spec.layer.realPath} {spec.path}")


def _needed_by(stage: Usd.Stage, prim: str | None) -> set[Sdf.Path] | None:
    """Return the paths of a prim, its skeletons and their animations; None for all of the stage."""
    if prim is None or set(prim) & set("*?[") or not Sdf.Path.IsValidPathString(prim):
        return None
    found = set[Sdf.Path]()
    pending = [Sdf.Path(prim)]
    while pending:
        path = pending.pop()
        if path in found:
            continue
        found.add(path)
        at = stage.GetPrimAtPath(path)
        below = Usd.PrimRange(at, Usd.TraverseInstanceProxies()) if at else ()
        above = (stage.GetPrimAtPath(one) for one in path.GetParentPath().GetPrefixes())
        for one in (*(a for a in above if a), *below):
            bound = one.GetPropertiesInNamespace("skel")
            pending += [target for r in bound if isinstance(r, Usd.Relationship) for target in r.GetForwardedTargets()]
    return found


def _is_related(one: Sdf.Path, other: Sdf.Path) -> bool:
    """Whether one path is the other, above or below."""
    return one.HasPrefix(other) or other.HasPrefix(one)
