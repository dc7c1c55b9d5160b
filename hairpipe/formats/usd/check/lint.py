"""All rules for stages in one table, and their application with one frame of one shape in memory at a time."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from pxr import Tf, Usd, UsdGeom

from hairpipe.formats.usd.check import (
    body_rules,
    clients,
    file_rules,
    hair_rules,
    motion_rules,
    prim_rules,
    shape_rules,
    stage_rules,
)
from hairpipe.formats.usd.check.finding import Finding, Rule
from hairpipe.formats.usd.check.scene import Track, find_scene
from hairpipe.formats.usd.stage import message_of, open_stage, usd_faults

RULES: dict[str, tuple[Rule, ...]] = {
    "stage": (
        Rule("metres-per-unit", "error", stage_rules.metres_per_unit),
        Rule("frame-rate", "error", stage_rules.frame_rate),
        Rule("time-codes", "error", stage_rules.time_codes),
        Rule("composition", "error", stage_rules.composition),
        Rule("layer-units", "error", stage_rules.layer_units),
        Rule("hair-drawn", "error", stage_rules.hair_drawn),
        Rule("hair-drawn", "error", stage_rules.hair_selected),
    ),
    "asset": (
        Rule("missing-file", "error", file_rules.missing_file),
        Rule("broken-layer", "error", file_rules.broken_layer),
        Rule("absolute-path", "warning", file_rules.absolute_path),
    ),
    "prim": (
        Rule("token", "error", prim_rules.token),
        Rule("dangling-target", "error", prim_rules.dangling_target),
        Rule("target-outside", "warning", prim_rules.target_outside),
        Rule("proxy-target", "warning", prim_rules.proxy_target),
        Rule("kind", "warning", prim_rules.kind),
        Rule("volume-fields", "error", prim_rules.volume_fields),
        Rule("shader-id", "error", prim_rules.shader_id),
        Rule("surface", "error", prim_rules.surface),
        Rule("shader-input", "error", prim_rules.shader_inputs),
        Rule("transform", "error", prim_rules.transform),
        Rule("ignored-transform", "error", prim_rules.ignored_transform),
        Rule("reset-transform", "warning", prim_rules.reset_transform),
        Rule("sample-gaps", "error", prim_rules.sample_gaps),
        Rule("sample-range", "warning", prim_rules.sample_range),
        Rule("sample-times", "error", prim_rules.sample_times),
        Rule("topology", "error", prim_rules.topology),
        Rule("frame-names", "warning", prim_rules.frame_names),
        Rule("clip-manifest", "warning", file_rules.clip_manifest),
        Rule("clip-values", "error", file_rules.clip_values),
        Rule("clip-undeclared", "error", file_rules.clip_undeclared),
        Rule("clip-times", "error", file_rules.clip_times),
        Rule("clip-rates", "error", file_rules.clip_rates),
        Rule("variant", "error", stage_rules.variants),
    ),
    "field": (Rule("openvdb-grid", "error", file_rules.openvdb_grid),),
    "curves": (
        Rule("curve-counts", "error", hair_rules.curve_counts),
        Rule("curve-length", "error", hair_rules.curve_length),
        Rule("hair-basis", "warning", hair_rules.hair_basis),
        Rule("widths", "error", hair_rules.widths),
        Rule("taper", "warning", hair_rules.taper),
        Rule("widths-uneven", "warning", hair_rules.uneven_widths),
        Rule("two-of-one", "error", hair_rules.two_of_one),
        Rule("hair-ids", "error", hair_rules.hair_ids),
        Rule("lock-ids", "error", hair_rules.lock_ids),
    ),
    "shape": (
        Rule("finite", "error", shape_rules.finite),
        Rule("doubles", "error", shape_rules.doubles),
        Rule("colours", "error", shape_rules.colours),
        Rule("mesh-faces", "error", shape_rules.mesh_faces),
        Rule("element-count", "error", shape_rules.element_count),
        Rule("hair-interpolation", "warning", shape_rules.hair_interpolation),
        Rule("extent", "error", shape_rules.extent),
        Rule("extent", "warning", shape_rules.extent_missing),
        Rule("defaults", "error", shape_rules.defaults),
    ),
    "frame": (
        Rule("collapsed", "error", hair_rules.collapsed),
        Rule("spike", "warning", hair_rules.spikes),
        Rule("zigzag", "warning", hair_rules.zigzags),
        Rule("stretch", "error", hair_rules.stretch),
        Rule("widths-steady", "warning", hair_rules.widths_steady),
        Rule("rounded", "warning", hair_rules.rounded),
        Rule("precision", "warning", shape_rules.precision),
    ),
    "scene": (
        Rule("default-prim", "error", stage_rules.hair_in_default),
        Rule("instanced-hair", "warning", stage_rules.instanced),
        Rule("doubled", "error", stage_rules.doubled),
        Rule("hair-transform", "error", prim_rules.hair_transform),
        Rule("size", "error", shape_rules.plausible_size),
        Rule("volume-size", "error", shape_rules.volume_size),
        Rule("precision", "warning", shape_rules.float_translate),
        Rule("rest", "error", hair_rules.rest),
        Rule("skin-range", "error", body_rules.skin_range),
        Rule("roots", "error", body_rules.roots_on_skin),
        Rule("root-uv", "warning", body_rules.root_uv),
        Rule("subdivision", "warning", body_rules.subdivision),
        Rule("normals", "error", body_rules.normals),
        Rule("up-axis", "warning", body_rules.up_axis),
        Rule("holes", "warning", body_rules.holes),
        Rule("body-drawn", "warning", body_rules.body_drawn),
        Rule("velocity-match", "warning", motion_rules.velocity_match),
        Rule("velocities", "warning", motion_rules.velocities_missing),
        Rule("acceleration-match", "warning", motion_rules.acceleration_match),
        Rule("strand-jumps", "error", motion_rules.strand_jumps),
        Rule("volume-still", "error", body_rules.volume_still),
        Rule("hair-material", "warning", prim_rules.hair_looks),
    ),
}
"""Rules by their subject: the stage, a file that it names, a prim, a field of a volume, curves or any shape at one
time, hair at one time with its motion, and the visible shapes of the stage."""


def lint(path: Path, inspect: file_rules.Inspect | None = None, client: str | None = None) -> list[Finding]:
    """Return the faults of a stage, one finding for each rule and path; a stage of `usd/shot.py` has none.

    inspect  lists the grids of an OpenVDB file; without it only the existence of these files is checked
    client   program whose own rules are applied, too: one of `clients.CLIENTS`

    Raises BadInput if the file cannot be read at all.
    """
    groups: dict[tuple[str, str], list[Finding]] = {}
    with usd_faults(path):
        for finding in _lint_stage(open_stage(path), inspect, client):
            groups.setdefault((finding.rule, finding.path), []).append(finding)
    return [replace(group[0], count=len(group)) for group in groups.values()]


def _lint_stage(opened: Usd.Stage, inspect: file_rules.Inspect | None, client: str | None) -> Iterator[Finding]:
    yield from _readable(stage_rules.validate(opened))
    yield from _apply(RULES["stage"], opened)
    for asset in file_rules.find_assets(opened):
        yield from _apply(RULES["asset"], asset)
    for prim in opened.Traverse(Usd.TraverseInstanceProxies()):
        yield from _apply(RULES["prim"], prim)
        yield from _apply(RULES["field"], prim, inspect)
        is_hair = prim.IsA(UsdGeom.BasisCurves)
        for shape in Track(prim) if is_hair or prim.IsA(UsdGeom.Mesh) else ():
            yield from _apply((*RULES["curves"], *RULES["shape"]) if is_hair else RULES["shape"], shape)
    scene = find_scene(opened)
    for track in scene.hair:
        for hair in track:
            yield from _apply(RULES["frame"], track, hair)
    yield from _apply((*RULES["scene"], *(() if client is None else clients.rules_for(client))), scene)


def _apply(rules: Iterable[Rule], *subject: Any) -> Iterator[Finding]:
    for rule in rules:
        faults = rule.faults(*subject)
        yield from _readable(Finding(rule.name, f.path, f.time, f.message, rule.severity) for f in faults)


def _readable(found: Iterator[Finding]) -> Iterator[Finding]:
    """Yield the findings; an unreadable file of the stage is a finding of its own."""
    try:
        yield from found
    except Tf.ErrorException as error:
        yield Finding("unreadable", "/", None, message_of(error), "error")
