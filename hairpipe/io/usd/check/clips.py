"""Rules for value clips."""

from collections.abc import Iterator

from pxr import Sdf, Usd

from hairpipe.io.usd.check.finding import Fault, Rule


def clip_manifest(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without a manifest, all of which have to be opened before the first value is known."""
    for name, clips in (prim.GetMetadata("clips") or {}).items():
        if not clips.get("manifestAssetPath"):
            yield Fault(str(prim.GetPath()), f"clip set {name} has no manifestAssetPath")


def clip_values(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips that do not have an attribute the manifest promises; USD fills it in from their neighbours."""
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
)
