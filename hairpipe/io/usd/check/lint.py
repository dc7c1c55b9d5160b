"""All rules over a whole stage, one frame of one shape in memory at a time."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from pxr import Tf, Usd, UsdGeom

from hairpipe.io.usd.check import assets, clips, curves, motion, prims, shapes, stage
from hairpipe.io.usd.check.finding import Fault, Finding, Rule
from hairpipe.io.usd.check.snapshot import Snapshot
from hairpipe.io.usd.stage import open_stage, said, usd_faults

UNREADABLE = Rule("unreadable", "error", lambda: iter(()))  # broken by whatever the other rules cannot read
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
    yield from _apply(stage.RULES, opened)
    for asset in assets.find_assets(opened):
        yield from _apply(assets.RULES, asset)
    for prim in opened.Traverse(Usd.TraverseInstanceProxies()):
        yield from _apply((*prims.RULES, *motion.RULES, *clips.RULES), prim)
        yield from _apply(assets.PRIM_RULES, prim, inspect)
        if prim.IsA(UsdGeom.BasisCurves) or prim.IsA(UsdGeom.Mesh):
            yield from _lint_shape(prim)


def _lint_shape(prim: Usd.Prim) -> Found:
    before: Snapshot | None = None
    rules = (*curves.RULES, *shapes.RULES) if prim.IsA(UsdGeom.BasisCurves) else shapes.RULES
    for time in _times(prim):
        now = Snapshot(prim, time)
        yield from _apply(rules, now)
        yield from _apply(motion.PAIR_RULES, before, now) if before else ()
        before = now


def _apply(rules: Iterable[Rule], *subject: Any) -> Found:
    """Apply rules to what they look at; where a file of the stage breaks off, that is a fault of its own."""
    for rule in rules:
        try:
            yield from ((rule, fault) for fault in rule.faults(*subject))
        except Tf.ErrorException as error:
            yield UNREADABLE, Fault("/", said(error))


def _times(prim: Usd.Prim) -> list[Usd.TimeCode]:
    samples = {time for attribute in prim.GetAttributes() for time in attribute.GetTimeSamples()}
    return [Usd.TimeCode(time) for time in sorted(samples)] or [Usd.TimeCode.Default()]
