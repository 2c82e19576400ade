"""Views in a JupyterLab, as a user meets them: a pointer, keys, and a saved notebook."""

import json
import math
import re
import time

import pytest
from laboratory import chromium, command, jupyterlab, needed_programs, until, write_notebook

#: g = 1 + x on the unit cube has the pixels 1 + (column + 1/2) / width; a blob is off the middle.
CELLS = (
    """
import time
import numpy as np
import emitree
plane = emitree.view("1 + x", emitree.Canonical(), (8, 16), energy={"min": 1, "max": 3, "bins": 4})
plane
""",
    """
def blob(position, direction):
    time.sleep(0.01)
    return np.exp(-40 * ((position - [0.8, 0.0, 0.0]) ** 2).sum(axis=1))
camera = emitree.Orthographic(
    position=(3, 0, 0), target=(0, 0, 0), extent=(2.4, 2.4), near=0, far=6
)
turned = emitree.view(blob, camera, (48, 48), tolerance=1e-3)
turned
""",
    """
def fails(position, direction):
    raise ValueError("the table of rates ends at 3 keV")
emitree.view(fails, emitree.Canonical(), (8, 8))
""",
    """
from pathlib import Path
def waits(position, direction):
    while not Path("go").exists():
        time.sleep(0.01)
    return 1 + position[:, 0] * position[:, 1]
emitree.view(waits, emitree.Canonical(), (8, 8))
""",
)


class Notebook:
    """The page with the notebook, and the views in it."""

    def __init__(self, page, address, folder):
        self.page, self.address, self.folder = page, address, folder

    def open(self):
        self.page.get(f"{self.address}/lab/tree/view.ipynb?reset")
        until(
            lambda: self.script("return !!window.jupyterapp?.shell.currentWidget?.content?.widgets")
        )

    def run(self):
        status = "return jupyterapp.shell.currentWidget.sessionContext.session?.kernel?.status"
        until(lambda: self.script(status) == "idle")
        command(self.page, "notebook:run-all-cells")
        until(lambda: "is met" in self.text(0, ".message") and "is met" in self.text(1, ".message"))

    def end_kernels(self):
        """Ends the kernels, so that the notebook is opened as on another day."""
        self.page.execute_async_script(
            "const done = arguments[0]; jupyterapp.serviceManager.sessions.shutdownAll().then(done, done);"
        )
        self.page.get("about:blank")

    def script(self, text, *arguments):
        return self.page.execute_script(text, *arguments)

    def find(self, view, selector):
        """The first element of a view."""
        query = "return document.querySelectorAll('.emitree-view')[arguments[0]]?.querySelector(arguments[1])"
        return self.script(query, view, selector)

    def text(self, view, selector):
        query = "return document.querySelectorAll('.emitree-view')[arguments[0]]?.querySelector(arguments[1])?.textContent ?? ''"
        return self.script(query, view, selector)

    def focus(self, view):
        """The focus on the image."""
        self.script("arguments[0].focus()", self.find(view, "[tabindex='0']"))

    def press(self, *keys):
        from selenium.webdriver import ActionChains

        chain = ActionChains(self.page)
        for key in keys:
            chain.send_keys(key)
        chain.perform()

    def readout(self, view, pattern):
        """The text of the values at the cursor, once it has the pattern."""
        return until(lambda: re.search(pattern, self.text(view, "output")), 10)

    def press_button(self, view, number):
        buttons = "return document.querySelectorAll('.emitree-view')[arguments[0]].querySelectorAll('button')[arguments[1]]"
        self.script("arguments[0].click()", self.script(buttons, view, number))

    def is_hidden(self, view, selector):
        return self.script(
            "return arguments[0].checkVisibility() === false", self.find(view, selector)
        )


@pytest.fixture(scope="module")
def notebook(tmp_path_factory):
    programs = needed_programs()
    folder = tmp_path_factory.mktemp("laboratory")
    write_notebook(folder / "view.ipynb", *CELLS)
    with jupyterlab(folder) as address, chromium(folder, programs) as page:
        opened = Notebook(page, address, folder)
        opened.open()
        opened.run()
        yield opened


def peak(view, notebook):
    """x and y of the pixel with the largest value."""
    from selenium.webdriver import Keys

    notebook.press(Keys.HOME)
    time.sleep(0.1)
    found = notebook.readout(view, r"x (-?[\d.]+).*, y (-?[\d.]+).*:")
    return float(found[1]), float(found[2])


def test_values_and_spectrum_at_the_cursor(notebook):
    from selenium.webdriver import ActionChains

    pixels = notebook.find(0, "[tabindex='0']")
    # The middle is the border between columns 7 and 8.
    ActionChains(notebook.page).move_to_element(pixels).move_by_offset(3, -3).perform()
    notebook.readout(0, r"canonical x 0\.5313, canonical y 0\.5625: 3\.063")
    assert until(lambda: "4 bins" in (notebook.find(0, "svg").get_attribute("aria-label") or ""))
    label = notebook.find(0, "svg").get_attribute("aria-label")
    assert label.endswith(
        ("1.531 at 1 keV", "1.531 at 1.5 keV", "1.531 at 2 keV", "1.531 at 2.5 keV")
    )
    # The second canvas is the colour scale.
    label = notebook.find(0, "canvas").get_attribute("aria-label")
    assert label == "Radiance, 16 by 8 pixels, colours 0 to 3.94"


