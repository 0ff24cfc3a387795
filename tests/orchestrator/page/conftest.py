"""A project that is served, and a browser that shows it: once per worker."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from browsed import Page, served

from orchestrator.supplied import PROJECT


@pytest.fixture(scope="session")
def site(
    fmu_cache: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[SimpleNamespace]:
    """What `feeddrive new` makes, served."""
    folder = tmp_path_factory.mktemp("page") / "drive"
    shutil.copytree(PROJECT, folder)
    with served(folder) as address:
        host, _, token = address.removeprefix("http://").partition("/?token=")
        yield SimpleNamespace(folder=folder, address=address, host=host, token=token)


@pytest.fixture(scope="session")
def browser(site: SimpleNamespace, driver: Any) -> Page:
    """The page in headless Chromium."""
    page = Page(driver, f"http://{site.host}/")
    page.complaints()  # of pages that others have shown before
    driver.get(site.address)
    return page


@pytest.fixture(autouse=True)
def quiet(request: pytest.FixtureRequest) -> Iterator[None]:
    """The browser complains of nothing in a test that shows the page.

    What it says of pages that others have shown in between is theirs.
    """
    if "browser" not in request.fixturenames:
        yield
        return
    page = request.getfixturevalue("browser")
    if not page.driver.current_url.startswith(page.home):
        page.complaints()
    yield
    assert page.complaints() == []
