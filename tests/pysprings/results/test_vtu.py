# SPDX-License-Identifier: MIT
"""ParaView files: read back number by number, by an XML parser and by VTK where it is installed."""

import base64
import json
import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import UserInputError
from pysprings.full_model.compute import compute
from pysprings.model.build import build_model
from pysprings.results.exporters import export
from pysprings.results.folder import run_to_folder
from tests.support import tiny
from tests.support.commands import command

SCENE = {
    "caisson": {"behaviour": "elastic"},
    "drainage": {"mode": "coupled"},
    "output": {"paraview": True, "figures": False},
    "paths": (tiny.PULL | {"rate": 5e-5},),
}


@cache
def result() -> xr.DataTree:
    return compute(tiny.scene(**SCENE)).recorded()


def read(file: Path) -> dict[str, np.ndarray]:
    """Arrays of a `.vtu` by name."""
    found = {}
    for array in ET.parse(file).getroot().iter("DataArray"):
        data = base64.b64decode(array.text or "")
        size = int(np.frombuffer(data[:8], np.uint64)[0])
        assert size == len(data) - 8
        values = np.frombuffer(data[8:], np.dtype(array.attrib["type"].lower()))
        width = int(array.attrib["NumberOfComponents"])
        found[array.attrib["Name"]] = values.reshape(-1, width) if width > 1 else values
    return found


def test_files_hold_the_model(tmp_path: Path) -> None:
    (listed,) = export(result(), "paraview", tmp_path).files
    assert listed.name == "pull.pvd"
    steps = ET.parse(listed).getroot().findall("Collection/DataSet")
    path = result()["paths/pull"].to_dataset()
    assert len(steps) == path.sizes["step"]
    times = [float(step.attrib["timestep"]) for step in steps]
    np.testing.assert_allclose(times, path["time"], rtol=1e-6)
    last = read(tmp_path / steps[-1].attrib["file"])
    built = build_model(tiny.scene(**SCENE))
    assert built.steel is not None
    nodes, first = built.model.mesh.nodes, built.caisson.mesh.n_nodes
    np.testing.assert_array_equal(last["points"], nodes)
    cells = last["connectivity"].reshape(-1, 8)
    np.testing.assert_array_equal(cells, np.vstack([built.model.mesh.hexes, built.steel.hexes]))
    np.testing.assert_array_equal(last["steel"], np.repeat([0, 1], [len(built.model.mesh.hexes), 26]))
    move = last["displacement_m"]
    # the patch of the lid moves with u, w, rotation; the soil's far side not across it
    held = built.steel.held
    u, w, turn = (float(path[name][-1]) for name in ("u", "w", "rotation"))
    np.testing.assert_allclose(move[held, 0], u - turn * nodes[held, 2], rtol=1e-5)
    np.testing.assert_allclose(move[held, 2], w + turn * nodes[held, 0], rtol=1e-4, atol=1e-9)
    side = built.caisson.mesh.node_sets["side"]
    radial = (move[side, :2] * nodes[side, :2]).sum(axis=1)
    assert np.abs(radial).max() < 1e-6 * np.abs(move[side]).max() * np.abs(nodes[side]).max()
    soil = last["steel"] == 0
    assert np.isfinite(last["effective_stress_Pa"][soil]).all() and np.isnan(last["effective_stress_Pa"][~soil]).all()
    assert last["plastic_strain"].max() > 0.0 == last["plastic_strain"][~soil].max()
    assert np.abs(last["pore_pressure_Pa"][:first]).max() > 10.0
    assert (last["pore_pressure_Pa"][first:] == 0.0).all()
    assert float(last["gap_m"].max()) == pytest.approx(
        max(float(path[name].isel(step=-1).max()) for name in ("gap", "lid_gap", "tip_gap")), rel=1e-6
    )


def test_the_section_is_in_the_volume() -> None:
    path = result()["paths/pull"].to_dataset()
    volume, section = result()["volume"].to_dataset(), result()["section"].to_dataset()
    at = {tuple(np.round(p, 6)): i for i, p in enumerate(zip(volume["volume_x"].values, volume["volume_z"].values,
          strict=True)) if abs(float(volume["volume_y"][i])) < 1e-9 and i < len(volume["volume_x"])}  # fmt: skip
    assert len(at) > 20
    ux = dict(zip(zip(section["section_x"].values, section["section_depth"].values, strict=True),
                  path["section_ux"].values[-1], strict=True))  # fmt: skip
    far = [point for point in ux if abs(point[0]) > 8.0]
    for point in far:
        found = path["volume_ux"].values[-1][at[tuple(np.round(point, 6))]]
        assert found == pytest.approx(ux[point], rel=1e-5, abs=1e-12)


def test_elastic_soil_has_no_plastic_strain_in_the_volume() -> None:
    """It keeps no history at all."""
    elastic = compute(tiny.scene(soil={"yield_surface": "elastic"}, output=SCENE["output"])).recorded()
    strain = elastic["paths/pull"]["volume_plastic_strain"].values
    assert strain.shape == (elastic["paths/pull"].sizes["step"], build_model(tiny.scene()).model.mesh.n_elements)
    assert not strain.any()


def test_a_result_without_the_whole_model_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserInputError, match=r"run the scene with \[output\] paraview = true"):
        export(tiny.result(), "paraview", tmp_path)
    assert "volume" not in tiny.result().children


@pytest.mark.slow
def test_run_and_export_write_them_and_a_new_run_clears_them(tmp_path: Path) -> None:
    scene = tiny.scene(output={"paraview": True, "figures": False})
    folder = run_to_folder(scene, tmp_path / "out")
    files = {file.name for file in (folder / "paraview").iterdir()}
    assert {"pull.pvd", "pull_0000.vtu"} <= files
    done = command("export", str(folder), "--to", "paraview", "--out", str(tmp_path / "again"))
    assert done.code == 0, done.err
    for name in files:
        assert (tmp_path / "again" / name).read_bytes() == (folder / "paraview" / name).read_bytes()
    assert json.loads((folder / "run.json").read_text())["status"] == "complete"
    run_to_folder(tiny.scene(), folder)
    assert not list((folder / "paraview").iterdir())


def test_vtk_reads_them(tmp_path: Path) -> None:
    vtk = pytest.importorskip("vtk", reason="vtk is not installed")
    export(result(), "paraview", tmp_path)
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(sorted(tmp_path.glob("pull_*.vtu"))[-1]))
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetNumberOfPoints() == result()["volume"].sizes["volume_node"]
    assert grid.GetCellType(0) == vtk.VTK_HEXAHEDRON
    assert grid.GetCellData().GetArray("effective_stress_Pa").GetComponentName(3) == "XY"
