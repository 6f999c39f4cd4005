# SPDX-License-Identifier: MIT
"""Compiled loops between processes: made anew when any source changes, wherever they are kept; none needs a place."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fe_engine import compiled

ROOT = Path(__file__).parents[2]

# A package as the engine is one: a loop in one file, the law that is compiled into it in another.
LAW = """
from pathlib import Path
from fe_engine.compiled import digest, cached
HOME = Path(__file__).parent

def njit(function):
    return cached(function, HOME, digest(HOME, HOME.rglob("*.py")))

@njit
def law(x):
    return FACTOR * x
"""
LOOP = """
from small.law import law, njit

@njit
def loop(n):
    total = 0.0
    for i in range(n):
        total += law(i)
    return total

if __name__ == "__main__":
    import os
    from small.loop import loop
    print(loop(4))
    print("compiled" if sum(loop.stats.cache_misses.values()) else "kept")
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package in a folder of its own, whose law has the factor 2."""
    home = tmp_path / "src" / "small"
    home.mkdir(parents=True)
    (home / "__init__.py").write_text("")
    (home / "loop.py").write_text(LOOP)
    write_law(home, 2.0)
    return home


def write_law(home: Path, factor: float) -> None:
    (home / "law.py").write_text(LAW.replace("FACTOR", str(factor)))


def call(home: Path, **setting: str) -> tuple[list[str], str]:
    """Call the loop in a process of its own; what it prints, and what it warns of."""
    env = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    env |= {"PYTHONPATH": os.pathsep.join([str(home.parent), str(ROOT)]), "NUMBA_CPU_NAME": "generic", **setting}
    done = subprocess.run(
        [sys.executable, "-m", "small.loop"], env=env, cwd=home.parent, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.split(), done.stderr


def blocked(folder: Path) -> str:
    """A place below a file: nobody can make a folder there, the superuser neither."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.write_text("")
    return str(folder / "cache")


@pytest.mark.slow
def test_a_changed_law_is_compiled_into_loops_of_other_files(package: Path, tmp_path: Path) -> None:
    """Issue: with NUMBA_CACHE_DIR set, or the package not writable, the old law lived on."""
    (package / "__pycache__").write_text("")  # not a folder: the package cannot be written to
    env = {"PYTHONDONTWRITEBYTECODE": "1"}
    places = [{"NUMBA_CACHE_DIR": str(tmp_path / "given")}, {"XDG_CACHE_HOME": str(tmp_path / "cache")}]
    for place in places:
        for factor, expected in ((2.0, ["12.0", "compiled"]), (3.0, ["18.0", "compiled"]), (2.0, ["12.0", "kept"])):
            write_law(package, factor)
            assert call(package, **env, **place) == (expected, "")
    assert [len(list((tmp_path / name).rglob("small-*"))) for name in ("given", "cache")] == [2, 2]


@pytest.mark.slow
def test_a_date_in_the_future_costs_nothing(package: Path) -> None:
    assert call(package)[0] == ["12.0", "compiled"]
    (folder,) = (package / "__pycache__").glob("small-*")
    before = sorted(folder.rglob("*.nb?"))
    assert before
    later = time.time() + 86_400.0 * 365
    os.utime(package / "law.py", (later, later))
    assert call(package)[0] == ["12.0", "kept"]
    assert sorted(folder.rglob("*.nb?")) == before


