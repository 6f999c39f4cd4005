# SPDX-License-Identifier: MIT
"""Runs killed at random moments, resumed, and set beside the run that was left alone: python -m benchmarks.kills.

Series with error estimates, drained and coupled in turn, by `--jobs 2`, checkpoints each fifth of a second. SIGKILL
ends the run, one of its workers, the server that starts them, or all, up to eight times; `--resume` goes on. A path
that begins once its end was saved, processes and files that are left over, hangs and other bits are failures.
"""

import argparse
import os
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import psutil

from pysprings import Scene
from pysprings.cli import app
from pysprings.core.storage import read_tree, write_text
from pysprings.full_model import checkpoint
from pysprings.full_model.paths import PathRun
from pysprings.results.folder import run_to_folder
from pysprings.scene.sections import PAPER, PAPER_SOIL

LONGEST, SOON = 300.0, 30.0  # s: a run that takes longer hangs; other processes end with it, once they have loaded
VICTIMS = ("run", "worker", "server", "all")
NOTES = "NOTES_OF_PATHS"  # variable of the environment: file of the run's notes

checkpoint.EVERY = 0.2  # in workers as well, which import this module
_run, _save_end = PathRun.run, PathRun.save_end


def _noted(run: PathRun, word: str) -> None:
    if NOTES in os.environ and (saved := run.work.checkpoints) is not None:
        with Path(os.environ[NOTES]).open("a") as stream:
            stream.write(f"{word} {saved.prefix}{run.path.name}\n")


PathRun.run = lambda run: (_noted(run, "begins"), _run(run))[1]  # type: ignore[method-assign]
PathRun.save_end = lambda run: (_save_end(run), _noted(run, "ended"))[0]  # type: ignore[method-assign]


def scenes() -> dict[str, Scene]:
    """Return a dead load and two paths, and a third that turns back, or a rest."""
    pull = {"name": "pull", "kind": "pull", "lateral_displacement": 2e-3, "rate": 1e-4}
    turn = {"name": "turn", "kind": "translation", "lateral_displacement": 1e-3, "rate": 1e-4}
    few = {"first_step_fraction": 0.2, "max_step_fraction": 0.4}
    mesh = {"refinement": 0.4, "discretisation": "fourier", "harmonics": 2}
    common = {"title": "killed", "mesh": mesh, "caisson": {"vertical_load": 1.5e6}, "solver": few}
    back, rest = ({**pull, "name": "third", "role": "held-back", "then": (then,)} for then in ("0 mm", "rest 1 hour"))
    scene = Scene(domain=PAPER, soil=PAPER_SOIL).replace(**common, output={"figures": False}, paths=(pull, turn, back))
    return {"drained": scene, "coupled": scene.replace(drainage={"mode": "coupled"}, paths=(turn, rest))}


def start(file: Path, out: Path, *options: str) -> psutil.Process:
    """Start `pysprings run` in a process of its own; its streams go to a file beside `out`."""
    if child := os.fork():
        return psutil.Process(child)
    os.environ[NOTES] = str(out.with_suffix(".notes"))
    log = os.open(out.with_suffix(".log"), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(log, 1)
    os.dup2(log, 2)
    sys.argv = ["pysprings", "run", str(file), "--out", str(out), "--jobs", "2", *options]
    code = 1
    try:
        app.main()
    except SystemExit as end:
        code = int(end.code or 0)
    finally:
        os._exit(code)


def running(process: psutil.Process) -> bool:
    """Return whether a process has not ended; one that nobody waits for is a zombie."""
    with suppress(psutil.NoSuchProcess):
        return bool(process.is_running() and process.status() != psutil.STATUS_ZOMBIE)
    return False


def kill(run: psutil.Process, whom: str) -> tuple[int, list[psutil.Process]]:
    """Kill a part of a run; return 1, or 0 where there was none, and the helpers of the run."""
    helpers = run.children()  # the server, and what tracks resources
    workers = [each for helper in helpers for each in helper.children()]
    parts = [run], workers[-1:], [each for each in helpers if each.children()], [run, *helpers, *workers]
    for victim in (found := dict(zip(VICTIMS, parts, strict=True))[whom]):
        with suppress(psutil.NoSuchProcess):
            victim.kill()
    return int(bool(found)), [*helpers, *workers]


def killed(file: Path, out: Path, whole: float, rng: random.Random) -> Counter[str]:
    """Kill a run several times, and let it come to its end; return the number of kills by victim."""
    kills, left, family = Counter[str](), rng.randint(2, 8), list[psutil.Process]()
    run = start(file, out)
    while True:
        try:
            code = run.wait(0.5 * rng.random() * whole if left else LONGEST)
        except psutil.TimeoutExpired:
            assert left, f"{out.name} hangs after {dict(kills)}"
            whom, left = rng.choice(VICTIMS), left - 1
            hit, family = kill(run, whom)
            kills[whom] += hit
            continue
        until = time.monotonic() + SOON
        while (alive := [each for each in family if running(each)]) and time.monotonic() < until:
            time.sleep(0.05)
        log = out.with_suffix(".log").read_text()
        died = code == -signal.SIGKILL or "was ended by SIGKILL (memory?), 2 times" in log
        assert not alive and (code == 0 or died), f"{out.name} after {dict(kills)}: {code}, left over: {alive}\n{log}"
        if code == 0:
            return kills
        # a run that was killed before its first checkpoint has nothing to go on from
        there = any((out / "checkpoint").glob("*.npz")) or (out / "run.json").exists()
        run = start(file, out, *(["--resume"] if there else []))


def again(notes: Path) -> int:
    """Return how many paths begin once their end was saved."""
    lines = [line.split(" ", 1) for line in notes.read_text().splitlines()]
    return sum(["ended", name] in lines[:k] for k, (word, name) in enumerate(lines) if word == "begins")


def apart(alone: Path, out: Path) -> bool:
    """Return whether two runs differ in a file, a table, or a number."""
    names, others = ({str(file.relative_to(folder)) for file in folder.rglob("*")} for folder in (alone, out))
    tables = [name for name in names & others if name.endswith(".csv")]
    same = names == others and all((alone / name).read_bytes() == (out / name).read_bytes() for name in tables)
    for name in ("full_model.nc", "springs.nc"):
        a, b = read_tree(alone / name), read_tree(out / name)
        same &= a.groups == b.groups and all(a[group].dataset.equals(b[group].dataset) for group in a.groups)
    return not same


def main() -> None:
    """Print a line for each run, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng, place, alone = random.Random(given.seed), Path(tempfile.mkdtemp()), dict[str, float]()
    for kind, scene in scenes().items():
        file = write_text(scene.to_toml(), place / f"{kind}.toml")
        run_to_folder(scene, place / "first")  # loads and compiles everything
        began = time.perf_counter()
        assert start(file, place / kind).wait() == 0, (place / f"{kind}.log").read_text()
        alone[kind] = time.perf_counter() - began
    kills, runs, wrong = Counter[str](), 0, 0
    while kills.total() < given.kills:
        kind, out, runs = list(alone)[runs % 2], place / f"run-{runs}", runs + 1
        had = killed(place / f"{kind}.toml", out, alone[kind], rng)
        found = again(out.with_suffix(".notes")), int(apart(place / kind, out))
        kills, wrong = kills + had, wrong + sum(found)
        print(f"{kind}, {dict(had)}: paths begun after their end: {found[0]}, other results: {found[1]}", flush=True)
    print(f"{runs} runs, kills: {dict(kills)}; paths begun after their end, and other results: {wrong}")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
