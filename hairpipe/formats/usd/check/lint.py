"""All rules for stages in one table, and their application with one frame of one shape in memory at a time."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pxr import Tf, Usd, UsdGeom

from hairpipe.formats.usd.check import (
    body_rules,
    clients,
    hair_rules,
    motion_rules,
    prim_rules,
    shape_rules,
    stage_rules,
)
from hairpipe.formats.usd.check.causes import cause_of
from hairpipe.formats.usd.check.scene import Finding, Rule, Subject, Track, find_scene
from hairpipe.formats.usd.stage import message_of, open_stage, usd_faults

RULES = (
    Rule("metres-per-unit", "error", "stage", stage_rules.metres_per_unit),
    Rule("frame-rate", "error", "stage", stage_rules.frame_rate),
    Rule("time-codes", "error", "stage", stage_rules.time_codes),
    Rule("composition", "error", "stage", stage_rules.composition),
    Rule("layer-units", "error", "stage", stage_rules.layer_units),
    Rule("hair-drawn", "error", "stage", stage_rules.hair_drawn),
    Rule("hair-drawn", "error", "stage", stage_rules.hair_selected),
    Rule("missing-file", "error", "asset", stage_rules.missing_file),
    Rule("broken-layer", "error", "asset", stage_rules.broken_layer),
    Rule("absolute-path", "warning", "asset", stage_rules.absolute_path),
    Rule("token", "error", "prim", prim_rules.token),
    Rule("dangling-target", "error", "prim", prim_rules.dangling_target),
    Rule("target-outside", "warning", "prim", prim_rules.target_outside),
    Rule("proxy-target", "warning", "prim", prim_rules.proxy_target),
    Rule("kind", "warning", "prim", prim_rules.kind),
    Rule("volume-fields", "error", "prim", prim_rules.volume_fields),
    Rule("shader-id", "error", "prim", prim_rules.shader_id),
    Rule("surface", "error", "prim", prim_rules.surface),
    Rule("shader-input", "error", "prim", prim_rules.shader_inputs),
    Rule("transform", "error", "prim", prim_rules.transform),
    Rule("ignored-transform", "error", "prim", prim_rules.ignored_transform),
    Rule("reset-transform", "warning", "prim", prim_rules.reset_transform),
    Rule("sample-gaps", "error", "prim", prim_rules.sample_gaps),
    Rule("sample-range", "warning", "prim", prim_rules.sample_range),
    Rule("sample-times", "error", "prim", prim_rules.sample_times),
    Rule("topology", "error", "prim", prim_rules.topology),
    Rule("frame-names", "warning", "prim", prim_rules.frame_names),
    Rule("clip-manifest", "warning", "prim", stage_rules.clip_manifest),
    Rule("clip-values", "error", "prim", stage_rules.clip_values),
    Rule("clip-undeclared", "error", "prim", stage_rules.clip_undeclared),
    Rule("clip-times", "error", "prim", stage_rules.clip_times),
    Rule("clip-rates", "error", "prim", stage_rules.clip_rates),
    Rule("variant", "error", "prim", stage_rules.variants),
    Rule("openvdb-grid", "error", "field", stage_rules.openvdb_grid),
    Rule("curve-counts", "error", "curves", hair_rules.curve_counts),
    Rule("curve-length", "error", "curves", hair_rules.curve_length),
    Rule("hair-basis", "warning", "curves", hair_rules.hair_basis),
    Rule("widths", "error", "curves", hair_rules.widths),
    Rule("taper", "warning", "curves", hair_rules.taper),
    Rule("widths-uneven", "warning", "curves", hair_rules.uneven_widths),
    Rule("two-of-one", "error", "curves", hair_rules.two_of_one),
    Rule("hair-ids", "error", "curves", hair_rules.hair_ids),
    Rule("lock-ids", "error", "curves", hair_rules.lock_ids),
    Rule("finite", "error", "shape", shape_rules.finite),
    Rule("doubles", "error", "shape", shape_rules.doubles),
    Rule("colours", "error", "shape", shape_rules.colours),
    Rule("mesh-faces", "error", "shape", shape_rules.mesh_faces),
    Rule("element-count", "error", "shape", shape_rules.element_count),
    Rule("hair-interpolation", "warning", "shape", shape_rules.hair_interpolation),
    Rule("extent", "error", "shape", shape_rules.extent),
    Rule("extent", "warning", "shape", shape_rules.extent_missing),
    Rule("defaults", "error", "shape", shape_rules.defaults),
    Rule("collapsed", "error", "frame", hair_rules.collapsed),
    Rule("spike", "warning", "frame", hair_rules.spikes),
    Rule("zigzag", "warning", "frame", hair_rules.zigzags),
    Rule("stretch", "error", "frame", hair_rules.stretch),
    Rule("widths-steady", "warning", "frame", hair_rules.widths_steady),
    Rule("rounded", "warning", "frame", hair_rules.rounded),
    Rule("precision", "warning", "frame", shape_rules.precision),
    Rule("default-prim", "error", "scene", stage_rules.hair_in_default),
    Rule("instanced-hair", "warning", "scene", stage_rules.instanced),
    Rule("doubled", "error", "scene", stage_rules.doubled),
    Rule("hair-transform", "error", "hair", prim_rules.hair_transform),
    Rule("size", "error", "scene", shape_rules.plausible_size),
    Rule("volume-size", "error", "scene", shape_rules.volume_size),
    Rule("precision", "warning", "hair", shape_rules.float_translate),
    Rule("rest", "error", "hair", hair_rules.rest),
    Rule("skin-range", "error", "hair", body_rules.skin_range),
    Rule("roots", "error", "hair", body_rules.roots_on_skin),
    Rule("root-uv", "warning", "hair", body_rules.root_uv),
    Rule("subdivision", "warning", "scene", body_rules.subdivision),
    Rule("normals", "error", "scene", body_rules.normals),
    Rule("up-axis", "warning", "scene", body_rules.up_axis),
    Rule("holes", "warning", "scene", body_rules.holes),
    Rule("body-drawn", "warning", "scene", body_rules.body_drawn),
    Rule("velocity-match", "warning", "scene", motion_rules.velocity_match),
    Rule("velocities", "warning", "hair", motion_rules.velocities_missing),
    Rule("acceleration-match", "warning", "hair", motion_rules.acceleration_match),
    Rule("strand-jumps", "error", "hair", motion_rules.strand_jumps),
    Rule("volume-still", "error", "scene", body_rules.volume_still),
    Rule("hair-material", "warning", "scene", prim_rules.hair_looks),
)


def lint(path: Path, inspect: stage_rules.Inspect | None = None, programs: Sequence[str] = ()) -> list[Finding]:
    """Return the faults of a stage, one finding for each rule and path; a stage of `usd/shot.py` has none.

    inspect   lists the grids of an OpenVDB file; without it only the existence of these files is checked
    programs  whose own rules are applied, too: of `clients.PROGRAMS`

    Raises BadInput if the file cannot be read at all.
    """
    groups: dict[tuple[str, str], list[Finding]] = {}
    with usd_faults(path):
        stage = open_stage(path)
        for finding in _lint_stage(stage, inspect, programs):
            groups.setdefault((finding.rule, finding.path), []).append(finding)
        merged = [replace(group[0], count=len(group)) for group in groups.values()]
        return [replace(finding, cause=cause_of(finding, stage)) for finding in merged]


def _lint_stage(opened: Usd.Stage, inspect: stage_rules.Inspect | None, programs: Sequence[str]) -> Iterator[Finding]:
    yield from _readable(stage_rules.validate(opened))
    yield from _apply("stage", opened)
    for asset in stage_rules.find_assets(opened):
        yield from _apply("asset", asset)
    for prim in opened.Traverse(Usd.TraverseInstanceProxies()):
        yield from _apply("prim", prim)
        yield from _apply("field", prim, inspect)
        is_hair = prim.IsA(UsdGeom.BasisCurves)
        for shape in Track(prim) if is_hair or prim.IsA(UsdGeom.Mesh) else ():
            yield from _apply("curves", shape) if is_hair else ()
            yield from _apply("shape", shape)
    scene = find_scene(opened)
    for track in scene.hair:
        for hair in track:
            yield from _apply("frame", track, hair) if hair.sound else ()
    for rule in (*RULES, *(rule for program in programs for rule in clients.rules_for(program))):
        if rule.subject == "scene":
            yield from _findings(rule, scene)
        elif rule.subject == "hair":
            for track in scene.hair:
                yield from _findings(rule, scene, track)


def _apply(name: Subject, *subject: Any) -> Iterator[Finding]:
    for rule in RULES:
        if rule.subject == name:
            yield from _findings(rule, *subject)


def _findings(rule: Rule, *subject: Any) -> Iterator[Finding]:
    faults = rule.faults(*subject)
    yield from _readable(Finding(rule.name, f.path, f.time, f.message, rule.severity) for f in faults)


def _readable(found: Iterator[Finding]) -> Iterator[Finding]:
    """Yield the findings; an unreadable file of the stage is a finding of its own."""
    try:
        yield from found
    except Tf.ErrorException as error:
        yield Finding("unreadable", "/", None, message_of(error), "error")
