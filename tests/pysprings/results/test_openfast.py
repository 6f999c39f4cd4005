# SPDX-License-Identifier: MIT
"""The OpenFAST export: labels and matrix read back by the rules of the program, and SoilDyn's own driver."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.macro.stiffness_six import stiffness_six
from pysprings.results.exporters import export
from pysprings.results.exporters.openfast import labels
from pysprings.results.tables import open_table
from tests.support import synthetic, written
from tests.support.commands import command
from tests.support.vertical import vertical_springs

# `soildyn_driver` of OpenFAST 5.0.0, in the search path or named by this variable
DRIVER = os.environ.get("SOILDYN_DRIVER") or shutil.which("soildyn_driver")
TORSION = 2.5e9


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    export(vertical_springs(), "openfast", tmp_path, torsion=TORSION, x=1.5, y=-2.0, z=-30.0)
    return tmp_path


def read_ssi(file: Path) -> dict[str, float]:
    """Values by label, as SubDyn reads them: comments left out, labels in any case."""
    lines = [line.split() for line in file.read_text().splitlines() if line[0] not in "!#%"]
    return {label.lower(): float(value) for value, label in lines}


def matrix_of(values: dict[str, float], letter: str) -> np.ndarray:
    """Symmetric matrix of SubDyn's labels."""
    names = ("x", "y", "z", "tx", "ty", "tz")
    return np.array(
        [[values.get(f"{letter}{a}{b}", values.get(f"{letter}{b}{a}")) for b in names] for a in names], dtype=float
    )


def soildyn_matrix(file: Path) -> np.ndarray:
    return np.array([[float(cell) for cell in line.split()] for line in file.read_text().splitlines()[9:15]])


def test_all_labels_in_the_order_of_the_program(folder: Path) -> None:
    pairs = "xx xy yy xz yz zz xtx ytx ztx txtx xty yty zty txty tyty xtz ytz ztz txtz tytz tztz"
    order = [f"K{pair}" for pair in pairs.split()]
    assert [label for label, *_ in labels("K")] == order
    values = read_ssi(folder / "subdyn_ssi.dat")
    assert list(values) == [label.lower() for label in [*order, *(f"M{label[1:]}" for label in order)]]
    assert len(values) == 42
    assert not matrix_of(values, "m").any()


def test_the_matrix_holds_the_caisson_with_z_up(folder: Path) -> None:
    springs = vertical_springs()
    values = read_ssi(folder / "subdyn_ssi.dat")
    K = matrix_of(values, "k")
    np.testing.assert_array_equal(K, soildyn_matrix(folder / "soildyn.dat"))
    np.testing.assert_allclose(K, K.T)
    assert np.linalg.eigvalsh(K).min() > 0.0
    assert values["kxty"] < 0.0 < values["kytx"]  # a foundation below its joint
    assert (values["kxx"], values["kytx"], values["ktxtx"]) == (values["kyy"], -values["kxty"], values["ktyty"])
    assert values["ktztz"] == TORSION
    # the same motion in both frames does the same work: half a turn about x
    ours = stiffness_six(springs).values
    ours[5, 5] = TORSION
    for k in range(6):
        motion = np.eye(6)[k] + 0.3 * np.arange(6)
        turned = motion * [1.0, -1.0, -1.0, 1.0, -1.0, -1.0]
        assert turned @ K @ turned == pytest.approx(motion @ ours @ motion, rel=1e-12)


def test_the_header_names_origin_conditions_and_errors(folder: Path) -> None:
    springs = vertical_springs()
    for name in ("subdyn_ssi.dat", "soildyn.dat"):
        text = (folder / name).read_text()
        for words in (
            "written by pysprings", str(springs.attrs["scene_sha256"]), "z up", "N m/rad", "drainage: drained",
            "vertical load at rest: 2000 kN", "not cyclic", "range, path slide", "measured error, path slide",
            "error of the linear response, path turn (calibration)",
        ):  # fmt: skip
            assert words in text, (name, words)


