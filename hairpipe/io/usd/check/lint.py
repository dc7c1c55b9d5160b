"""All rules over a whole stage, one frame of one shape in memory at a time."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from pxr import Usd, UsdGeom

from hairpipe.io.usd.check import assets, clips, curves, motion, prims, shapes, stage
from hairpipe.io.usd.check.finding import Fault, Finding, Rule
from hairpipe.io.usd.check.snapshot import Snapshot
from hairpipe.io.usd.stage import open_stage, usd_faults

Found = Iterator[tuple[Rule, Fault]]


def lint(path: Path, inspect: assets.Inspect | None = None) -> list[Finding]:
    """Return what is wrong in a stage; nothing, if it is as `hairpipe.io.usd.shot` writes it.

    inspect  lists the grids of an OpenVDB file; without it these files are only looked for

    Raises BadInput if the file cannot be read at all.
    """
    with usd_faults(path):
        return summarise(_lint_stage(open_stage(path), inspect))


def summarise(found: Iterable[tuple[Rule, Fault]]) -> list[Finding]:
    """Return one finding for each rule and path, with the first message and how many there were."""
    groups: dict[tuple[Rule, str], list[Fault]] = {}
    for rule, fault in found:
        groups.setdefault((rule, fault.path), []).append(fault)
    return [
        Finding(rule.name, path, faults[0].time, faults[0].message, rule.severity, len(faults))
        for (rule, path), faults in groups.items()
    ]


def _lint_stage(opened: Usd.Stage, inspect: assets.Inspect | None) -> Found:
    for rule in stage.RULES:
        yield from rule.over(opened)
    for asset in assets.find_assets(opened):
        for rule in assets.RULES:
            yield from rule.over(asset)
    for prim in opened.Traverse(Usd.TraverseInstanceProxies()):
        for rule in (*prims.RULES, *motion.RULES, *clips.RULES):
            yield from rule.over(prim)
        for rule in assets.PRIM_RULES:
            yield from rule.over(prim, inspect)
        if prim.IsA(UsdGeom.BasisCurves) or prim.IsA(UsdGeom.Mesh):
            yield from _lint_shape(prim)


def _lint_shape(prim: Usd.Prim) -> Found:
    before: Snapshot | None = None
    rules = (*curves.RULES, *shapes.RULES) if prim.IsA(UsdGeom.BasisCurves) else shapes.RULES
    for time in _times(prim):
        now = Snapshot(prim, time)
        for rule in rules:
            yield from rule.over(now)
        for rule in motion.PAIR_RULES if before else ():
            yield from rule.over(before, now)
        before = now


def _times(prim: Usd.Prim) -> list[Usd.TimeCode]:
    samples = {time for attribute in prim.GetAttributes() for time in attribute.GetTimeSamples()}
    return [Usd.TimeCode(time) for time in sorted(samples)] or [Usd.TimeCode.Default()]
