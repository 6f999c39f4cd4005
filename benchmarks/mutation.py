# SPDX-License-Identifier: MIT
"""How many small changes of the code the tests notice.

    python -m benchmarks.mutation [--sample 40] [--seed 1] [--workers 1] [--out DIR] [--store]

Mutants (`mutants.py`) are drawn with a fixed seed: kinds of change in turn, a third of them from the engine. Each is
made in a copy of the working tree, and the test files that call the changed function (`mutation_calls.py`; where none
is seen to do so, those nearest to its module, `mutation_map.py`) are run there until one fails. Loops that the change
may be compiled into are compiled anew for each mutant (`mutation_cache.py`). A test that has failed must pass without
the mutant, else the kill does not count. Verdicts are kept in the output folder: a mutant that was killed is not run
again while its file is unchanged, so that a second call goes on with the rest, or runs the survivors alone after a
test was added.
``--page`` runs nothing, and prints what has been judged. ``--store`` stores the tables in data/evidence, of which
`make evidence` makes docs/evidence/mutation.md. Mutants without effect stand with the reason in
`mutation_equivalent.txt`.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import platform
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from compileall import compile_dir
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from threading import Lock
from typing import Any

from benchmarks.evidence_store import LINE, store, to_csv
from benchmarks.mutants import Mutant, compiles, find_mutants
from benchmarks.mutation_cache import PACKAGE, cached_loops, give_loops, kept_loops
from benchmarks.mutation_calls import Calls, kept_calls, record
from benchmarks.mutation_calls import test_files as files_that_call
from benchmarks.mutation_map import TestMap
from benchmarks.mutation_server import Server
from pysprings.core.files.storage import write_text
from pysprings.core.text import markdown_table

ROOT = Path(__file__).parents[1]
PARTS = {"engine": ("fe_engine", 1), "tool": ("pysprings", 2)}  # folder, share of the sample
EQUIVALENT = Path(__file__).with_name("mutation_equivalent.txt")
TARGET = 90.0
KILLED, SURVIVED, VOID, EQUAL = "killed", "survived", "void", "equivalent"


@dataclass(frozen=True)
class Limits:
    """Test files that are run first and in all for a mutant, at most, and seconds for a call of pytest."""

    first: int = 4
    files: int = 24
    seconds: float = 900.0


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant: killed (``by`` a test, or "timeout"), survived, equivalent, or void (not counted)."""

    part: str
    mutant: Mutant
    outcome: str
    by: str = ""
    seconds: float = 0.0
    files: tuple[str, ...] = ()


# --- which ones ---


def draw(root: Path, sample: int, seed: int) -> list[tuple[str, Mutant]]:
    """Return (part, mutant) of a sample: by part in its share, kinds of change in turn, places at random."""
    whole, drawn = sum(share for _, share in PARTS.values()), []
    for part, (folder, share) in PARTS.items():
        chance = random.Random(f"{seed} {part}")
        kinds: dict[str, list[Mutant]] = {}
        for file in sorted((root / folder).rglob("*.py")):
            for mutant in find_mutants(file.read_bytes(), file.relative_to(root).as_posix()):
                kinds.setdefault(mutant.kind, []).append(mutant)
        for each in kinds.values():
            chance.shuffle(each)
        wanted, order = round(sample * share / whole), sorted(kinds)
        while wanted and any(kinds.values()):
            for kind in order:
                if wanted and kinds[kind]:
                    mutant = kinds[kind].pop()
                    if compiles(mutant.applied((root / mutant.file).read_bytes())):
                        drawn.append((part, mutant))
                        wanted -= 1
    random.Random(seed).shuffle(drawn)  # a run that is stopped has judged some of all
    return drawn


