"""What hair is shown with: a body that is missing, hidden or not blurred, locks of other ids."""

from collections.abc import Callable

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, Vt

HAIR, BODY = "/shot/hair", "/shot/body"
Plant = Callable[[Usd.Stage], object]


def hide(stage: Usd.Stage, path: str = BODY) -> None:
    UsdGeom.Imageable(stage.GetPrimAtPath(path)).MakeInvisible()


def hide_in_a_stage_of_another_program(stage: Usd.Stage) -> None:
    stage.GetRootLayer().ClearCustomLayerData()
    UsdGeom.Imageable(stage.GetPrimAtPath(BODY)).CreateVisibilityAttr().Set("invisible", 1004)


def hide_beside_another_mesh(stage: Usd.Stage) -> None:
    Sdf.CopySpec(stage.GetRootLayer(), BODY, stage.GetRootLayer(), "/shot/prop")
    hide(stage)


def lock(stage: Usd.Stage, leaders: Callable[[np.ndarray], np.ndarray]) -> None:
    """Plant which hair each follows, of its ids."""
    ids = np.array(stage.GetAttributeAtPath(f"{HAIR}.primvars:hairId").Get())
    primvars = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(HAIR))
    followed = primvars.CreatePrimvar("lockId", Sdf.ValueTypeNames.IntArray, UsdGeom.Tokens.uniform)
    followed.Set(Vt.IntArray(leaders(ids).tolist()))


def reverse_ids_of_locks(stage: Usd.Stage) -> None:
    lock(stage, lambda ids: ids - (ids - 100) % 3)
    ids = stage.GetAttributeAtPath(f"{HAIR}.primvars:hairId")
    ids.Set(Vt.IntArray(list(ids.Get())[::-1]))


DEFECTS: dict[str, tuple[Plant, str, str]] = {
    "no body": (lambda s: s.RemovePrim(BODY), "body-drawn", BODY),
    "inactive": (lambda s: s.GetPrimAtPath(BODY).SetActive(False), "body-drawn", BODY),
    "invisible": (hide, "body-drawn", BODY),
    "invisible beside another mesh": (hide_beside_another_mesh, "body-drawn", BODY),
    "invisible from frame 4, of another program": (hide_in_a_stage_of_another_program, "body-drawn", BODY),
    "no velocities": (lambda s: s.GetPrimAtPath(BODY).RemoveProperty("velocities"), "velocities", f"{BODY}.velocities"),
    "ids reversed": (reverse_ids_of_locks, "lock-ids", f"{HAIR}.primvars:lockId"),
    "locks of no hair": (lambda s: lock(s, lambda ids: ids + 1), "lock-ids", f"{HAIR}.primvars:lockId"),
}


@pytest.mark.parametrize(("plant", "rule", "path"), DEFECTS.values(), ids=DEFECTS)
def test_names_the_defect_and_nothing_else(
    head: Usd.Stage, found: Callable, plant: Plant, rule: str, path: str
) -> None:
    plant(head)
    assert found(head) == [(rule, path)]


def test_silent_on_locks_and_on_a_hidden_scalp_inside_a_drawn_head(head: Usd.Stage, found: Callable) -> None:
    lock(head, lambda ids: ids - (ids - 100) % 3)
    Sdf.CopySpec(head.GetRootLayer(), BODY, head.GetRootLayer(), "/shot/scalp")
    hide(head, "/shot/scalp")
    assert found(head) == []
