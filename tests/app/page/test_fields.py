"""Fields of settings in a real browser: each kind has its own, and commits one edit in plain TOML."""

import pytest

from hairpipe.app.api.draft import EMPTY, load_draft
from hairpipe.app.page.session import Session

from .live_page import Page, do, served

pytestmark = pytest.mark.slow
TEXT = (
    EMPTY
    + """
[head]
type = "make_bust"

[groom]
type = "grow_groom"
in.scalp = "head"
length = 0.25 # of the fringe
density.image = "paint/density.png"

[hair]
type = "simulate_hair"
in.groom = "groom"
material.diameter = { value = 8e-5, profile = [[0, 1], [1, 0.5]] }

[picture]
type = "preview"
in.hair = "hair"
eye = [0.6, 0.3333333333333333, 0.85]

[motion]
type = "load_motion"
in.rest = "head"
"""
)


@pytest.fixture(scope="module")
def draft(tmp_path_factory):
    """A session of the graph, and the address of its page: one for all tests, each of which undoes its edits."""
    from PIL import Image

    folder = tmp_path_factory.mktemp("fields")
    (folder / "paint").mkdir()
    Image.new("L", (4, 4), 128).save(folder / "paint" / "density.png")
    (folder / "walk.bvh").write_text("HIERARCHY")
    (folder / "walk.txt").write_text("no motion")
    session = Session(load_draft(str(folder / "fields.toml"), TEXT, cache=folder / "cache"))
    with served(session) as address:
        yield session, address


@pytest.fixture
def live(shown, draft):
    session, address = draft
    page = Page(shown(address), session)
    yield page
    page.undo_all()


def row(live, node, setting):
    do(live.driver, "app.node === arguments[0] || selectNode(arguments[0])", node)
    return live.find(f'[data-setting="{setting}"]')


def retype(live, field, text):
    field.click()
    field.send_keys(live.Keys.CONTROL, "a")
    field.send_keys(live.Keys.NULL, text, live.Keys.ENTER)


def test_a_slider_makes_one_edit_when_it_is_released(live):
    slider = row(live, "groom", "strands").find_element("css selector", "[type=range]")
    live.drag(slider, by=(20, 0))
    live.until(lambda: "strands" in live.tables["groom"])
    assert live.session._history.at == 1 and live.tables["groom"]["strands"] > 2500
    live.press("z", live.Keys.CONTROL)
    live.until(lambda: live.text == TEXT)


def test_a_number_may_leave_its_slider_but_not_its_bounds(live):
    field = row(live, "groom", "bend").find_element("css selector", "input")
    retype(live, field, "3")
    live.until(lambda: live.tables["groom"].get("bend") == 3)
    field = row(live, "groom", "bend").find_element("css selector", "input")
    retype(live, field, "-1")
    live.until(lambda: live.all("#panel .wrong"))
    assert "> 0" in live.find("#panel .wrong").text and live.tables["groom"]["bend"] == 3
    field = live.find('[data-setting="bend"] input')
    retype(live, field, live.Keys.DELETE)
    live.until(lambda: "bend" not in live.tables["groom"])


def test_a_number_opens_into_its_table(live):
    number = row(live, "groom", "length")
    assert not live.all('[data-setting="length.low"]')
    retype(live, number.find_element("css selector", "input"), "0.3")
    live.until(lambda: "\nlength = 0.3 # of the fringe\n" in live.text)
    live.find('[data-setting="length"] .opener').click()
    retype(live, live.find('[data-setting="length.variation"] input'), "0.1")
    live.until(lambda: "\nlength = { value = 0.3, variation = 0.1 } # of the fringe\n" in live.text)


def test_a_point_of_a_profile_is_dragged(live):
    row(live, "hair", "material.diameter").find_element("css selector", ".opener").click()
    live.drag(live.find('.profile [data-point="1"]'), by=(-30, -12))
    live.until(lambda: live.text != TEXT)
    assert live.session._history.at == 1
    (start, end) = live.tables["hair"]["material"]["diameter"]["profile"]
    assert start == [0, 1] and end[0] < 1 and end[1] > 0.5


