# SPDX-License-Identifier: MIT
"""A short, stiff tower on a foundation for SubDyn's driver: its input files, run with imposed motions of its top."""

import subprocess
from pathlib import Path

import numpy as np

from tests.support.openfast import program

BASE, TOP = -30.0, -20.0  # m
MEMBER = "1 1 2 1 1 1c 0.0"


def tower(reaction: str, ground: str = "", member: str = "", spring: str = "", cosines: str = "") -> str:
    """Return a SubDyn file: the line of the base reaction joint, and the rows of a spring element where it has one."""
    joints = [f"1 0 0 {BASE} 1 0 0 0 0", f"2 0 0 {TOP} 1 0 0 0 0", *filter(None, [ground])]
    members = [MEMBER, *filter(None, [member])]
    lines = [
        "SubDyn input", "a stiff tower", "--- SIMULATION CONTROL ---", "True Echo", '"DEFAULT" SDdeltaT', "3 IntMethod",
        "False SttcSolve", "--- FEA ---", "3 FEMMod", "1 NDiv", "0 Nmodes", "2 JDampings", "0 GuyanDampMod",
        "0 0 RayleighDamp", "6 GuyanDampSize", *["0 0 0 0 0 0"] * 6,
        "--- INITIAL RIGID-BODY POSITION ---", "x y z rx ry rz", "(m)", "0 0 0 0 0 0",
        "--- JOINTS ---", f"{len(joints)} NJoints", "ID x y z type dx dy dz k", "(-)", *joints,
        "--- BASE REACTION JOINTS ---", "1 NReact", "ID x y z rx ry rz SSI", "(-)", reaction,
        "--- INTERFACE JOINTS ---", "1 NInterf", "ID TPID x y z rx ry rz", "(-)", "2 1 1 1 1 1 1 1",
        "--- MEMBERS ---", f"{len(members)} NMembers", "ID J1 J2 P1 P2 type spin", "(-)", *members,
        "--- CIRCULAR BEAMS ---", "1 NPropSetsCyl", "ID E G rho D t", "(-)", "1 2.1E18 8.0E17 10.0 6.0 0.1",
        "--- RECTANGULAR BEAMS ---", "0 NPropSetsRec", "ID", "(-)",
        "--- ARBITRARY BEAMS ---", "0 NXPropSets", "ID", "(-)", "--- CABLES ---", "0 NCablePropSets", "ID", "(-)",
        "--- RIGID LINKS ---", "0 NRigidPropSets", "ID", "(-)",
        "--- SPRINGS ---", f"{int(bool(spring))} NSpringPropSets", "ID", "(-)", *filter(None, [spring]),
        "--- COSINES ---", f"{int(bool(cosines))} NCOSMs", "ID", "(-)", *filter(None, [cosines]),
        "--- MASSES ---", "0 NCmass", "ID", "(-)",
        "--- OUTPUT ---", "False SumPrint", "0 OutCBModes", "0 OutFEMModes", "False OutCOSM", "False OutAll",
        "1 OutSwtch", "False TabDelim", "1 OutDec", '"ES20.12e2" OutFmt', '"A20" OutSFmt', "--- MEMBER OUTPUT ---",
        "0 NMOutputs", "ID", "(-)", "--- OutList ---",
        '"IntfFXss, IntfFYss, IntfFZss, IntfMXss, IntfMYss, IntfMZss"', "END",
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def interface_loads(folder: Path, name: str, motion: np.ndarray) -> np.ndarray:
    """Return the loads (6,) [N, N m] of the top of the tower at an imposed motion (6,) [m, rad] of it."""
    zero = "0 0 0 0 0 0"
    lines = [
        "SubDyn driver", "test", "False Echo", "--- ENVIRONMENT ---", "0.0 Gravity", "30.0 WtrDpth", "--- SubDyn ---",
        f'"{name}.dat" SDInputFile', f'"{name}" OutRootName', "20 NSteps", "0.01 TimeInterval",
        "1 nTP", "0 TPx", "0 TPy", f"{TOP} TPz", "0 SubRotateZ", "--- INPUTS ---",
        "1 InputsMod", '"" InputsFile', "--- STEADY ---",
        " ".join(f"{value:.15e}" for value in motion), zero, zero,
        "--- FORCES ---", "0 nAppliedLoads", "ID", "(-)", "END",
    ]  # fmt: skip
    (folder / f"{name}.dvr").write_text("\n".join(lines) + "\n")
    done = subprocess.run(
        [program("subdyn_driver"), f"{name}.dvr"], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-2000:]
    text = (folder / f"{name}.SD.out").read_text().splitlines()
    last = [float(cell) for cell in text[-1].split()]
    return np.array(last[1:7])
