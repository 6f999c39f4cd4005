# SPDX-License-Identifier: MIT
"""OpenFAST's NREL 5 MW turbine on one bucket: its monopile ends at mudline, on springs of pysprings; 60 s of operation.

    python -m benchmarks.openfast_turbine SPRINGS DIR --rtest FOLDER [--openfast PROGRAM] [--waves DEG]

FOLDER is the user's copy of OpenFAST's regression tests (`r-test`), of the version of PROGRAM (5.x); DIR gets copies of
their files, changed where the foundation asks for it. SPRINGS has a fan of load paths (template `monobucket`). Models:
clamped at mudline, the matrix of the bucket at rest, its secant at the mean load of the clamped turbine, the nonlinear
springs, and those with memory where SPRINGS has them. Each runs twice: in operation (wind and waves of the test), and
released from a bent tower with a parked rotor in still air and water, for the first frequency. `--waves 60` turns the
waves by 60 degrees from the wind.

Without the turbulent wind file (`turbsim 90m_12mps_twr.inp` makes it) the wind is steady, 12 m/s. The controller is
compiled with gfortran unless its library is there. A mass at the lid gives the ground the vertical load of the springs.
"""

import argparse
import re
import shutil
import subprocess
import time
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings import impose, model_of, open_springs, predict
from pysprings.core.errors import BeyondSprings, Problem, ResourceError, RunIncomplete, UserInputError, refused
from pysprings.macro.answer import MacroWarning, PredictionNotConverged
from pysprings.macro.model import MacroModel
from pysprings.memory.build import has_memory
from pysprings.results.exporters import Source, export
from pysprings.results.exporters.soildyn.library import build
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]
Channels = dict[str, Array]
CASE, COMMON = "5MW_OC3Mnpl_DLL_WTurb_WavesIrr", "5MW_Baseline"  # folders of r-test/glue-codes/openfast
START, BENT = 20.0, 0.5  # s of the run that results leave out, m of the tower top when it is released
BALANCE = 0.05  # most that mean reactions may be off, of the largest H and of the mean M of the clamped turbine
QUANTITIES = {  # key -> words, unit, digits
    "towertop": ("tower at 86 m [m]", 1.0, 3), "H": ("H at mudline [MN]", 1e-6, 2),
    "M": ("M at mudline [MN m]", 1e-6, 1), "Hy": ("H side to side [MN]", 1e-6, 2),
    "Mx": ("M side to side [MN m]", 1e-6, 1), "u": ("u of the lid [mm]", 1e3, 2),
    "rotation": ("rotation of the lid [deg]", 180.0 / np.pi, 4),
}  # fmt: skip
SIGHTS = ("towertop", "H", "M", "Mx", "rotation")  # panels of the picture
COLOURS = ("#000000", "#0072B2", "#56B4E9", "#D55E00", "#009E73")


def _line(key: str) -> re.Pattern[str]:
    """Return the pattern of a line of an input file: a value, its keyword, words on it."""
    return re.compile(rf'^[ \t]*("[^"\n]*"|\S+)(?=[ \t]+{re.escape(key)}(?!\S))', re.MULTILINE)


def edit(file: Path, values: Mapping[str, object]) -> str:
    """Return the text of an input file of OpenFAST with other values of keywords.

    Raises
    ------
    UserInputError
        Keywords that the file does not have exactly once, all of them at once.
    """
    text, counts = file.read_text(encoding="utf-8", errors="surrogateescape"), dict[str, int]()
    for key, value in values.items():
        text, counts[key] = _line(key).subn(lambda _, value=value: str(value), text)
    words = "stands there {} times, not once: another version?"
    if wrong := [Problem(str(file), key=key, message=words.format(n)) for key, n in counts.items() if n != 1]:
        raise UserInputError(wrong)
    return text


def value(file: Path, key: str) -> str:
    """Return the value of a keyword without quotes; raise UserInputError as `edit` does."""
    edit(file, {key: ""})
    found = _line(key).search(file.read_text(encoding="utf-8", errors="surrogateescape"))
    assert found is not None
    return found[1].strip('"')


def table(text: str, key: str, rows: Sequence[str] | None = None) -> tuple[str, list[str]]:
    """Return a text with other rows of the table whose number of rows is `key`, and the rows that were there."""
    found = _line(key).search(text)
    if found is None:
        raise refused(key, "the input file has no table of this name: another version?")
    lines = text[found.start() :].splitlines(keepends=True)
    count = int(found[1])
    old = lines[3 : 3 + count]
    if rows is not None:
        lines[0] = lines[0].replace(found[1], str(len(rows)), 1)
        lines[3 : 3 + count] = [row + "\n" for row in rows]
    return text[: found.start()] + "".join(lines), old


