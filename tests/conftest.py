"""What all tests share: how hypothesis looks, what is slow, and a headless browser.

Nothing here, and no test, is bounded by a clock: a busy machine is slow, not wrong.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from fuzzy2.support import announcements

# The first call of a compiled kernel takes up to seconds on a fresh machine, and a busy machine is
# slow in making examples too. Neither is a property of the example at hand.
# Examples are the same in every run, so that a run fails for what has changed; the thorough profile
# looks for new ones.
settings.register_profile(
    "working",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    print_blob=True,
    derandomize=True,
)
settings.register_profile(
    "thorough", settings.get_profile("working"), max_examples=300, derandomize=False
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "working"))

# Workers of pytest-xdist share the cores; threads of BLAS on top take time from one another, and
# spin while they wait. Numpy is imported after this.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# What a terminal or a shell may have set, and what programs that are tested would heed.
for name in (
    "CLICOLOR_FORCE",
    "FORCE_COLOR",
    "MPLBACKEND",
    "NO_COLOR",
    "PYTHONIOENCODING",
    "PYTHONUNBUFFERED",
    "PYTHONWARNINGS",
    "TTY_COMPATIBLE",
    "TTY_INTERACTIVE",
):
    os.environ.pop(name, None)

# Nor is anybody told what is compiled on the way, which depends on what was run before.
announcements.TOLD = math.inf

CHROMIUM, DRIVER = Path("/usr/bin/chromium"), Path("/usr/bin/chromedriver")

RENDER_WITHOUT_A_SCREEN = (
    "--headless",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)

AS_LONG_AS_IT_TAKES = 24 * 3600
"""In place of the limits of browser and driver, some 30 s, which a busy machine needs at times [s].
"""


LONGEST = ("test_notebooks.py", "test_documentation.py", "test_docs.py")
"""Files to begin with, so that no worker is left with one of them at the end."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what needs the browser as slow, and begin with what takes longest."""
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("slow")
    items.sort(key=lambda item: item.path.name not in LONGEST)


@pytest.fixture(scope="session")
def browser() -> Iterator[webdriver.Chrome]:
    """Chromium with WebGL in software.

    Where there is none, the test is skipped, but fails in CI.
    """
    missing = [str(path) for path in (CHROMIUM, DRIVER) if not path.exists()]
    if missing:
        reason = (
            f"no browser: {' and '.join(missing)} not found (apt-get install chromium "
            "chromium-driver)"
        )
        pytest.fail(reason) if os.environ.get("CI") else pytest.skip(reason)
    options = webdriver.ChromeOptions()
    options.binary_location = str(CHROMIUM)
    for argument in RENDER_WITHOUT_A_SCREEN:
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(str(DRIVER)))
    driver.command_executor.client_config.timeout = AS_LONG_AS_IT_TAKES
    driver.set_script_timeout(AS_LONG_AS_IT_TAKES)
    driver.set_page_load_timeout(AS_LONG_AS_IT_TAKES)
    yield driver
    driver.quit()