def test_the_linear_error_is_that_of_the_matrix(tmp_path: Path) -> None:
    """On the recorded end of a translation: K u over H, less one."""
    springs = vertical_springs()
    remarks = export(springs, "openfast", tmp_path).remarks
    (line,) = [remark for remark in remarks if "path slide" in remark]
    path = springs["paths/slide"]
    K = springs["stiffness_initial"].values
    u, rotation, H = (float(path[name][-1]) for name in ("u", "rotation", "H"))
    error = 100.0 * (K[0, 0] * u + K[0, 2] * rotation - H) / abs(H)
    assert f"at u = {1e3 * u:.3g} mm" in line
    assert f"H {error:+.1f} %" in line.split("; ")[-1]


def test_missing_torsion_is_a_remark(tmp_path: Path) -> None:
    springs = synthetic.make_springs()
    assert any("Ktztz is 0" in remark for remark in export(springs, "openfast", tmp_path).remarks)
    assert not any("Ktztz" in remark for remark in export(springs, "openfast", tmp_path, torsion=1e9).remarks)


def test_springs_without_a_vertical_stiffness_are_refused(tmp_path: Path) -> None:
    table, _ = written.tables(tmp_path, synthetic.make_springs())
    with pytest.raises(UserInputError, match="no vertical stiffness"):
        export(open_table(table), "openfast", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_command(tmp_path: Path) -> None:
    export(vertical_springs(), "nc", tmp_path / "springs.nc")
    done = command("export", tmp_path, "--to", "openfast", "--option", "z=-30 m", "--option", "torsion=1 GN m/rad")
    assert done.code == 0, done.err
    assert done.out.split() == [str(tmp_path / "openfast" / name) for name in ("subdyn_ssi.dat", "soildyn.dat")]
    assert "note: linear: " in done.err
    assert "0 0 -30 " in (tmp_path / "openfast" / "soildyn.dat").read_text()


# --- the program itself ---


def run_driver(folder: Path, motions: np.ndarray) -> np.ndarray:
    """Reactions (n, 6) [N, N m] of `soildyn_driver` at motions (n, 6) [m, rad], one at each time step."""
    step = 0.01
    rows = [f"{step * k:.4f} " + " ".join(f"{value:.12e}" for value in row) for k, row in enumerate(motions)]
    (folder / "motion.txt").write_text("\n".join(rows) + "\n")
    lines = (
        "driver", "test", "-----", "False Echo", "-----", '"soildyn.dat" SlDIptFile', "0 TStart", "DEFAULT DT",
        "DEFAULT NumTimeSteps", "False StiffMatOut", "False NonLinear", '"motion.txt" InputDispFile',
    )  # fmt: skip
    (folder / "driver.inp").write_text("\n".join(lines) + "\n")
    done = subprocess.run([str(DRIVER), "driver.inp"], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    (out,) = folder.glob("*.out")
    text = out.read_text().splitlines()
    first = next(k for k, line in enumerate(text) if line.split()[:1] == ["Time"])
    table = np.array([[float(cell) for cell in line.split()] for line in text[first + 2 :] if line.strip()])
    at = np.rint(table[:, 0] / step).astype(int)
    assert (np.diff(at) == 1).all()
    return 1e3 * table[:, 1:7]  # from kN


@pytest.mark.skipif(DRIVER is None, reason="soildyn_driver is not installed (SOILDYN_DRIVER names it)")
def test_soildyn_reacts_with_the_matrix_in_all_directions(folder: Path) -> None:
    K = soildyn_matrix(folder / "soildyn.dat")
    size = np.array([1e-3, 1e-3, 1e-3, 1e-6, 1e-6, 1e-6])
    motions = np.concatenate([np.diag(size), -np.diag(size), np.random.default_rng(1).uniform(-1, 1, (20, 6)) * size])
    motions = np.concatenate([np.zeros((1, 6)), motions])
    reactions = run_driver(folder, motions)
    assert len(reactions) >= len(motions)  # the driver adds a step behind the last one
    expected = -motions @ K.T  # SoilDyn returns the action of the soil
    np.testing.assert_allclose(reactions[: len(motions)], expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
