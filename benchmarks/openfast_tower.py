# SPDX-License-Identifier: MIT
"""A plain tower on one bucket in OpenFAST: 60 s of free vibration on nonlinear foundations and on their matrix.

    python -m benchmarks.openfast_tower SPRINGS DIR [--openfast PROGRAM]

SPRINGS has a fan of load paths (template `fan`), and elements with memory where `[springs] memory = true`. DIR gets the
input files of all models (they differ in the file of SoilDyn), and the output of OpenFAST. The tower is a tube of 60 m
between sea bed and its top, with a mass on it; it is pulled aside and released. Gravity is 0, the reaction at rest is
left out: all foundations start at the same state.
"""

import argparse
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from pysprings import open_springs
from pysprings.core.errors import RunIncomplete
from pysprings.memory.build import has_memory
from pysprings.results.exporters import Source, export
from pysprings.results.exporters.soildyn.library import build
from pysprings.springs.springs import Springs

DEPTH, TOP, SECONDS, STEP = 30.0, 10.0, 60.0, 0.01  # m, m, s, s
NACELLE, PUSH = 250e3, 0.10  # kg on the tower, m of its platform at the start
ELASTODYN = (
    "-- ElastoDyn", "tower on a bucket", "-- simulation", "False Echo", "3 Method", '"DEFAULT" DT', "-- freedom",
    *[f"False {name}" for name in (
        "FlapDOF1", "FlapDOF2", "EdgeDOF", "PitchDOF", "TeetDOF", "DrTrDOF", "GenDOF", "YawDOF", "TwFADOF1", "TwFADOF2",
        "TwSSDOF1", "TwSSDOF2")],
    *[f"True {name}" for name in ("PtfmSgDOF", "PtfmSwDOF", "PtfmHvDOF", "PtfmRDOF", "PtfmPDOF", "PtfmYDOF")],
    "-- initial", "0 OoPDefl", "0 IPDefl", *["0 BlPitch"] * 3, "0 TeetDefl", "0 Azimuth", "0 RotSpeed", "0 NacYaw",
    "0 TTDspFA", "0 TTDspSS", "{push} PtfmSurge", "0 PtfmSway", "0 PtfmHeave", "0 PtfmRoll",
    "{tilt} PtfmPitch", "0 PtfmYaw",
    "-- turbine", "3 NumBl", "10 TipRad", "1 HubRad", *["0 PreCone"] * 3, "0 HubCM", "0 UndSling", "0 Delta3",
    "0 AzimB1Up",
    "-5 OverHang", "0 ShftGagL", "0 ShftTilt", "0 NacCMxn", "0 NacCMyn", "0 NacCMzn", "0 NcIMUxn", "0 NcIMUyn",
    "0 NcIMUzn",
    "1 Twr2Shft", "30 TowerHt", "10 TowerBsHt", "0 PtfmCMxt", "0 PtfmCMyt", "10 PtfmCMzt", "0 PtfmRefxt", "0 PtfmRefyt",
    "10 PtfmRefzt", "-- mass", *["0 TipMass"] * 3, *["200 PBrIner"] * 3, *["28578 BlPIner"] * 3, "1 HubMass",
    "1 HubIner",
    "0 HubIner_Teeter", "1 GenIner", "{mass} NacMass", "1E6 NacYIner", "0 YawBrMass", "1E4 PtfmMass", "1E5 PtfmRIner",
    "1E5 PtfmPIner", "1E5 PtfmYIner", "0 PtfmXYIner", "0 PtfmYZIner", "0 PtfmXZIner", "-- blade", "5 BldNodes",
    *['"blade.dat" BldFile'] * 3, "-- teeter", "0 TeetMod", *["0 Teet"] * 7, "-- yaw friction", "0 YawFrctMod",
    *["0 friction"] * 8, "0.1 OmgCut", "-- drivetrain", "100 GBoxEff", "1 GBRatio", "1E8 DTTorSpr", "1E6 DTTorDmp",
    "-- furling", "False Furling", '"unused" FurlFile', "-- tower", "5 TwrNodes", '"tower.dat" TwrFile', "-- output",
    "False SumPrint", "1 OutFile", "True TabDelim", '"ES15.7" OutFmt', "0 Tstart", "1 DecFact", "0 NTwGages",
    "0 TwrGagNd",
    "0 NBlGages", "0 BldGagNd", "-- OutList", '"PtfmSurge, PtfmPitch"', "END of output",
)  # fmt: skip
BLADE = (
    "-- ElastoDyn blade", "light and stiff", "-- parameters", "2 NBlInpSt", "1 BldFlDmp1", "1 BldFlDmp2", "1 BldEdDmp1",
    "-- factors", "1 FlStTunr1", "1 FlStTunr2", "1 AdjBlMs", "1 AdjFlSt", "1 AdjEdSt", "-- properties",
    "BlFract PitchAxis StrcTwst BMassDen FlpStff EdgStff", "(-) (-) (deg) (kg/m) (Nm^2) (Nm^2)", "0 0.25 0 1 1E12 1E12",
    "1 0.25 0 1 1E12 1E12", "-- modes",
    *[f"{value} {name}({k})" for name in ("BldFl1Sh", "BldFl2Sh", "BldEdgSh") for k, value in zip(
        range(2, 7), (1, 0, 0, 0, 0), strict=True)],
)  # fmt: skip
TOWER = (
    "-- ElastoDyn tower", "light and stiff", "-- parameters", "2 NTwInpSt", *["1 TwrDmp"] * 4, "-- factors",
    *["1 StTunr"] * 4, "1 AdjTwMa", "1 AdjFASt", "1 AdjSSSt", "-- properties", "HtFract TMassDen TwFAStif TwSSStif",
    "(-) (kg/m) (Nm^2) (Nm^2)", "0 3000 1E13 1E13", "1 3000 1E13 1E13",
    *[line for part in ("fore-aft", "side-to-side") for line in (f"-- {part}", *["1 Sh(2)", *["0 Sh"] * 4] * 2)],
    "-- masses", "0 NTwCMass", "HtFract mass", "(-) (kg)",
)  # fmt: skip
SUBDYN = (
    "-- SubDyn", "a tube", "-- simulation", "False Echo", '"DEFAULT" SDdeltaT', "3 IntMethod",
    "False SttcSolve", "-- FEA",
    "3 FEMMod", "2 NDiv", "6 Nmodes", "2 JDampings", "0 GuyanDampMod", "0 0 RayleighDamp", "6 GuyanDampSize",
    *["0 0 0 0 0 0"] * 6, "-- position", "x y z rx ry rz", "(m)", "0 0 0 0 0 0", "-- joints", "2 NJoints",
    "ID x y z type dx dy dz k", "(-)", f"1 0 0 {-DEPTH} 1 0 0 0 0", f"2 0 0 {TOP} 1 0 0 0 0", "-- base", "1 NReact",
    "ID x y z rx ry rz SSI", "(-)", "1 0 0 0 0 0 0", "-- interface", "1 NInterf", "ID TP x y z rx ry rz", "(-)",
    "2 1 1 1 1 1 1 1", "-- members", "1 NMembers", "ID J1 J2 P1 P2 type spin", "(-)", "1 1 2 1 1 1c 0.0", "-- circular",
    "1 NPropSetsCyl", "ID E G rho D t", "(-)", "1 2.1E11 8.08E10 7850.0 6.0 0.06", "-- rectangular", "0 N", "ID", "(-)",
    "-- arbitrary", "0 N", "ID", "(-)", "-- cables", "0 N", "ID", "(-)", "-- rigid", "0 N", "ID", "(-)",
    "-- springs", "0 N",
    "ID", "(-)", "-- cosines", "0 N", "ID", "(-)", "-- masses", "0 N", "ID", "(-)", "-- output", "False SumPrint",
    "0 OutCBModes", "0 OutFEMModes", "False OutCOSM", "False OutAll", "2 OutSwtch", "False TabDelim", "1 OutDec",
    '"ES15.7e2" OutFmt', '"A15" OutSFmt', "-- members", "0 NMOutputs", "ID", "(-)", "-- OutList",
    '"IntfFXss, IntfMYss"', "END",
)  # fmt: skip