def test_factors_of_groups_are_added_changed_and_taken_away(live):
    def groups():
        return live.tables["hair"]["material"]["diameter"].get("groups")

    def field(line, place):
        row(live, "hair", "material.diameter.groups")
        return live.all(".pair")[line].find_elements("css selector", "input")[place]

    row(live, "hair", "material.diameter").find_element("css selector", ".opener").click()
    retype(live, field(0, 0), "fringe")
    live.until(lambda: groups() == [["fringe", 1]])
    retype(live, field(0, 1), "0.5")
    live.until(lambda: groups() == [["fringe", 0.5]])
    retype(live, field(1, 0), 'tail "b"')
    live.until(lambda: groups() == [["fringe", 0.5], ['tail "b"', 1]])
    retype(live, field(0, 1), "much")
    live.until(lambda: live.all("#panel .wrong"))
    live.find('[data-setting="material.diameter.groups"] .pair .unset').click()
    live.until(lambda: groups() == [['tail "b"', 1]])
    live.find('[data-setting="material.diameter.groups"] .pair .unset').click()
    live.until(lambda: live.text == TEXT)


def test_vectors_choices_switches_and_colours(live):
    fields = row(live, "picture", "eye").find_elements("css selector", "input")
    retype(live, fields[0], "0.5")
    live.until(lambda: live.tables["picture"]["eye"] == [0.5, 1 / 3, 0.85])
    retype(live, row(live, "picture", "view").find_element("css selector", "select"), "side")
    live.until(lambda: live.tables["picture"].get("view") == "side")
    do(
        live.driver,
        """const colour = document.querySelector('[data-setting="colour"] [type=color]');
        colour.value = "#ff8000"; colour.dispatchEvent(new Event("change"));""",
    )
    live.until(lambda: live.tables["picture"].get("colour") == [1, 0.502, 0])


def test_a_file_is_chosen_in_the_project(live):
    row(live, "motion", "file").find_element("css selector", "button").click()
    live.until(lambda: live.all("#popup li"))
    names = [one.get_attribute("data-value") for one in live.all("#popup li")]
    assert names[-1] == "walk.bvh" and "walk.txt" not in names and ".." not in names
    live.choose("walk")
    live.until(lambda: live.tables["motion"].get("file") == "walk.bvh")


def test_an_image_is_shown(live):
    do(live.driver, "selectNode('groom')")
    script = "return document.querySelector('[data-setting=\"density.image\"] img')?.naturalWidth"
    live.until(lambda: live.driver.execute_script(script) == 4)


RANGES = """const done = arguments[0], out = [];
    const walk = (fields, name) => fields.forEach((field) => {
        if (/^a (whole )?number/.test(field.kind) && !field.group.length) {
            const range = softRange(field, field.default), { low, high, open } = boundsOf(field.range);
            const value = typeof field.default === "number" ? field.default : null;
            const shown = value === null ? null : valueAt(range, slideOf(range, value));
            const ends = [valueAt(range, 0), valueAt(range, STEPS)];
            out.push({ name: `${name}.${field.name}`, low, high, open, value, shown, ends });
        }
        walk(field.group, `${name}.${field.name}`);
    });
    hairpipe.plain("catalogue").then(({ types }) => {
        types.forEach((type) => walk(type.settings, type.name));
        done(out);
    });"""


def test_a_soft_range_holds_the_default_within_the_bounds(live):
    found = live.driver.execute_async_script(RANGES)
    assert len(found) > 150
    for one in found:
        first, last = one["ends"]
        bounds = [-1e300 if one["low"] is None else one["low"], 1e300 if one["high"] is None else one["high"]]
        assert bounds[0] <= first < last <= bounds[1], one
        assert first > bounds[0] or not one["open"], one
        if one["value"] is not None:
            assert first <= one["value"] <= last or one["open"], one
            assert abs(one["shown"] - one["value"]) <= max(0.05 * abs(one["value"]), (last - first) / 300), one
