# SPDX-License-Identifier: MIT
"""What a study costs and survives: ``python -m benchmarks.studies SECTION [--folder DIR] [--store]``.

workers  a study of 200 cases on `coarse` with one process, and with two: wall time and ratio
kills    20 workers and 3 clients killed at random moments: cases lost, repeated, different from the study left alone
client   a study of 1,000 tiny cases: memory and CPU time of the command while it grows, files and bytes of a case
plan     100,000 cases on paper: what `--plan` takes
paper    what the measured cost of a case makes of 100,000 (from the stored rows of `workers` and `client`)

Each section runs `pysprings sweep` in processes of its own. ``--store`` writes its rows to data/evidence.
"""

import argparse
import csv
import random
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil

from benchmarks.differences import difference
from pysprings.core.storage import write_text
from tools.evidence_store import DATA, Table, store, to_csv

COMMAND = "python -m benchmarks.studies"
SCENE = """title = "A case of a study"
[mesh]
discretisation = "fourier"
{mesh}
[output]
figures = false
[[path]]
name = "pull"
kind = "pull"
lateral_displacement = "{end}"
"""
COARSE = ('preset = "coarse"\nharmonics = 4', "1 mm")
TINY = ('preset = "coarse"\nrefinement = 0.5\nharmonics = 2', "0.1 mm")
STUDY = """title = "Stiffness and friction"
scene = "base.toml"
[[axis]]
key = "soil.young_modulus"
from = "60 MPa"
to = "300 MPa"
count = {stiffnesses}
[[axis]]
key = "interface.friction_coefficient"
from = 0.2
to = 0.6
count = {frictions}
"""
MB = 1e6


def made(folder: Path, scene: tuple[str, str], stiffnesses: int, frictions: int) -> Path:
    """Write a study and its scene; return the folder."""
    write_text(SCENE.format(mesh=scene[0], end=scene[1]), folder / "base.toml")
    write_text(STUDY.format(stiffnesses=stiffnesses, frictions=frictions), folder / "study.toml")
    return folder


def started(folder: Path, out: str, *options: str) -> psutil.Popen:
    """Start `pysprings sweep` in a folder; its messages go to a file."""
    line = [sys.executable, "-m", "pysprings", "sweep", "study.toml", "--out", out, "--quiet", *options]
    with (folder / f"{out}.log").open("a", encoding="utf-8") as log:
        return psutil.Popen(line, cwd=folder, stdout=log, stderr=log)


def ended(out: Path) -> dict[str, int]:
    """Return name -> time of its last change [ns] of the cases that have ended."""
    found = out.glob("cases/*/case.json")
    return {file.parent.name: file.stat().st_mtime_ns for file in found}


def workers(folder: Path) -> Table:
    """Time a study of 200 cases with one process and with two; the loops are compiled before."""
    made(folder, COARSE, 20, 10)
    (folder / "first").mkdir(exist_ok=True)
    assert started(made(folder / "first", COARSE, 2, 2), "out", "--jobs", "1").wait() == 0
    times = {}
    for jobs in (1, 2):
        began = time.perf_counter()
        assert started(folder, f"jobs-{jobs}", "--jobs", str(jobs)).wait() == 0
        times[jobs] = time.perf_counter() - began
        assert len(ended(folder / f"jobs-{jobs}")) == 200
    head = ["cases", "one worker [s]", "two workers [s]", "ratio"]
    return [head, ["200", f"{times[1]:.0f}", f"{times[2]:.0f}", f"{times[1] / times[2]:.2f}"]]


def children(process: psutil.Popen) -> list[psutil.Process]:
    """Return the workers of a study that runs."""
    try:
        found = psutil.Process(process.pid).children(recursive=True)
        return [each for each in found if "spawn_main" in " ".join(each.cmdline())]
    except psutil.Error:
        return []