@pytest.mark.slow
def test_a_place_that_cannot_be_written_to_is_named_and_the_loop_runs(package: Path, tmp_path: Path) -> None:
    """Issue: an unwritable NUMBA_CACHE_DIR, or package and home, ended every command as a bug."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    given = blocked(tmp_path / "file")
    for _ in range(2):
        printed, said = call(package, NUMBA_CACHE_DIR=given, TMPDIR=str(temporary))
        assert said.count("Warning") == 1
        assert f"compiled loops are kept in {temporary}" in said and given in said
    assert printed == ["12.0", "kept"]
    (private,) = temporary.iterdir()
    if os.name != "nt":
        assert private.stat().st_mode & 0o777 == 0o700
        private.chmod(0o777)  # somebody else could put code there
        printed, said = call(package, NUMBA_CACHE_DIR=given, TMPDIR=str(temporary))
        assert printed == ["12.0", "compiled"]
        assert said.count("Warning") == 1 and "compiled loops are not kept" in said


def test_all_packages_together_warn_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled.numba.config, "CACHE_DIR", "")
    cache = Path(blocked(tmp_path / "file"))
    monkeypatch.setattr(compiled, "user_cache", lambda: cache)
    monkeypatch.setattr(compiled, "private_temporary", lambda: None)
    compiled.warn_once.cache_clear()
    with pytest.warns(RuntimeWarning, match="not kept: .*; neither the package nor the user's cache can be") as noted:
        for name in ("one", "two"):
            home = tmp_path / name
            blocked(home / "__pycache__")
            assert compiled.folder_of(home, "0" * 64) is None
    assert len(noted) == 1
    compiled.warn_once.cache_clear()


def test_usual_places_come_first(tmp_path: Path) -> None:
    good, last, bad = tmp_path / "good", tmp_path / "last", Path(blocked(tmp_path / "file"))
    assert compiled.choose("x", [bad, good], last) == (good / "x", [])
    assert compiled.choose("x", [bad], last) == (last / "x", [bad])
    assert compiled.choose("x", [bad], None) == (None, [bad])
    assert compiled.choose("x", [bad], bad) == (None, [bad])


def test_a_disk_that_takes_no_byte_is_no_place(tmp_path: Path) -> None:
    resource = pytest.importorskip("resource")
    signal = pytest.importorskip("signal")
    before, handler = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, before[1]))
    try:
        ready = compiled.prepare(tmp_path / "full")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    assert not ready
    assert compiled.prepare(tmp_path / "full")


def test_loops_of_other_sources_go_when_long_unused(tmp_path: Path) -> None:
    def folder(name: str, days: float) -> Path:
        made = tmp_path / name
        made.mkdir()
        (made / "loop.nbc").write_text("")
        then = time.time() - 86_400.0 * days
        os.utime(made, (then, then))
        return made

    gone = folder("small-" + "0" * 16, compiled.UNUSED_DAYS + 1)
    stay = [
        folder("small-" + "1" * 16, compiled.UNUSED_DAYS - 1),  # another version that still runs
        folder("other-" + "0" * 16, 1000),
        folder("small-" + "0" * 15, 1000),
        folder("small-something-of-yours", 1000),
    ]
    target = folder("target", 1000)
    (tmp_path / ("small-" + "2" * 16)).symlink_to(target)
    assert compiled.prepare(tmp_path / ("small-" + "f" * 16))
    assert not gone.exists()
    assert all((place / "loop.nbc").exists() for place in [*stay, target])


def test_a_start_marks_the_loops_as_used(tmp_path: Path) -> None:
    folder = tmp_path / "small-0"
    assert compiled.prepare(folder)
    os.utime(folder, (0.0, 0.0))
    assert compiled.prepare(folder)
    assert folder.stat().st_mtime > time.time() - 3600.0


def test_the_digest_has_every_source_of_the_engine(tmp_path: Path) -> None:
    home = tmp_path / "fe_engine"
    shutil.copytree(compiled.HOME, home, ignore=shutil.ignore_patterns("__pycache__"))
    sources = sorted(home.rglob("*.py"))
    assert len(sources) > 20
    whole = compiled.digest(home, sources)
    assert whole == compiled.engine_digest()
    for source in sources:
        text = source.read_text(encoding="utf-8")
        source.write_text(text + "#\n", encoding="utf-8")
        assert compiled.digest(home, home.rglob("*.py")) != whole, source
        source.write_text(text, encoding="utf-8")
    sources[0].rename(home / "renamed.py")
    assert compiled.digest(home, home.rglob("*.py")) != whole


def test_nothing_is_kept_in_another_way() -> None:
    """Each compiled function of the project goes through `kept`: Numba's own cache has no digest of other files."""
    other = re.compile(r"cache\s*=\s*True|\b(?:nb|numba)\.(?:njit|jit|vectorize|guvectorize|cfunc|stencil)\b")
    sources = [path for package in ("fe_engine", "pysprings") for path in (ROOT / package).rglob("*.py")]
    assert len(sources) > 100
    found = [path.name for path in sources if other.search(path.read_text(encoding="utf-8"))]
    assert found == ["compiled.py"]


def test_jitted_files_of_the_tool_stand_alone() -> None:
    """`pysprings.core.jit.jitted` has the digest of one file: what is compiled from another would be missing in it."""
    jitted = [
        path
        for path in (ROOT / "pysprings").rglob("*.py")
        if re.search(r"^@jitted\b", path.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    assert jitted
    types = (ROOT / "pysprings/core/arrays.py").read_text(encoding="utf-8")
    assert not re.search(r"\b(def|class|lambda)\b", types)  # nothing in it can be compiled
    for path in jitted:
        text = path.read_text(encoding="utf-8")
        imported = re.findall(r"^\s*(?:from|import) ((?:pysprings|fe_engine)\S*)", text, re.MULTILINE)
        assert sorted({name.rpartition(".")[2] for name in imported} - {"arrays"}) == ["jit"], path
