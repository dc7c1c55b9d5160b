"""All rules applied to a stage, with one frame of one shape in memory at a time."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from pxr import Tf, Usd, UsdGeom

from hairpipe.formats.usd.check import (
    assets,
    body_drawn,
    body_rules,
    clients,
    clips,
    curve_rules,
    drawn,
    holes,
    layers,
    looks,
    motion,
    prims,
    shapes,
    size,
    skin,
    stage_metrics,
    strand_motion,
    strands,
    transforms,
    validators,
    velocity,
    volume_motion,
)
from hairpipe.formats.usd.check.finding import Finding, Rule
from hairpipe.formats.usd.check.scene import Track, find_scene
from hairpipe.formats.usd.stage import message_of, open_stage, usd_faults

STAGE = (*stage_metrics.RULES, *layers.RULES, *drawn.STAGE_RULES)
PRIM = (
    *prims.RULES,
    *looks.PRIM_RULES,
    *transforms.PRIM_RULES,
    *motion.RULES,
    *clips.RULES,
    *layers.PRIM_RULES,
)
FRAME = (*strands.FRAME_RULES, *size.FRAME_RULES)
SCENE = (
    *drawn.RULES,
    *transforms.RULES,
    *size.RULES,
    *strands.RULES,
    *skin.RULES,
    *body_rules.RULES,
    *holes.RULES,
    *body_drawn.RULES,
    *velocity.RULES,
    *strand_motion.RULES,
    *volume_motion.RULES,
    *looks.RULES,
)


def lint(path: Path, inspect: assets.Inspect | None = None, client: str | None = None) -> list[Finding]:
    """Return the faults of a stage; a stage of `hairpipe.formats.usd.shot` has none.

    inspect  lists the grids of an OpenVDB file; without it only the existence of these files is checked
    client   program whose own rules are applied, too: one of `clients.CLIENTS`

    Raises BadInput if the file cannot be read at all.
    """
    with usd_faults(path):
        return summarise(_lint_stage(open_stage(path), inspect, client))


def summarise(found: Iterable[Finding]) -> list[Finding]:
    """Return one finding for each rule and path, with the first message and the number of faults."""
    groups: dict[tuple[str, str], list[Finding]] = {}
    for finding in found:
        groups.setdefault((finding.rule, finding.path), []).append(finding)
    return [replace(group[0], count=len(group)) for group in groups.values()]


def _lint_stage(opened: Usd.Stage, inspect: assets.Inspect | None, client: str | None) -> Iterator[Finding]:
    yield from _readable(validators.validate(opened))
    yield from _apply(STAGE, opened)
    for asset in assets.find_assets(opened):
        yield from _apply(assets.RULES, asset)
    for prim in opened.Traverse(Usd.TraverseInstanceProxies()):
        yield from _apply(PRIM, prim)
        yield from _apply(assets.PRIM_RULES, prim, inspect)
        if prim.IsA(UsdGeom.BasisCurves) or prim.IsA(UsdGeom.Mesh):
            rules = (*curve_rules.RULES, *shapes.RULES) if prim.IsA(UsdGeom.BasisCurves) else shapes.RULES
            for shape in Track(prim):
                yield from _apply(rules, shape)
    scene = find_scene(opened)
    for track in scene.hair:
        for hair in track:
            yield from _apply(FRAME, track, hair)
    yield from _apply(SCENE if client is None else (*SCENE, *clients.rules_for(client)), scene)


def _apply(rules: Iterable[Rule], *subject: Any) -> Iterator[Finding]:
    """Apply rules to their subject."""
    for rule in rules:
        faults = rule.faults(*subject)
        yield from _readable(Finding(rule.name, f.path, f.time, f.message, rule.severity) for f in faults)


def _readable(found: Iterator[Finding]) -> Iterator[Finding]:
    """Yield the findings; an unreadable file of the stage is a finding of its own."""
    try:
        yield from found
    except Tf.ErrorException as error:
        yield Finding("unreadable", "/", None, message_of(error), "error")
