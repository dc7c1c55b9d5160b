"""A setting that is a number or a table of factors is changed the same by its name and by `.value`."""

from copy import deepcopy

import pytest

from hairpipe.engine.file.overrides import put
from hairpipe.errors import BadInput

TABLES = {
    "hair": {"length": {"value": 0.3, "map": "long"}, "drag": 8.0, "file": {"data": "a.obj"}, "locks": {"after": 3}}
}


def changed(target, value):
    tables = deepcopy(TABLES)
    put(tables, target, value)
    return tables["hair"]


def test_a_number_takes_the_place_of_the_value_and_other_factors_stay():
    assert changed("hair.length", 0.1) == changed("hair.length.value", 0.1)
    assert changed("hair.length", 0.1)["length"] == {"value": 0.1, "map": "long"}
    assert changed("hair.drag.value", 3.0)["drag"] == {"value": 3.0}
    assert changed("hair.drag.variation", 0.1)["drag"] == {"value": 8.0, "variation": 0.1}


def test_tables_files_and_the_absence_of_a_group_replace_what_is_there():
    assert changed("hair.length", {"value": 0.1})["length"] == {"value": 0.1}
    assert changed("hair.file", "b.obj")["file"] == "b.obj"
    assert changed("hair.locks", False)["locks"] is False


def test_a_group_that_is_absent_has_no_fields():
    with pytest.raises(BadInput, match=r"'locks' in 'hair\.locks\.after' is not a group"):
        put({"hair": {"locks": False}}, "hair.locks.after", 4)