def primary(soil: str) -> Iterable[str]:
    """Yield the lines of OpenFAST's own input file with a file of SoilDyn."""
    files = ['"elastodyn.dat" EDFile', *['"unused" BDBldFile'] * 3, *['"unused" File'] * 5, '"subdyn.dat" SubFile']
    return (
        "-- OpenFAST", "a tower on a bucket", "-- simulation", "False Echo", '"FATAL" AbortLevel', f"{SECONDS} TMax",
        f"{STEP} DT", "3 ModCoupling", "2 InterpOrder", "0 NumCrctn", "0.8 RhoInf", "1E-5 ConvTol", "20 MaxConvIter",
        "0.5 DT_UJac", "1E6 UJacSclFact", "-- switches", "1 NRotors", "1 CompElast", "0 CompInflow", "0 CompAero",
        "0 CompServo", "0 CompSeaSt", "0 CompHydro", "1 CompSub", "0 CompMooring", "0 CompIce", "1 CompSoil", "0 MHK",
        "False MirrorRotor", "-- environment", "0.0 Gravity", "1.225 AirDens", "1025 WtrDens", "1.464E-5 KinVisc",
        "335 SpdSound", "103500 Patm", "1700 Pvap", f"{DEPTH} WtrDpth", "0 MSL2SWL", "-- files",
    *files, '"unused" MooringFile',
        '"unused" IceFile', f'"{soil}" SoilFile', "-- output", "False SumPrint", "10 SttsTime", "99999 ChkptTime",
        '"default" DT_Out', "0 TStart", "1 OutFileFmt", "True TabDelim", '"ES15.7E2" OutFmt', "-- linearization",
        "False Linearize", "False CalcSteady", "3 TrimCase", "0.001 TrimTol", "0.01 TrimGain", "0 Twr_Kdmp",
    "0 Bld_Kdmp",
        "2 NLinTimes", "30, 60 LinTimes", "1 LinInputs", "1 LinOutputs", "False LinOutJac", "False LinOutMod",
        "-- visualization", "0 WrVTK", "2 VTK_Type", "False VTK_fields", "15 VTK_fps",
    )  # fmt: skip


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


