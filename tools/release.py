# SPDX-License-Identifier: MIT
"""Make a release in one go: ``python -m tools.release VERSION [--dry-run]`` (`make release VERSION=1.2.3`).

It refuses a tree with changes, a lower version, one with a tag, and an empty changelog. It writes version and date to
the files that hold them, makes the generated pages, runs the checks, builds wheel and sdist, commits and tags. A step
that fails leaves the files as they were. Nothing is uploaded.
"""

import argparse
import difflib
import re
import subprocess
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
UNRELEASED = "## [Unreleased]\n"
# what has to pass, and what is built
STEPS = (("make", "pages"), ("bash", ".ci/run"), ("make", "wheel-check"), ("make", "build"))
Run = Callable[[Sequence[str], Path], None]


def version_in(root: Path) -> str:
    """Return the version that the package has now."""
    found = re.search(r'__version__ = "(.+)"', (root / "pysprings/core/version.py").read_text(encoding="utf-8"))
    if found is None:
        raise SystemExit("pysprings/core/version.py holds no version")
    return found[1]


def faults(root: Path, version: str) -> list[str]:
    """Return everything that forbids a release, in words."""
    if not re.fullmatch(r"\d+\.\d+\.\d+", version):
        return [f"{version!r} is not a version such as 1.2.3"]
    found = []
    now = version_in(root)
    if [int(part) for part in version.split(".")] < [int(part) for part in now.split(".")]:
        found.append(f"version {version} is below {now}")
    if output(root, "git", "status", "--porcelain"):
        found.append("the tree has changes that are not committed")
    if f"v{version}" in output(root, "git", "tag").split():
        found.append(f"the tag v{version} is there already")
    _, mark, rest = (root / "CHANGELOG.md").read_text(encoding="utf-8").partition(UNRELEASED)
    if not mark or "\n- " not in rest.partition("\n## ")[0]:
        found.append("CHANGELOG.md: nothing stands under [Unreleased]")
    return found


def output(root: Path, *command: str) -> str:
    """Return what a command prints."""
    return subprocess.run(command, cwd=root, check=True, capture_output=True, text=True).stdout


def written(root: Path, version: str, date: str) -> dict[Path, str]:
    """Return file -> text with the new version; a file in which it finds no place for it is a fault."""
    places = {
        "pysprings/core/version.py": (r'__version__ = ".+"', f'__version__ = "{version}"'),
        "CITATION.cff": (r"^version: .+$(\ndate-released: .+$)?", f"version: {version}\ndate-released: {date}"),
        "recipe/recipe.yaml": (r'^  version: ".+"$', f'  version: "{version}"'),
        "CHANGELOG.md": (re.escape(UNRELEASED), f"{UNRELEASED}\n## [{version}] - {date}\n"),
    }
    texts = {}
    for name, (pattern, new) in places.items():
        text, count = re.subn(pattern, lambda _, new=new: new, (root / name).read_text(encoding="utf-8"), flags=re.M)
        if count != 1:
            raise SystemExit(f"{name}: {count} places for the version, not one")
        texts[root / name] = text
    return texts


def call(command: Sequence[str], root: Path) -> None:
    """Run a command; show what it prints."""
    subprocess.run(command, cwd=root, check=True)


def release(root: Path, version: str, date: str, run: Run = call) -> None:
    """Write, check, build, commit and tag; put the files back where a step fails."""
    for file, text in written(root, version, date).items():
        file.write_text(text, encoding="utf-8", newline="\n")
    try:
        for step in STEPS:
            run(step, root)
    except BaseException:
        call(("git", "checkout", "--quiet", "--", "."), root)
        raise
    call(("git", "commit", "--quiet", "--all", "--message", f"release: {version}"), root)
    call(("git", "tag", "--annotate", f"v{version}", "--message", f"pysprings {version}"), root)


def shown(root: Path, version: str, date: str) -> str:
    """Return what a release would change and run."""
    lines = []
    for file, text in written(root, version, date).items():
        name = file.relative_to(root).as_posix()
        old = file.read_text(encoding="utf-8").splitlines()
        lines += difflib.unified_diff(old, text.splitlines(), name, name, lineterm="", n=0)
    lines += ["", *(" ".join(step) for step in STEPS), f"git commit, git tag v{version}"]
    return "\n".join(lines)


def main(argv: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """Make a release, or print what it would be."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("version")
    parser.add_argument("--dry-run", action="store_true", help="print what would change and run; change nothing")
    given = parser.parse_args(argv)
    if found := faults(root, given.version):
        print(*found, sep="\n")
        return 2
    date = datetime.now(UTC).date().isoformat()
    if given.dry_run:
        print(shown(root, given.version, date))
    else:
        release(root, given.version, date)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
