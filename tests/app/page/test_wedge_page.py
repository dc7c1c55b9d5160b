"""The variants of a wedge on the page: one selection of pictures, table and chart."""

import pytest

import hairpipe
from hairpipe.app.page.report import write_report

from .conftest import SHOT
from .live_page import do

WEDGE = """
[wedge.look]
axes.picture.red = [0.2, 0.8]
axes.hair.strands = [100, 200]
show = ["picture"]
measures = ["reach"]
"""


@pytest.fixture(scope="module")
def wedge_report(folder):
    """A report of a wedge of four variants, of which a run has computed all."""
    (folder / "wedge.toml").write_text(SHOT + WEDGE)
    shot = hairpipe.load(folder / "wedge.toml", cache=folder / "cache")
    run = shot.wedge("look").run("1-2", to=["picture", "reach"], jobs=1)
    write_report(shot, folder / "wedge_report", "1-2", wedge=shot.wedge("look"), run=run)
    return (folder / "wedge_report" / "index.html").as_uri()


def test_a_variant_is_selected_everywhere_at_once(shown, wedge_report):
    driver = shown(wedge_report)
    driver.execute_script("selectNode('picture')")
    assert len(driver.find_elements("css selector", ".sheet img")) == 4
    circles = driver.find_elements("css selector", ".pareto circle")
    low, low_many, high, high_many = (f"{one.get_attribute('cx')},{one.get_attribute('cy')}" for one in circles)
    curves = [line.get_attribute("points") for line in driver.find_elements("css selector", ".pareto polyline")]
    along_red, along_strands = [(low, high), (low_many, high_many)], [(low, low_many), (high, high_many)]
    assert curves == [" ".join(ends) for ends in along_red + along_strands]
    assert "--wedge look" in driver.find_element("css selector", "#verdict code").text
    plain = driver.execute_script("return pictureOf('picture', '')")
    driver.find_elements("css selector", ".sheet figure")[3].click()
    variant = driver.execute_script("return [app.variant, app.cell('picture').state, pictureOf('picture', '')]")
    assert variant[:2] == [3, "computed"] and variant[2] != plain
    selected = driver.find_elements("css selector", "#wedge .selected")
    assert [one.get_attribute("data-variant") for one in selected] == ["3", "3"]
    driver.execute_script("document.querySelector('.pin').click(); selectVariant(0)")
    assert driver.find_element("css selector", ".which").text.count("red=") == 2
    assert driver.execute_script("return document.body.dataset.errors") == "0"


def test_page_of_a_wedge_shows_its_run(shown, wedge_report):
    """It opens on a variant, with a verdict on the wedge; that on the graph file is another one."""
    driver = shown(wedge_report)
    word = "return [app.variant, document.querySelector('#verdict strong').innerText]"
    assert driver.execute_script(word) == [0, "8 to compute"], "the run was of two nodes"
    assert "frames 1-2 of 1-5" in driver.find_element("css selector", "#verdict").text
    driver.execute_script("selectVariant(-1)")
    assert driver.execute_script(word) == [-1, "complete at these frames"], "the graph was run before"
    assert "--wedge" not in driver.find_element("css selector", "#verdict code").text


def test_the_panel_shows_the_values_of_the_variant(shown, wedge_report):
    driver = shown(wedge_report)
    shown = lambda: driver.find_element("css selector", '#panel [data-setting="red"] span').text  # noqa: E731
    driver.execute_script("selectNode('picture'); selectVariant(0)")
    assert shown() == "0.2"
    driver.execute_script("selectVariant(3)")
    assert shown() == "0.8"
    driver.execute_script("selectVariant(-1)")
    assert shown() == "0.5", "that of the graph file"


def test_equal_strands_of_variants_are_shared(shown, wedge_report):
    driver = shown(wedge_report)
    script = "return app.wedge.states.map((nodes) => cellOf(nodes, 'hair', 1).outputs[''])"
    few, few_again, many, many_again = sorted(driver.execute_script(script))
    assert few == few_again != many == many_again


def test_hair_of_two_variants_is_compared(opened, wedge_report):
    driver = opened(wedge_report)
    do(driver, "selectNode('hair'); selectVariant(0)")
    driver.find_element("css selector", "#choices .pin").click()
    do(driver, "app.set({ channel: DIFFERENCE })")
    legends = []
    for variant in (1, 2):  # of other strands, and of the same ones in another colour of the picture
        do(driver, "selectVariant(arguments[0])", variant)
        do(driver, "return app.showing")
        legends.append(driver.find_element("id", "legend").text.split())
        assert driver.execute_script("return document.body.dataset.ghost") == "2"
        assert driver.find_element("id", "note").text.count("red=") == 2
    assert legends == [["the", "compared", "strands", "have", "other", "points"], ["0.00", "0.00", "mm"]]
    left = "app.wedge.states.length = app.wedge.variants.length = 1; selectVariant(0)"
    do(driver, f"app.set({{ pinned: null }}); selectVariant(3); app.set({{ pinned: pinSelected() }}); {left}")
    do(driver, "return app.showing")
    kept, _, selected = driver.find_element("id", "note").text.partition(" | ")
    assert kept.startswith("kept hair@") and kept.count("red=") == selected.count("red=") == 1
    assert driver.execute_script("return [document.body.dataset.errors, document.body.dataset.ghost]") == ["0", "2"]