def without_added_mass(file: Path) -> str:
    """Return the input of HydroDyn with Ca = 0 and Cp + Ca for Cp: the wave forces of a fixed pile, at all depths.

    With the added mass and modes of SubDyn, which a free base needs, the steps of OpenFAST 5.0.0 do not converge.
    """
    lines = edit(file, {}).splitlines()
    head = next((k for k, line in enumerate(lines) if "SimplCa" in line.split()), None)
    if head is None:
        raise refused("SimplCa", "HydroDyn has no simple coefficients: another version?", file)
    row = dict(zip(lines[head].split(), map(float, lines[head + 2].split()), strict=True))
    for kind in ("", "MG"):
        row[f"SimplCp{kind}"] += row[f"SimplCa{kind}"]
        row[f"SimplCa{kind}"] = row[f"SimplAxCa{kind}"] = 0.0
    lines[head + 2] = " ".join(map(str, row.values()))
    return "\n".join(lines) + "\n"


def copied(rtest: Path, folder: Path) -> Path:
    """Copy what the case needs of r-test, build the controller, choose the wind; return the folder of the case."""
    root = next((each for each in (rtest / "glue-codes" / "openfast", rtest) if (each / CASE).is_dir()), None)
    if root is None:
        raise refused("--rtest", f"{rtest} holds no folder {CASE}: give a copy of OpenFAST's r-test")
    for name in (CASE, COMMON):
        unread = shutil.ignore_patterns("HydroData", "*.sum", "*.out*", "linux-*", "macos-*", "windows-*")
        shutil.copytree(root / name, folder / name, ignore=unread, dirs_exist_ok=True)
    case = folder / CASE
    main = case / f"{CASE}.fst"
    controller = case / value(case / value(main, "ServoFile"), "DLL_FileName")
    source = folder / COMMON / "ServoData" / "DISCON" / "DISCON.F90"
    if not controller.exists():
        options = ["-shared", "-fPIC", "-cpp", "-ffree-line-length-none", "-fdefault-real-8", "-DIMPLICIT_DLLEXPORT"]
        line = ["gfortran", *options, str(source.resolve()), "-o", str(controller.resolve())]
        if shutil.which(line[0]) is None or subprocess.run(line, cwd=folder, check=False).returncode:
            raise ResourceError(f"no controller: gfortran is missing or fails ({' '.join(line)})")
    inflow = case / value(main, "InflowFile")
    if not (inflow.parent / value(inflow, "FileName_BTS")).exists():
        print("wind: steady, 12 m/s, as the turbulent wind file of the test is not there")
        inflow.write_text(edit(inflow, {"WindType": 1, "HWindSpeed": 12}), errors="surrogateescape")
    return case


def base(case: Path) -> tuple[str, float, float, float]:
    """Return number and place [m] of the joint at the lower end of the monopile."""
    text = (case / value(case / f"{CASE}.fst", "SubFile")).read_text(encoding="utf-8", errors="surrogateescape")
    number = table(text, "NReact")[1][0].split()[0]
    place = next(row.split()[1:4] for row in table(text, "NJoints")[1] if row.split()[0] == number)
    x, y, z = map(float, place)
    return number, x, y, z


def write(case: Path, name: str, soil: str, inertia: Sequence[float], waves: float = 0.0) -> None:
    """Write NAME.fst and NAME_free.fst: in operation, and released. Without a file of SoilDyn it is clamped.

    inertia: mass of the bucket [kg], its inertia about x and y, and about z [kg m2]. Without the latter SubDyn 5.0.0
    leaves out the modes in which the base turns (`Nmodes` -1 retains all but six), and the reaction balances no load.
    """
    main = case / f"{CASE}.fst"
    sub, elastic, sea = (case / value(main, key) for key in ("SubFile", "EDFile", "SeaStFile"))
    values: dict[str, object] = {"OutFileFmt": 1, "OutFmt": '"ES15.7E2"', "SttsTime": 10, "RhoInf": 0.8}
    values |= {"MaxConvIter": 20, "HydroFile": '"fixed_HydroDyn.dat"', "SeaStFile": '"turned_SeaState.dat"'}
    (case / "turned_SeaState.dat").write_text(edit(sea, {"WaveDir": waves}))
    (case / "fixed_HydroDyn.dat").write_text(without_added_mass(case / value(main, "HydroFile")))
    if soil:
        number = base(case)[0]
        text = edit(sub, {"Nmodes": -1, "SttcSolve": False})
        text = table(text, "NReact", [f'{number} 0 0 0 0 0 0 ""'])[0]
        text = table(text, "NCmass", [" ".join([number, *(f"{inertia[k]:.6E}" for k in (0, 1, 1, 2)), *"000000"])])[0]
        (case / "bucket_SubDyn.dat").write_text(text)
        values |= {"CompSoil": 1, "SoilFile": f'"{soil}"', "SubFile": '"bucket_SubDyn.dat"'}
    (case / f"{name}.fst").write_text(edit(main, values))
    still = {"EDFile": '"free_ElastoDyn.dat"', "SeaStFile": '"free_SeaState.dat"'}
    parked = {"RotSpeed": 0, "GenDOF": False, "TTDspFA": BENT} | {f"BlPitch({k})": 90 for k in (1, 2, 3)}
    (case / "free_ElastoDyn.dat").write_text(edit(elastic, parked))
    (case / "free_SeaState.dat").write_text(edit(sea, {"WaveMod": 0}))
    off = dict.fromkeys(("CompInflow", "CompAero", "CompServo"), 0)
    (case / f"{name}_free.fst").write_text(edit(main, values | still | off))