def equivalents(file: Path = EQUIVALENT) -> dict[str, str]:
    """Return key -> reason of the mutants that change nothing."""
    lines = [line for line in file.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    return {key: reason for key, _, reason in (line.rpartition(" | ") for line in lines)}


# --- one of them ---


def copied(root: Path, folder: Path) -> Path:
    """Copy the files that git knows, and new ones; no bytecode and no caches."""
    names = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=root,
        capture_output=True,
        check=True,
    )
    for name in names.stdout.decode().split("\0"):
        if name and (root / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, folder / name)
    return folder


# folder, arguments of pytest, settings of the environment, seconds -> exit code (None after a timeout), printed text
Run = Callable[[Path, Sequence[str], Mapping[str, str], float], tuple[int | None, str]]


def run_alone(
    folder: Path, arguments: Sequence[str], settings: Mapping[str, str], seconds: float
) -> tuple[int | None, str]:
    """Run pytest in a new process (see `Run`)."""
    line = [sys.executable, "-m", "pytest", *arguments]
    env = {**os.environ, **settings}
    try:
        done = subprocess.run(line, cwd=folder, env=env, capture_output=True, text=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return None, ""
    return done.returncode, done.stdout


def tests_fail(copy: Path, tests: Sequence[str], cache: Path, limit: float, run: Run = run_alone) -> str | None:
    """Run tests in a copy until one fails: its name, "timeout", or None where all pass."""
    settings = {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1", "NUMBA_CACHE_DIR": str(cache)}
    settings["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # none is needed, and each takes its time to load
    options = ["-x", "-q", "--no-header", "--tb=no", "-p", "no:cacheprovider", "-rfE"]
    code, text = run(copy, [*options, *tests], settings, limit)
    if code is None:
        return "timeout"
    if code in (0, 5):  # 5: no test was selected
        return None
    failed = [line for line in text.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return failed[0].split(" ", 1)[1].split(" - ")[0] if failed else f"exit {code}"


def choose(mutant: Mutant, tests: TestMap, calls: Calls, most: int) -> list[str]:
    """Return the test files for a mutant: near ones that call its function or are not known, others by cost, others."""
    near = tests.test_files(mutant.file, mutant.function, most)
    calling = files_that_call(calls, f"{mutant.file}:{mutant.place.partition('.')[2]}")
    first = [file for file in near[:4] if file in calling or file not in calls]
    return list(dict.fromkeys([*first, *calling, *near]))[:most]


def judge(
    part: str,
    mutant: Mutant,
    copy: Path,
    files: list[str],
    given: Limits,
    give: Callable[[Path], object] | None = None,
    run: Run = run_alone,
) -> Verdict:
    """Make a mutant in a copy, run its test files, the first few alone at first, and take it back.

    ``give`` puts compiled loops into a cache of the mutant's own; without it, all mutants of a copy share one.
    """
    file = copy / mutant.file
    began, source, by = time.monotonic(), file.read_bytes(), None
    cache = Path(tempfile.mkdtemp(prefix="cache-", dir=copy.parent)) if give else shared_cache(copy)
    try:
        file.write_bytes(mutant.applied(source))
        if give:
            give(cache)
        for asked in (files[: given.first], files[given.first :]):
            if asked and not by:
                by = tests_fail(copy, asked, cache, given.seconds, run)
                last = tuple(asked)
    finally:
        file.write_bytes(source)
        if give:
            shutil.rmtree(cache, ignore_errors=True)
    seconds = round(time.monotonic() - began, 1)
    return Verdict(part, mutant, KILLED if by else SURVIVED, by or "", seconds, last if files else ())


def shared_cache(copy: Path) -> Path:
    """Return the folder of compiled loops of a copy without a mutant."""
    return copy.parent / f"{copy.name}-cache"


def confirmed(
    verdicts: list[Verdict],
    copy: Path,
    limit: float,
    known: dict[tuple[str, ...], bool] | None = None,
    run: Run = run_alone,
) -> list[Verdict]:
    """Return the verdicts; a kill by what fails without the mutant too is void.

    ``known`` keeps which tests pass without a mutant. A file that could not be loaded is only loaded.
    """
    cache, out, known = shared_cache(copy), list[Verdict](), {} if known is None else known
    for verdict in verdicts:
        if verdict.outcome == KILLED:
            at_all = verdict.by == "timeout" or verdict.by.startswith("exit ")
            asked = verdict.files if at_all else (verdict.by,)
            asked = asked if at_all or "::" in verdict.by else ("--collect-only", verdict.by)
            if asked not in known:
                known[asked] = tests_fail(copy, asked, cache, limit, run) is None
            if not known[asked]:
                verdict = Verdict(verdict.part, verdict.mutant, VOID, verdict.by, verdict.seconds, verdict.files)
        out.append(verdict)
    return out


# --- all of them ---


@dataclass(frozen=True)
class Place:
    """A copy of the sources, the process that runs tests there, and the folder of its compiled loops."""

    copy: Path
    server: Server
    loops: Path


@contextmanager
def places(root: Path, tests: TestMap, count: int) -> Iterator[SimpleQueue[Place]]:
    """Make so many places for the time of a block."""
    with tempfile.TemporaryDirectory(prefix="mutation-") as folder:
        free: SimpleQueue[Place] = SimpleQueue()
        for k in range(count):
            (copy := Path(folder) / f"copy{k}").mkdir()
            copied(root, copy)
            for package, _ in PARTS.values():  # Python compiles a source that changes anew
                compile_dir(copy / package, quiet=1)
            kept = kept_loops(root)
            give_loops(kept, root, copy, tests, "", shared_cache(copy))
            free.put(Place(copy, Server(), cached_loops(kept, shared_cache(copy))))
        yield free
        while not free.empty():
            free.get().server.close()


def run(
    root: Path,
    drawn: list[tuple[str, Mutant]],
    out: Path,
    workers: int,
    given: Limits,
    calls: Calls | None = None,
) -> list[Verdict]:
    """Judge those that no earlier call has killed (none without ``calls``), print each; return all that are judged."""
    tests = TestMap(root, tuple(folder for folder, _ in PARTS.values()))
    verdicts, left = _known(root, drawn, out, calls)
    names, good = {mutant: _name(root, mutant) for _, mutant in left}, dict[tuple[str, ...], bool]()
    with places(root, tests, workers if left else 0) as free, ThreadPoolExecutor(workers) as pool:

        def one(each: tuple[str, Mutant]) -> Verdict:
            place, mutant = free.get(), each[1]
            files = choose(mutant, tests, calls or {}, given.files)
            own = mutant.file.startswith(f"{PACKAGE}/") or mutant.file in tests.compiled
            # its loops grow with what is run without a mutant
            give = partial(give_loops, place.loops, place.copy, place.copy, tests, mutant.file) if own else None
            try:
                verdict = judge(*each, place.copy, files, given, give, place.server.run)
                found = confirmed([verdict], place.copy, given.seconds, good, place.server.run)[0]
            finally:
                free.put(place)
            words = f"{found.outcome:9} {found.seconds:6.0f} s  {mutant.file}:{mutant.line}  {mutant.key}"
            print(f"{words}  {found.by}".rstrip(), flush=True)
            _keep(out / "results.json", names[mutant], found)
            return found

        verdicts += pool.map(one, left)
    return verdicts


def _known(
    root: Path, drawn: list[tuple[str, Mutant]], out: Path, calls: Calls | None
) -> tuple[list[Verdict], list[tuple[str, Mutant]]]:
    """Return the verdicts that stand, and the mutants that are to be judged."""
    same, kept = equivalents(), _kept(out / "results.json")
    verdicts, left = list[Verdict](), list[tuple[str, Mutant]]()
    for part, mutant in drawn:
        outcome, by = kept.get(_name(root, mutant), ("", ""))
        if mutant.key in same:
            verdicts.append(Verdict(part, mutant, EQUAL, same[mutant.key]))
        elif outcome == KILLED or (outcome and calls is None):
            verdicts.append(Verdict(part, mutant, outcome, by))
        elif calls is not None:
            left.append((part, mutant))
    return verdicts, left


def _name(root: Path, mutant: Mutant) -> str:
    """Return what names a mutant of the present state of its file."""
    return f"{mutant.key} {hashlib.sha256((root / mutant.file).read_bytes()).hexdigest()[:16]}"


def _kept(file: Path) -> dict[str, list[str]]:
    """Return the name -> (outcome, what killed it) of earlier calls."""
    found: dict[str, list[str]] = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    return found


_WRITING = Lock()


def _keep(file: Path, name: str, verdict: Verdict) -> None:
    with _WRITING:
        known = _kept(file) | {name: [verdict.outcome, verdict.by]}
        file.parent.mkdir(parents=True, exist_ok=True)
        write_text(json.dumps(known, indent=1) + "\n", file)


# --- what came out ---


def score(verdicts: list[Verdict]) -> float:
    """Return the killed of those that could be killed [%]; NaN of none."""
    killed, survived = (sum(each.outcome == kind for each in verdicts) for kind in (KILLED, SURVIVED))
    return 100.0 * killed / (killed + survived) if killed + survived else float("nan")


HEAD = ["part", "mutants", "killed", "survived", "without effect", "void", "score"]


def tables(verdicts: list[Verdict]) -> dict[str, list[list[str]]]:
    """Return name -> rows, the heads first: the score by part, the survivors, the mutants without effect."""
    rows = [HEAD]
    for part in [*PARTS, "both"]:
        own = [each for each in verdicts if part in (each.part, "both")]
        counts = [str(sum(each.outcome == kind for each in own)) for kind in (KILLED, SURVIVED, EQUAL, VOID)]
        rows.append([part, str(len(own)), *counts, f"{score(own):.0f} %"])
    found = {"mutation": rows}
    for name, outcome in (("survivors", SURVIVED), ("without-effect", EQUAL)):
        own = [each for each in verdicts if each.outcome == outcome]
        lines = [f"`{each.mutant.key}`" + (f": {each.by}" if each.by else "") for each in own]
        found[f"mutation-{name}"] = [[LINE], *([line] for line in lines or ["none"])]
    return found


def report(verdicts: list[Verdict]) -> str:
    """Return the tables for reading."""
    parts = []
    for name, (head, *rows) in tables(verdicts).items():
        listed = "".join(f"- {row[0]}\n" for row in rows)
        parts.append(f"{name}\n\n{listed if head == [LINE] else markdown_table(head, rows, numbers=True)}")
    return "\n".join(parts)


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw, judge, print the score; exit code 1 below the target."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=40, help="number of mutants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--files", type=int, default=Limits.files, help="test files for each mutant, at most")
    parser.add_argument("--limit", type=float, default=Limits.seconds, help="seconds for the tests of a mutant")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "mutation")
    parser.add_argument("--static", action="store_true", help="choose tests by imports, and the calls that are known")
    parser.add_argument("--page", action="store_true", help="run nothing: what has been judged")
    parser.add_argument("--store", action="store_true", help="store the tables in data/evidence")
    given: Any = parser.parse_args(arguments)
    drawn = draw(ROOT, given.sample, given.seed)
    known = given.out / "calls.json"
    calls = None if given.page else kept_calls(known) if given.static else record(ROOT, known)
    limits = Limits(files=given.files, seconds=given.limit)
    verdicts = run(ROOT, drawn, given.out, given.workers, limits, calls)
    print(report(verdicts))
    if given.store:
        command = f"make mutation SAMPLE={given.sample} SEED={given.seed}"
        stored = {name: to_csv(rows) for name, rows in tables(verdicts).items()}
        note = f"{len(verdicts)} of {given.sample} mutants judged, Python {platform.python_version()}."
        store("mutation", stored, command, note)
    return 0 if score(verdicts) >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
