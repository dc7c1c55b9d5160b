"""Rules for value clips."""

from collections.abc import Iterator, Mapping, Sequence

from pxr import Sdf, Usd

from hairpipe.formats.usd.check.finding import Fault, Rule

METRICS = ("timeCodesPerSecond", "framesPerSecond", "metersPerUnit", "upAxis")
"""Metadata of layers that clips do not convert."""


def clip_manifest(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without a manifest: all of them are opened for the first value."""
    for name, clips in (prim.GetMetadata("clips") or {}).items():
        if not clips.get("manifestAssetPath"):
            yield Fault(str(prim.GetPath()), f"clip set {name} has no manifestAssetPath")


def clip_values(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without an attribute of the manifest; USD interpolates it from their neighbours."""
    api = Usd.ClipsAPI(prim)
    for name in prim.GetMetadata("clips") or {}:
        manifest = _open(prim, api.GetClipManifestAssetPath(name))
        root = Sdf.Path(api.GetClipPrimPath(name) or "/")
        promised = _attributes(manifest, root) if manifest else []
        for asset in api.ComputeClipAssetPaths(name):
            clip = _open(prim, asset)
            lacking = [p for p in promised if not clip.ListTimeSamplesForPath(p)] if clip else []
            if lacking:
                yield Fault(str(prim.GetPath()), f"{asset.path} has no samples of {lacking[0]}; {len(lacking)} such")


def clip_undeclared(prim: Usd.Prim) -> Iterator[Fault]:
    """Find attributes of clips that the manifest does not declare: they are never read."""
    api = Usd.ClipsAPI(prim)
    for name in prim.GetMetadata("clips") or {}:
        manifest = _open(prim, api.GetClipManifestAssetPath(name))
        path = api.GetClipPrimPath(name)
        if manifest is None:
            continue
        if not path or not manifest.GetPrimAtPath(path):
            yield Fault(str(prim.GetPath()), f"clip set {name} has the primPath {path!r}, which its manifest has not")
            continue
        for asset in api.ComputeClipAssetPaths(name):
            clip = _open(prim, asset)
            held = [p for p in _attributes(clip, Sdf.Path(path)) if clip.ListTimeSamplesForPath(p)] if clip else []
            lacking = [p for p in held if not manifest.GetAttributeAtPath(p)]
            if lacking:
                yield Fault(str(lacking[0]), f"{asset.path} has samples, but the manifest does not declare it")


def clip_times(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without a sample at a time at which they are played."""
    api = Usd.ClipsAPI(prim)
    for name in prim.GetMetadata("clips") or {}:
        files = api.ComputeClipAssetPaths(name)
        path = api.GetClipPrimPath(name)
        if api.GetClipTemplateAssetPath(name) or not path:
            continue
        active = [(time, int(index)) for time, index in api.GetClipActive(name) or []]
        unknown = [index for _, index in active if not 0 <= index < len(files)]
        idle = sorted(set(range(len(files))) - {index for _, index in active})
        if unknown or idle:
            what = f"activates clip {unknown[0]}" if unknown else f"never activates {files[idle[0]].path}"
            yield Fault(str(prim.GetPath()), f"clip set {name} {what}; there are {len(files)} clips")
        played = [(time, files[index]) for time, index in active if 0 <= index < len(files)]
        yield from _unsampled(prim, played, dict(api.GetClipTimes(name) or []))


def clip_rates(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips of another rate, unit or up axis than the stage, which USD does not convert."""
    api = Usd.ClipsAPI(prim)
    root = prim.GetStage().GetRootLayer().pseudoRoot
    for name in prim.GetMetadata("clips") or {}:
        unlike: dict[str, list[str]] = {}
        for asset in api.ComputeClipAssetPaths(name):
            clip = _open(prim, asset)
            if clip is None:
                continue
            for field in METRICS:
                own = clip.pseudoRoot.GetInfo(field) if clip.pseudoRoot.HasInfo(field) else None
                if own is not None and root.HasInfo(field) and own != root.GetInfo(field):
                    unlike.setdefault(f"{field} {own}, the stage {root.GetInfo(field)}", []).append(asset.path)
        for what, files in unlike.items():
            yield Fault(str(prim.GetPath()), f"{files[0]} has {what}; {len(files)} such clips")


def _unsampled(
    prim: Usd.Prim, played: Sequence[tuple[float, Sdf.AssetPath]], times: Mapping[float, float]
) -> Iterator[Fault]:
    """Find clips without a sample at their first played time."""
    wrong = []
    for time, file in played:
        clip = _open(prim, file)
        own = clip.ListAllTimeSamples() if clip else []
        wrong += [(time, file)] if own and times.get(time, time) not in own else []
    if wrong:
        time, file = wrong[0]
        message = f"{file.path} has no sample at {times.get(time, time):g}, when it is played; {len(wrong)} such"
        yield Fault(str(prim.GetPath()), message, time)


def _open(prim: Usd.Prim, asset: Sdf.AssetPath | None) -> Sdf.Layer | None:
    if not asset or not asset.path:
        return None
    resolved = asset.resolvedPath or prim.GetStage().GetRootLayer().ComputeAbsolutePath(asset.path)
    return Sdf.Layer.FindOrOpen(resolved)


def _attributes(layer: Sdf.Layer, root: Sdf.Path) -> list[Sdf.Path]:
    paths: list[Sdf.Path] = []
    layer.Traverse(root, paths.append)
    specs = [layer.GetAttributeAtPath(path) for path in paths if path.IsPropertyPath()]
    return [spec.path for spec in specs if spec and spec.variability == Sdf.VariabilityVarying]


RULES = (
    Rule("clip-manifest", "warning", clip_manifest),
    Rule("clip-values", "error", clip_values),
    Rule("clip-undeclared", "error", clip_undeclared),
    Rule("clip-times", "error", clip_times),
    Rule("clip-rates", "error", clip_rates),
)