def test_keys(notebook):
    from selenium.webdriver import Keys

    cells = "return document.querySelectorAll('.jp-Notebook .jp-Cell').length"
    before = notebook.script(cells)
    notebook.focus(0)
    notebook.press(Keys.HOME)
    assert notebook.readout(0, r"canonical x 0\.9688.*: 3\.938")
    notebook.press(*[Keys.ARROW_LEFT] * 2)
    assert notebook.readout(0, r"canonical x 0\.8438.*: 3\.688")
    notebook.press("l")
    assert until(
        lambda: (
            notebook.script("return document.querySelector('.emitree-view select').value") == "log"
        )
    )
    notebook.press("e")
    assert until(lambda: "Evaluations" in notebook.text(0, "figure:nth-of-type(2)"))
    # JupyterLab would add a cell above or below for "a" and "b", and move to another for arrows.
    notebook.press("a", "b", Keys.ARROW_DOWN)
    assert notebook.readout(0, r"canonical y")
    assert notebook.script(cells) == before
    assert notebook.script("return document.activeElement.closest('.emitree-view') !== null")


def test_the_camera_turns_with_the_pointer_and_with_keys(notebook):
    from selenium.webdriver import ActionChains, Keys

    def is_at(*expected):
        return (
            max(abs(found - at) for found, at in zip(peak(1, notebook), expected, strict=True))
            < 0.06
        )

    notebook.focus(1)
    assert is_at(0.0, 0.0), "the blob is on the line of sight through the middle"
    pixels = notebook.find(1, "[tabindex='0']")
    width = notebook.script("return arguments[0].getBoundingClientRect().width", pixels)
    drag = ActionChains(notebook.page).move_to_element(pixels).click_and_hold()
    drag.move_by_offset(round(width / 12), 0).perform()
    until(lambda: re.search("tolerance 0.1[). ]", notebook.text(1, ".message")), 10)
    # In all a sixth of the width, for 30 degrees.
    ActionChains(notebook.page).move_by_offset(round(width / 12), 0).release().perform()
    until(lambda: is_at(0.4, 0.0) and "0.001 is met" in notebook.text(1, ".message"), 10)
    # Each key is 5 degrees: 30 degrees in all.
    up = ActionChains(notebook.page).key_down(Keys.SHIFT).send_keys(Keys.ARROW_UP * 6)
    up.key_up(Keys.SHIFT).perform()
    expected = (0.4, 0.8 * math.cos(math.radians(30)) * math.sin(math.radians(30)))
    until(lambda: is_at(*expected) and "0.001 is met" in notebook.text(1, ".message"), 10)


def test_it_stops_and_goes_on(notebook):
    until(lambda: notebook.text(3, ".message") == "Rendering: no evaluations yet.", 10)
    notebook.press_button(3, 0)
    until(lambda: notebook.text(3, ".message").startswith("Stopping, after the call"), 10)
    (notebook.folder / "go").touch()
    until(lambda: notebook.text(3, ".message").startswith("Stopped: "), 10)
    notebook.script("arguments[0].value = '-1'", notebook.find(3, "input"))
    notebook.press_button(3, 1)
    assert notebook.text(3, ".message") == "tolerance is -1: expected a number above 0"
    notebook.script("arguments[0].value = '1e-4'", notebook.find(3, "input"))
    notebook.press_button(3, 1)
    until(lambda: "0.0001 is met" in notebook.text(3, ".message"), 10)


def test_what_ends_a_rendering_is_told_in_the_view(notebook):
    message = "The rendering failed. ValueError: the table of rates ends at 3 keV"
    assert until(lambda: notebook.text(2, ".message") == message, 10)
    assert notebook.is_hidden(2, ".panels") and not notebook.is_hidden(2, "button")
    tracebacks = "return document.querySelectorAll('.jp-Notebook [data-mime-type*=stderr]').length"
    assert notebook.script(tracebacks) == 0


#: Whether each picture for readers without widgets is seen.
STILLS = """
return [...document.querySelectorAll('[class^=emitree-still] img')]
    .map((img) => img.checkVisibility() && img.naturalWidth > 0)
"""


def reopened(notebook):
    """Opens the notebook as on another day; whether JupyterLab finds its widgets."""
    notebook.end_kernels()
    notebook.open()
    lost = "return document.body.textContent.includes('widget: model not found')"
    until(lambda: notebook.text(1, ".message") or notebook.script(lost))
    return notebook.text(1, ".message") != ""


def test_a_saved_notebook_shows_the_last_picture(notebook):
    command(notebook.page, "docmanager:save")
    file = notebook.folder / "view.ipynb"

    def saved():
        content = json.loads(file.read_text(encoding="utf-8"))
        return content if "widgets" in content["metadata"] else None

    content = until(saved, 10)
    for cell in content["cells"][:2]:
        _, still = cell["outputs"]
        assert "<img" in "".join(still["data"]["text/html"]), "for readers that show no widgets"
    (states,) = content["metadata"]["widgets"].values()
    names = sorted(state["model_name"] for state in states["state"].values())
    assert names == ["AnyModel"] * 4 + ["LayoutModel"] * 4
    assert notebook.script(STILLS) == [False] * 3, "the views are shown"
    shown = notebook.text(1, ".message"), notebook.text(1, "output")
    # JupyterLab may look for widgets before it has read those of the notebook: its issue 15361.
    for _ in range(8):
        if reopened(notebook):
            break
        assert all(notebook.script(STILLS)), "the picture for readers without widgets"
    assert (notebook.text(1, ".message"), notebook.text(1, "output")) == shown
    assert notebook.is_hidden(1, "button"), "nothing renders without a kernel"
    painted = "const c = arguments[0]; return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v, i) => i % 4 === 0 && v > 200)"
    assert notebook.script(painted, notebook.find(1, "canvas"))