def kills(folder: Path, aim: int = 20, clients: int = 3, seed: int = 1) -> Table:
    """Kill workers, and now and then the command with its scheduler, until so many are dead; then let it end."""
    made(folder, COARSE, 10, 8)
    assert started(folder, "alone", "--jobs", "2").wait() == 0
    rng, out = random.Random(seed), folder / "killed"
    killed, seen, repeated, starts, before = 0, dict[str, int](), 0, 1, 0
    process = started(folder, "killed", "--jobs", "2")
    while killed < aim or process.poll() is None:
        time.sleep(rng.uniform(0.5, 4.0))
        now = ended(out)
        repeated += sum(now.get(name) != stamp for name, stamp in seen.items())
        seen |= now
        if process.poll() is not None and killed < aim:
            raise SystemExit(f"the study ended after {killed} kills with exit code {process.returncode}")
        found = children(process)
        if killed < aim and found and len(seen) > before:  # the workers have begun
            rng.choice(found).kill()
            killed += 1
            if killed in range(aim // (clients + 1), aim, aim // (clients + 1))[:clients]:
                process.kill()
                process.wait()
                process, starts, before = started(folder, "killed", "--jobs", "2"), starts + 1, len(ended(out))
    assert process.returncode == 0, (folder / "killed.log").read_text(encoding="utf-8")
    names = ended(folder / "alone").keys()
    lost = len(names - ended(out).keys())
    apart = [
        difference(*(place / "cases" / name / "springs.nc" for place in (folder / "alone", out))) for name in names
    ]
    head = ["cases", "workers killed", "commands killed", "cases lost", "cases repeated", "largest difference"]
    return [head, [str(len(names)), str(killed), str(starts - 1), str(lost), str(repeated), f"{max(apart):.1e}"]]


def watched(process: psutil.Popen, out: Path, every: int) -> Iterator[tuple[int, float, float]]:
    """Yield (cases that have ended, memory [bytes], CPU time [s]) of a command each time that so many more have."""
    due = every
    memory, cpu = 0, 0.0
    while process.poll() is None:
        time.sleep(0.5)
        try:
            times = process.cpu_times()
            memory, cpu = process.memory_info().rss, times.user + times.system
        except psutil.Error:
            break
        number = len(ended(out))
        if number >= due:
            yield number, memory, cpu
            due = number - number % every + every


def client(folder: Path) -> Table:
    """Run 1,000 tiny cases on two workers; return memory and CPU time of the command as they end."""
    made(folder, TINY, 40, 25)
    process, out = started(folder, "out", "--jobs", "2"), folder / "out"
    began = time.perf_counter()
    rows = [["cases ended", "time [s]", "memory of the command [MB]", "its CPU time [s]", "files", "on disk [MB]"]]
    for number, memory, cpu in watched(process, out, 200):
        now = time.perf_counter() - began
        rows.append([str(number), f"{now:.0f}", f"{memory / MB:.0f}", f"{cpu:.1f}", *_on_disk(out)])
    assert process.wait() == 0
    rows.append([f"{len(ended(out))}, study.nc written", f"{time.perf_counter() - began:.0f}", "", "", *_on_disk(out)])
    return rows


def _on_disk(out: Path) -> list[str]:
    sizes = [file.stat().st_size for file in out.rglob("*") if file.is_file()]
    return [str(len(sizes)), f"{sum(sizes) / MB:.1f}"]


def plan(folder: Path) -> Table:
    """Plan 100,000 cases, run none: time, memory and the size of cases.csv; twice, as a study that goes on begins."""
    made(folder, TINY, 400, 250)
    rows = [["100,000 cases", "time [s]", "largest memory [MB]", "cases.csv [MB]"]]
    for what in ("planned", "planned again in the same folder"):
        began = time.perf_counter()
        process, largest = started(folder, "out", "--plan"), 0
        while process.poll() is None:
            time.sleep(0.2)
            try:
                largest = max(largest, process.memory_info().rss)
            except psutil.Error:
                break
        assert process.wait() == 0
        size = (folder / "out" / "cases.csv").stat().st_size
        rows.append([what, f"{time.perf_counter() - began:.0f}", f"{largest / MB:.0f}", f"{size / MB:.1f}"])
    return rows


def paper(_folder: Path) -> Table:
    """Return time, load of the scheduler, files and disk of 100,000 cases, from the stored costs of a case."""
    first, last = stored("studies-client", 0), stored("studies-client", -2)
    cases = float(last["cases ended"]) - float(first["cases ended"])
    cpu, files, disk = (
        (float(last[name]) - float(first[name])) / cases for name in ("its CPU time [s]", "files", "on disk [MB]")
    )
    one = float(stored("studies-workers", 0)["one worker [s]"]) / 200
    number = 100_000
    return [
        ["100,000 cases", "a case", "all"],
        ["CPU time of the command with its scheduler", f"{cpu:.3f} s", f"{cpu * number / 3600:.1f} h"],
        ["files", f"{files:.1f}", f"{files * number:.2g}"],
        ["on disk", f"{disk:.2f} MB", f"{disk * number / 1000:.0f} GB"],
        ["one worker, a pull to 1 mm on `coarse`", f"{one:.2f} s", f"{one * number / 3600:.0f} h"],
        ["workers that one scheduler keeps busy with such cases", f"{one / cpu:.0f}", ""],
        ["the same with cases of one minute", f"{60 / cpu:.0f}", ""],
    ]


def stored(name: str, row: int) -> dict[str, str]:
    """Return a row of stored evidence."""
    with (DATA / f"{name}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))[row]


SECTIONS: dict[str, Callable[[Path], Table]] = {
    "workers": workers, "kills": kills, "client": client, "plan": plan, "paper": paper,
}  # fmt: skip


def main() -> None:
    """Run a section, print its rows, and store them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("section", choices=SECTIONS)
    parser.add_argument("--folder", type=Path, required=True, help="an empty folder for the studies")
    parser.add_argument("--store", action="store_true", help="write the rows to data/evidence")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=False)
    rows = SECTIONS[given.section](given.folder)
    print(to_csv(rows), end="")
    if given.store:
        name = f"studies-{given.section}"
        store(name, {name: to_csv(rows)}, f"{COMMAND} {given.section}", "Two cores.")


if __name__ == "__main__":
    main()
