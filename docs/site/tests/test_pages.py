"""The pages of a small repository."""

import ast
import re
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import check
import pages
from markdown import parsed, slug, with_links

GUIDE = """# Guide

Read [units](#units), [`[[a]]`](other.md#part) and [a file](data.txt).

## Units

```toml
# no heading, and [no link](nowhere.md)
```

### `[unit]`: of g

Text.

## Rest
"""


@pytest.fixture
def repository(tmp_path):
    (tmp_path / "site").mkdir()
    (tmp_path / "guide.md").write_text(GUIDE, encoding="utf-8")
    (tmp_path / "other.md").write_text("# Other\n\n## Part\n", encoding="utf-8")
    (tmp_path / "data.txt").write_text("1\n", encoding="utf-8")
    return tmp_path


def written(repository, **texts):
    for name, text in texts.items():
        (repository / "site" / f"{name}.md").write_text(text, encoding="utf-8")
    defects = pages.write(repository, repository / "site", repository / "out")
    return defects, {
        file.stem: file.read_text(encoding="utf-8") for file in (repository / "out").glob("*.md")
    }


@pytest.fixture(autouse=True)
def no_notebooks(monkeypatch):
    monkeypatch.setattr(pages, "NOTEBOOKS", {})


def test_anchors_are_those_of_code_hosts():
    assert slug("`[unit]`: of g") == "unit-of-g"
    assert slug("Where g jumps, and [why](a.md)") == "where-g-jumps-and-why"
    anchors = [section.anchor for section in parsed("# A\n## B\n## B\n").all()]
    assert anchors == ["a", "b", "b-1"]


def test_links_in_code_are_text():
    text = "[a](b.md)\n```\n[c](d.md)\n```\n"
    assert with_links(text, lambda _: None) == "a\n```\n[c](d.md)\n```\n"


def test_a_document_is_split_and_its_links_lead_to_pages(repository):
    defects, made = written(
        repository,
        index="<!-- include guide.md -->\n",
        units="<!-- include guide.md#units titled All units -->\n",
        other="<!-- include other.md -->\n",
    )
    assert defects == []
    assert "(guide--units)=\n# All units\n" in made["units"]
    assert "## `[unit]`: of g\n" in made["units"]
    assert "[no link](nowhere.md)" in made["units"]
    assert "Units" not in made["index"] and "## Rest" in made["index"]
    assert "[units](#guide--units), [`[[a]]`](#other--part)" in made["index"]
    assert "[a file](/files/data.txt)" in made["index"]
    assert (repository / "out/files/data.txt").read_text(encoding="utf-8") == "1\n"


@pytest.mark.parametrize(
    ("guide", "index", "defect"),
    [
        (
            "# Guide\n[a](no.md)\n",
            "<!-- include guide.md -->\n",
            "guide.md: the link to no.md leads to nothing",
        ),
        (
            "# Guide\n[a](#no)\n",
            "<!-- include guide.md -->\n",
            "guide.md: the link to #no leads to no heading",
        ),
        (
            "# Guide\n",
            "<!-- include guide.md#no -->\n",
            "guide.md#no: there is no such section",
        ),
        ("# Guide\n", "<!-- include no.md -->\n", "no.md: there is no such document"),
        (
            "# Guide\n[a](#b)\n## B\n",
            "<!-- include guide.md -->\n<!-- omit guide.md#b -->\n",
            "guide.md: the link to #b leads to a section that is on no page",
        ),
        (
            "# Guide\n## B\n## C\n",
            "<!-- include guide.md#b -->\n",
            "guide.md#c is on no page",
        ),
    ],
)
def test_what_is_missing_is_named(repository, guide, index, defect):
    (repository / "guide.md").write_text(guide, encoding="utf-8")
    assert written(repository, index=index)[0] == [defect]


def test_the_built_site_is_checked(tmp_path):
    (tmp_path / "a.html").write_text(
        '<p id="here"><a href="#here"></a><a href="b.html"></a><a href="a.html#no"></a>'
        f'<script src="https://example.org/x.js"></script>{check.ROOT}/docs',
        encoding="utf-8",
    )
    assert check.defects(tmp_path) == [
        f"a.html: shows a path in {check.ROOT}",
        "a.html: loads https://example.org/x.js",
        "a.html: a.html#no leads to no anchor",
        "a.html: b.html leads to nothing",
    ]


def test_the_reference_of_python_has_all_public_names():
    package = pages.ROOT / "python/src/emitree/__init__.py"
    assigned = {
        statement.targets[0].id: statement.value
        for statement in ast.parse(package.read_text(encoding="utf-8")).body
        if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name)
    }
    public = set(ast.literal_eval(assigned["__all__"])) - {"Mesh", "__version__"}
    page = (pages.SITE / "reference/python/index.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^   (\w+)$", page, re.MULTILINE)) == public