def foundations(springs: str, folder: Path, at: str = "", **options: Any) -> dict[str, str]:
    """Write the files of SoilDyn and the library; return model -> file: matrix at rest, at a load, fan, memory."""
    source, files = Source(open_springs(springs)), dict[str, str]()
    if at:
        with TemporaryDirectory() as other:
            export(source, "openfast", other, at=at, **options)
            files["matrix at load"] = "soildyn_at_load.dat"
            shutil.copy(Path(other) / "soildyn.dat", folder / files["matrix at load"])
    for kind in ("fan", "memory") if has_memory(Springs.of(source.springs)) else ("fan",):
        export(source, "openfast", folder, springs=kind, **options)
        files[kind] = f"soildyn_{kind}.dat"
        (folder / "caisson.txt").replace(folder / f"{kind}.txt")
        text = (folder / "soildyn_nonlinear.dat").read_text()
        (folder / files[kind]).write_text(text.replace("./caisson.txt", f"./{kind}.txt"))
    build(folder)
    return files | {"matrix": "soildyn.dat"}


def run(program: str, folder: Path, name: str) -> dict[str, np.ndarray]:
    """Run OpenFAST on NAME.fst, with its log in NAME.log; return the channels.

    Raises
    ------
    RunIncomplete
        OpenFAST stops (the message has the end of the log), or goes on from steps that did not converge.
    """
    log = folder / f"{name}.log"
    with log.open("w") as out:
        done = subprocess.run([program, f"{name}.fst"], cwd=folder, stdout=out, stderr=out, check=False)
    text = log.read_text(errors="replace")
    if done.returncode:
        last = [line.strip() for line in text.splitlines() if line.strip()][-6:]
        raise RunIncomplete(f"{log}: OpenFAST stopped with {done.returncode}: {' | '.join(last)}")
    if count := text.count("Failed to converge"):
        raise RunIncomplete(f"{log}: {count} steps did not converge")
    lines = (folder / f"{name}.out").read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.split()[:1] == ["Time"])
    rows = np.array([[float(cell) for cell in line.split()] for line in lines[first + 2 :] if line.strip()])
    return dict(zip(lines[first].split(), rows.T, strict=True))


def mudline(channels: Channels) -> Channels:
    """Return time, motion of the tower top, and loads on the ground and motions of the lid at mudline, in SI units."""
    soil = "Sld1Fxg" in channels
    loads = [f"Sld1{each}g" if soil else f"-React{each.upper()}ss" for each in ("Fx", "Fy", "Fz", "Mx", "My")]
    scale = -1e3 if soil else 1.0
    found = {name: scale * channels[each] for name, each in zip(("H", "Hy", "Fz", "Mx", "M"), loads, strict=True)}
    zero = np.zeros_like(channels["Time"])
    lid = {"u": "Sld1TDxg", "uy": "Sld1TDyg", "roll": "Sld1RDxg", "rotation": "Sld1RDyg"}
    found |= {name: channels.get(each, zero) for name, each in lid.items()}
    found |= {name: np.radians(found[name]) for name in ("roll", "rotation")}
    return found | {"time": channels["Time"], "towertop": channels["TwHt1TPxi"]}


def frequency(time: Array, motion: Array) -> float:
    """Return the mean frequency [Hz] of a free vibration after START, by its upward crossings of the mean."""
    x = (motion - motion[time >= START].mean())[time >= START]
    at = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    crossings = time[time >= START][at] - x[at] / (x[at + 1] - x[at]) * (time[1] - time[0])
    return float((crossings.size - 1) / (crossings[-1] - crossings[0]))


