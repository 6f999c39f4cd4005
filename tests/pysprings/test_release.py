# SPDX-License-Identifier: MIT
"""The release command, on a small repository of its own."""

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from pysprings import load_scene
from tests.support.place import ROOT
from tools import release, wheel_check

FILES = {
    "pysprings/core/version.py": '__version__ = "0.9.0"\n',
    "CITATION.cff": "cff-version: 1.2.0\nversion: 0.9.0\nlicense: MIT\n",
    "recipe/recipe.yaml": 'context:\n  version: "0.9.0"\n  python_min: "3.11"\n',
    "CHANGELOG.md": "# Changelog\n\n## [Unreleased]\n\n### Added\n\n- A thing.\n\n## [0.9.0] - 2026-01-01\n",
}


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    for words in (
        ["init", "--quiet"], ["config", "user.name", "a"], ["config", "user.email", "a@b.example"],
        ["config", "core.hooksPath", "none"], ["add", "."], ["commit", "--quiet", "-m", "x"],
    ):  # fmt: skip
        subprocess.run(["git", *words], cwd=tmp_path, check=True)
    return tmp_path


def texts(root: Path) -> dict[str, str]:
    return {name: (root / name).read_text(encoding="utf-8") for name in FILES}


def test_a_release_writes_checks_commits_and_tags(repository: Path) -> None:
    steps: list[Sequence[str]] = []
    release.release(repository, "1.0.0", "2026-02-03", lambda step, root: steps.append(step))
    assert steps == list(release.STEPS)
    new = texts(repository)
    assert "## [Unreleased]\n\n## [1.0.0] - 2026-02-03\n\n### Added" in new["CHANGELOG.md"]
    assert "version: 1.0.0\ndate-released: 2026-02-03\n" in new["CITATION.cff"]
    assert release.version_in(repository) == "1.0.0" and '"1.0.0"' in new["recipe/recipe.yaml"]
    assert release.output(repository, "git", "status", "--porcelain") == ""
    assert release.output(repository, "git", "tag") == "v1.0.0\n"
    assert "the tag v1.0.0" not in release.faults(repository, "1.1.0")


def test_a_step_that_fails_leaves_the_files_as_they_were(repository: Path) -> None:
    def fail(step: Sequence[str], root: Path) -> None:
        raise RuntimeError(step[0])

    with pytest.raises(RuntimeError, match="make"):
        release.release(repository, "1.0.0", "2026-02-03", fail)
    assert texts(repository) == FILES
    assert release.output(repository, "git", "tag") == ""


def test_a_dry_run_changes_nothing(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert release.main(["1.0.0", "--dry-run"], repository) == 0
    said = capsys.readouterr().out
    assert '+__version__ = "1.0.0"' in said and "make wheel-check" in said and "git tag v1.0.0" in said
    assert texts(repository) == FILES
    assert release.output(repository, "git", "status", "--porcelain") == ""


def test_everything_that_forbids_a_release_is_named(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (repository / "CHANGELOG.md").write_text("## [Unreleased]\n\n## [0.9.0]\n\n- Old.\n", encoding="utf-8")
    subprocess.run(["git", "tag", "v0.8.0"], cwd=repository, check=True)
    assert release.main(["0.8.0"], repository) == 2
    assert capsys.readouterr().out.splitlines() == [
        "version 0.8.0 is below 0.9.0",
        "the tree has changes that are not committed",
        "the tag v0.8.0 is there already",
        "CHANGELOG.md: nothing stands under [Unreleased]",
    ]
    assert release.main(["1.0"], repository) == 2
    assert "below" not in " ".join(release.faults(repository, "0.9.0"))  # the first release: no tag has it


def test_steps_of_a_release_are_targets_of_the_makefile() -> None:
    targets = {step[1] for step in release.STEPS if step[0] == "make"}
    assert targets and targets <= set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))


def test_the_files_of_this_repository_have_a_place_for_the_version() -> None:
    assert len(release.written(ROOT, "99.0.0", "2026-01-01")) == 4


def test_the_scene_of_the_wheel_check_is_accepted(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(wheel_check.SCENE, encoding="utf-8")
    assert [path.name for path in load_scene(tmp_path / "scene.toml").load_paths] == ["pull"]
