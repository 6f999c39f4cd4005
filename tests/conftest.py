# SPDX-License-Identifier: MIT
"""One thread for each worker, a time limit for each tier, and fixtures that several folders use."""

import os
import signal
from pathlib import Path

import pytest

# before any library is loaded: two workers with two threads each wait for each other on two cores
for _name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # as in the background of a shell: tests send it
    signal.signal(signal.SIGINT, signal.default_int_handler)

LIMITS = {"long": 3600, "slow": 1800, "": 300}  # s for a test of each tier, on a busy machine


# Folders whose tests load compiled loops, and the others, each in this order. Two workers begin at the start and in the
# middle (`make test`): one compiles the loops while the other runs tests without them, and finds them compiled later.
COMPILING = (
    "fe_engine",
    "verification",
    "validation",
    "pysprings/full_model",
    "pysprings/model",
    "pysprings/studies",
    "pysprings/core/test_threads",
)
LIGHT = (
    "pysprings/core",
    "fuzz",
    "pysprings/scene",
    "pysprings/springs",
    "pysprings/cli",
    "pysprings/macro",
    "pysprings/memory",
    "",
)
TESTS = Path(__file__).parent


def place_of(file: Path) -> int:
    """Return the place of a test file in the order of the folders."""
    name = file.relative_to(TESTS).as_posix()
    return next(place for place, folder in enumerate((*COMPILING, *LIGHT)) if name.startswith(folder))


@pytest.hookimpl(trylast=True)  # after tests of other tiers are left out
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put compiling tests first and others from the middle on; give every test its time limit (pytest-timeout)."""
    items.sort(key=lambda item: place_of(item.path))
    compiling = sum(place_of(item.path) < len(COMPILING) for item in items)
    middle = min(compiling, len(items) // 2)
    items[:] = items[:middle] + items[compiling:] + items[middle:compiling]
    if config.pluginmanager.hasplugin("timeout"):
        for item in items:
            tier = next(name for name in LIMITS if not name or item.get_closest_marker(name))
            item.add_marker(pytest.mark.timeout(LIMITS[tier]))


@pytest.fixture(autouse=True)
def _compiled_as_they_go(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have runs of tests compile as they go, so that the first of a kind does and prints the same as others."""
    monkeypatch.setattr("pysprings.core.jit.mark_of", lambda _kind: None)


@pytest.fixture(scope="session", autouse=True)
def _one_thread() -> None:
    """Run compiled loops on one thread; a test of several threads sets their number itself."""
    import numba

    numba.set_num_threads(1)


@pytest.fixture
def few_offered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have springs with memory that are not stored calibrated from few elements, in a tenth of the time."""
    from pysprings.memory import calibration
    from tests.support.space_springs import few

    monkeypatch.setattr(calibration, "candidates", few)


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    """The file of the tiny scene, in the folder of the test."""
    from tests.support import tiny

    return tiny.write(tiny.scene(), tmp_path / "caisson.toml")