def shares(springs: MacroModel, found: Channels, nonlinear: bool) -> tuple[str, str]:
    """Return utilisation of the load at the largest M, and share of the range at the largest motion of both planes."""
    size = np.hypot(np.hypot(found["u"], found["uy"]), np.hypot(found["rotation"], found["roll"]) * springs.length)
    most, turn = int(np.argmax(size)), np.hypot(found["rotation"], found["roll"])
    peak = int(np.argmax(np.abs(found["M"])))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MacroWarning)
        try:
            answer = predict(springs, H=float(found["H"][peak]), M=float(found["M"][peak]))
            used = f"{float(answer['utilisation']):.2f}"
        except (BeyondSprings, PredictionNotConverged):
            used = "not carried"
        if not nonlinear:
            return used, ""
        u = float(np.hypot(found["u"], found["uy"])[most])
        state = impose(springs, u=u, rotation=float(turn[most]), extrapolate=True)
        share = float(state["range_used"])
    return used, f"{share:.2f}" + (" BEYOND THE RANGE" if share > 1.0 else "")


def summary(springs: MacroModel, name: str, found: Channels, free: Channels, seconds: float) -> dict[str, str]:
    """Return quantity -> value of a model, of the run after START."""
    late, rows = found["time"] >= START, dict[str, str]()
    for key, (words, unit, digits) in QUANTITIES.items():
        series = unit * found[key][late]
        for kind, figure in (("mean", series.mean()), ("largest", np.abs(series).max())):
            rows[f"{words}, {kind}"] = f"{figure:.{digits}f}"
    used, share = shares(springs, found, name in ("fan", "memory"))
    return rows | {
        "V at mudline [MN], mean": f"{-1e-6 * found['Fz'][late].mean():.2f}",
        "first frequency, released [Hz]": f"{frequency(free['time'], free['towertop']):.4f}",
        "utilisation of the load at the largest M": used,
        "share of the range of the springs": share,
        "computing time [s]": f"{seconds:.0f}",
    }


def draw(found: Mapping[str, Channels], file: Path) -> None:
    """Draw the operation of all models."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 9.0), layout="constrained")
    for panel, key in zip(figure.subplots(len(SIGHTS), sharex=True), SIGHTS, strict=True):
        words, unit, _ = QUANTITIES[key]
        for colour, (name, each) in zip(COLOURS, found.items(), strict=False):
            panel.plot(each["time"], unit * each[key], color=colour, linewidth=1.1, label=name.replace("_", " "))
        panel.set_ylabel(words)
        panel.grid(alpha=0.3)
    panel.set_xlabel("time [s]")
    figure.axes[0].legend(ncols=len(found), loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    figure.savefig(file, dpi=130)


def main() -> None:
    """Write, run and compare the models."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("springs")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rtest", type=Path, required=True)
    parser.add_argument("--openfast", default=shutil.which("openfast"), required=shutil.which("openfast") is None)
    parser.add_argument("--waves", type=float, default=0.0)
    given = parser.parse_args()
    case = copied(given.rtest, given.folder)
    springs = model_of(open_springs(given.springs))
    found, answers = dict[str, Channels](), dict[str, dict[str, str]]()

    def operate(name: str, soil: str = "", inertia: Sequence[float] = ()) -> None:
        write(case, name, soil, inertia, given.waves)
        start = time.perf_counter()
        found[name] = mudline(run(given.openfast, case, name))
        seconds = time.perf_counter() - start
        free = mudline(run(given.openfast, case, f"{name}_free"))
        answers[name] = summary(springs, name, found[name], free, seconds)
        pd.DataFrame(answers).to_csv(given.folder / "turbine.csv", index_label="quantity", lineterminator="\n")
        draw(found, given.folder / "turbine.png")
        print(name, *(f"  {key:45} {each}" for key, each in answers[name].items()), sep="\n", flush=True)

    operate("clamped")
    late = found["clamped"]["time"] >= START
    H, M, Fz = (float(found["clamped"][key][late].mean()) for key in ("H", "M", "Fz"))
    mass = (springs.rest_load + Fz) / float(value(case / f"{CASE}.fst", "Gravity"))
    if mass < 0.0:
        raise refused(given.springs, f"their V is {1e-6 * springs.rest_load:.4g} MN, the turbine has {-1e-6 * Fz:.4g}")
    print(f"mass at the lid for the V of the springs: {mass:.0f} kg")
    radius = 0.5 * springs.attrs["outer_diameter_m"]
    place = dict(zip("xyz", base(case)[1:], strict=True))
    for name, soil in foundations(given.springs, case, f"H={H} N, M={M} N m", **place).items():
        operate(name.replace(" ", "_"), soil, (mass, mass * (radius**2 / 2 + springs.length**2 / 3), mass * radius**2))
        last, first = list(found.values())[-1], found["clamped"]
        largest = np.abs([first["H"], first["Hy"]]).max()
        for key, size in (("H", largest), ("Hy", largest), ("M", abs(M)), ("Mx", abs(M))):
            error = abs(last[key][late].mean() - first[key][late].mean()) / size
            if error > BALANCE:
                raise RunIncomplete(f"{name}: the mean {key} at mudline is {100 * error:.0f} % off: no balance")


if __name__ == "__main__":
    main()
