"""JupyterLab on loopback, and a headless Chromium that has no other network."""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest

import emitree

#: How long JupyterLab, a page or a picture may take [s].
PATIENCE_S = 60

_BROWSERS = ("google-chrome", "google-chrome-stable", "chromium", "chromium-browser")


def needed_programs():
    """The browser and its driver; without them, or without JupyterLab, the test is skipped."""
    for module in ("anywidget", "jupyterlab", "selenium"):
        pytest.importorskip(module)
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    driver = shutil.which("chromedriver")
    if browser is None or driver is None:
        missing = "chromedriver" if browser else "Chromium or Chrome"
        pytest.skip(f"{missing} is missing: expected it on the path")
    return browser, driver


@contextmanager
def jupyterlab(folder):
    """The address of a JupyterLab with the notebooks of a folder, which gives commands to pages."""
    folder = Path(folder)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    own = {
        f"JUPYTER_{name}_DIR": str(folder / ".jupyter" / name.lower())
        for name in ("CONFIG", "DATA", "RUNTIME")
    }
    environment = os.environ | own | {
        "HOME": str(folder),
        "PYTHONPATH": str(Path(emitree.__file__).parents[1]),
        "IPYTHONDIR": str(folder / ".ipython"),
        "JUPYTERLAB_SETTINGS_DIR": str(folder / ".jupyter" / "settings"),
        "JUPYTERLAB_WORKSPACES_DIR": str(folder / ".jupyter" / "workspaces"),
    }  # fmt: skip
    options = {
        "ServerApp.ip": "127.0.0.1",
        "ServerApp.port": port,
        "ServerApp.port_retries": 0,
        "ServerApp.root_dir": str(folder),
        "ServerApp.open_browser": False,
        "ServerApp.allow_root": True,
        "IdentityProvider.token": "",
        "LabApp.expose_app_in_browser": True,
        "LabApp.news_url": "",
        "LabApp.check_for_updates_class": "jupyterlab.NeverCheckForUpdate",
        "LabApp.extension_manager": "readonly",
    }
    # It asks whether it may load news.
    without = {"disabledExtensions": {"@jupyterlab/apputils-extension:announcements": True}}
    settings = folder / ".jupyter" / "config" / "labconfig" / "page_config.json"
    settings.parent.mkdir(parents=True, exist_ok=True)
    settings.write_text(json.dumps(without), encoding="utf-8")
    given = [f"--{name}={value}" for name, value in options.items()]
    with open(folder / "jupyterlab.log", "w", encoding="utf-8") as log:
        server = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", *given],
            cwd=folder, env=environment, stdout=log, stderr=log,
        )  # fmt: skip
        try:
            address = f"http://127.0.0.1:{port}"
            until(lambda: _answers(f"{address}/api/status", server))
            yield address
        finally:
            server.terminate()
            try:
                server.wait(10)
            except subprocess.TimeoutExpired:
                server.kill()
                server.wait()


def _answers(address, server):
    assert server.poll() is None, "JupyterLab ended: see jupyterlab.log"
    try:
        with urllib.request.urlopen(address, timeout=5) as answer:
            return answer.status == 200
    except OSError:
        return False


@contextmanager
def chromium(folder, programs):
    """A browser, with a profile of its own in the folder."""
    from selenium import webdriver

    browser, driver = programs
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for argument in (
        "headless",
        "no-sandbox",
        "disable-gpu",
        "disable-quic",
        "disable-dev-shm-usage",
        "no-first-run",
        "disable-background-networking",
        "disable-component-update",
        "disable-sync",
        "window-size=1280,1000",
        f"user-data-dir={Path(folder) / 'profile'}",
        # All that a view needs is in the package.
        "host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
    ):
        options.add_argument(f"--{argument}")
    service = webdriver.ChromeService(executable_path=driver)
    page = webdriver.Chrome(options=options, service=service)
    try:
        yield page
    finally:
        page.quit()


def until(condition, patience_s=PATIENCE_S):
    """What a condition returns, once it is true."""
    end_s = time.monotonic() + patience_s
    while time.monotonic() < end_s:
        found = condition()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"not within {patience_s} s: {condition}")


def write_notebook(path, *cells):
    """A notebook of code cells."""
    made = [
        {"cell_type": "code", "id": f"cell-{number}", "metadata": {}, "outputs": [],
         "execution_count": None, "source": source}
        for number, source in enumerate(cells)
    ]  # fmt: skip
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    notebook = {"cells": made, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    Path(path).write_text(json.dumps(notebook), encoding="utf-8")


def command(page, name, **arguments):
    """Runs a command of JupyterLab, and waits for its end."""
    page.set_script_timeout(PATIENCE_S)
    page.execute_async_script(
        "const [name, given, done] = arguments;"
        "window.jupyterapp.commands.execute(name, given).then(() => done(), () => done());",
        name,
        arguments,
    )