def write(springs: str, folder: Path) -> list[str]:
    """Write all models; return their names."""
    soils = foundations(springs, folder, z=-DEPTH, reaction_at_rest="none")
    parts = {"elastodyn.dat": ELASTODYN, "blade.dat": BLADE, "tower.dat": TOWER, "subdyn.dat": SUBDYN}
    parts |= {f"{name}.fst": primary(file) for name, file in soils.items()}
    values = {"{push}": f"{PUSH}", "{tilt}": "0.05", "{mass}": f"{NACELLE}"}
    for name, lines in parts.items():
        text = "\n".join(lines) + "\n"
        for key, value in values.items():
            text = text.replace(key, value)
        (folder / name).write_text(text)
    return list(soils)


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
    return read(folder / f"{name}.out")


def read(file: Path) -> dict[str, np.ndarray]:
    """Return the channels of an output file of OpenFAST."""
    lines = file.read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.split()[:1] == ["Time"])
    rows = np.array([[float(cell) for cell in line.split()] for line in lines[first + 2 :] if line.strip()])
    return dict(zip(lines[first].split(), rows.T, strict=True))


def main() -> None:
    """Write, run and compare the models."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("springs")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--openfast", default=shutil.which("openfast"))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    names = write(given.springs, given.folder)
    for name in names if given.openfast else ():
        print(name)
        for key, values in run(given.openfast, given.folder, name).items():
            if key != "Time":
                print(f"  {key:10} largest {np.abs(values).max():.5g}, last 10 s {np.abs(values[-1000:]).max():.5g}")


if __name__ == "__main__":
    main()
