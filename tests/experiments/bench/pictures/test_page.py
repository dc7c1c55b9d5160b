"""What opening a report takes is measured in a browser, and what is no report is refused."""

import shutil

import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.pictures.page import READY, measure_page

needs_browser = pytest.mark.skipif(shutil.which("chromium") is None, reason="no browser: Debian's package chromium")


@needs_browser
@pytest.mark.slow
def test_work_of_the_browser_is_counted(tmp_path):
    idle = "<script>document.body.dataset.state = 'ready'</script>"
    # In a function, whose variables are compiled; each turn needs the one before: about two seconds.
    work = "const work = () => { let x = 0; for (let i = 0; i < 2e9; i++) x = Math.imul(x, 31) + i | 0; return x };"
    busy = f"<script>{work} document.title = work();</script>"
    found = []
    for name, script in (("idle", idle), ("busy", busy + idle)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "index.html").write_text(f"<body>{script}</body>")
        found += measure_page(tmp_path / name).tables["page"]
    assert found[0]["files"] == 1 and found[0]["size [bytes]"] == len(f"<body>{idle}</body>")
    assert found[1]["opening [processor s]"] > found[0]["opening [processor s]"] + 0.7
    assert READY == 'data-state="ready"'


@needs_browser
@pytest.mark.slow
def test_a_page_that_does_not_become_ready_is_refused(tmp_path):
    (tmp_path / "index.html").write_text("<body>nothing</body>")
    with pytest.raises(BadInput, match="did not become ready"):
        measure_page(tmp_path)


def test_a_folder_without_a_report_is_refused(tmp_path):
    with pytest.raises(BadInput, match="holds no report"):
        measure_page(tmp_path)
