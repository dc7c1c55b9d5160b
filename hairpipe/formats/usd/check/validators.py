"""Validators that OpenUSD ships, reported as findings: stage metadata, types, nesting, subsets, materials, skinning.

We have a rule of our own where OpenUSD has no validator, or where the docstring names its limitation. The validators
of UsdUtils are not run: they open every file that a stage names, and never return from a pipe.
"""

from collections.abc import Iterator

from pxr import Usd, UsdValidation

from hairpipe.formats.usd.check.finding import Finding
from hairpipe.formats.usd.check.prims import missing_targets
from hairpipe.formats.usd.stage import shortened

KEYWORDS = ["UsdCoreValidators", "UsdGeomValidators", "UsdShadeValidators", "UsdSkelValidators"]
OURS = {"CompositionError", "MissingShaderIdInRegistry"}
"""Errors that rules of ours describe better: `layers.composition`, `looks.shader_id`."""
RULES = {
    "AttributeTypeMismatch": "attribute-type",
    "InvalidMaterialCollection": "material-binding",
    "InvalidNestedGprims": "nested-gprim",
    "InvalidResourcePath": "material-binding",
    "InvalidSkelBindingAPIApply": "skin-binding",
    "MaterialBindingPropNotARel": "material-binding",
    "MismatchedPropertyType": "shader-input",
    "MissingDefaultPrim": "default-prim",
    "MissingMaterialBindingAPI": "material-binding",
    "MissingMetersPerUnitMetadata": "metres-per-unit",
    "MissingSkelBindingAPI": "skin-binding",
    "MissingUpAxisMetadata": "up-axis",
}
"""Names of findings by the name of the error; of any other error, its identifier is the name."""
MESSAGES = {
    "default-prim": "no defaultPrim that exists",
    "metres-per-unit": "no metersPerUnit",
    "nested-gprim": "is under another shape, and renderers may skip it; put the two side by side",
    "up-axis": "no upAxis",
}
"""Messages where the text of OpenUSD repeats the path of the file, or does not state the remedy."""


def validate(stage: Usd.Stage) -> Iterator[Finding]:
    """Run the validators on a stage, and yield their errors as findings, ordered by name and path.

    Raises Tf.ErrorException where a file of the stage cannot be read.
    """
    registry = UsdValidation.ValidationRegistry()
    names = [validator.name for validator in registry.GetValidatorMetadataForKeywords(KEYWORDS)]
    errors = UsdValidation.ValidationContext(registry.GetOrLoadValidatorsByName(names)).Validate(stage)
    findings = [_finding(error) for error in errors if error.GetName() not in OURS and _has_targets(error)]
    yield from sorted(findings, key=lambda f: (f.rule, f.path, f.message))  # threads report in any order


def _finding(error: UsdValidation.ValidationError) -> Finding:
    rule = RULES.get(error.GetName(), str(error.GetIdentifier()))
    site = error.GetSites()[0]
    if site.IsValidSpecInLayer():
        path = (site.GetPropertySpec() or site.GetPrimSpec()).path
    else:
        path = (site.GetProperty() if site.IsProperty() else site.GetPrim()).GetPath()
    message = MESSAGES.get(rule) or shortened(error.GetMessage())
    broken = error.GetType() == UsdValidation.ValidationErrorType.Error
    return Finding(rule, str(path), None, message, "error" if broken else "warning")


def _has_targets(error: UsdValidation.ValidationError) -> bool:
    """Return whether the targets of a property exist; otherwise `prims.dangling_target` reports it."""
    return not any(missing_targets(site.GetProperty()) for site in error.GetSites() if site.IsProperty())
