# SPDX-License-Identifier: MIT
"""ParaView files of a run that kept the whole model: a `.pvd` for each path, a `.vtu` for each step."""

import base64
import re
import sys
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import xarray as xr

from pysprings.core.errors import refused
from pysprings.core.variables import STRESSES
from pysprings.results.exporters.base import Exported, Options, Source, Target
from pysprings.springs.path import paths_of

_TYPES = {"float32": "Float32", "float64": "Float64", "int32": "Int32", "int8": "Int8", "uint8": "UInt8"}
_HEXAHEDRON = 12  # VTK's number of the cell; its corners are in the order of ours


def write(source: Source, target: Target, _options: Options) -> Exported:
    """Write the files of all paths of a result with a group `volume` into a folder; name the `.pvd` files.

    A step file that the `.pvd` before this one lists, and this one does not, is removed.
    """
    if "volume" not in source.result.children:
        raise refused("paraview", "holds no whole model: run the scene with [output] paraview = true")
    mesh = source.result.children["volume"].to_dataset(inherit=False)
    target.path.mkdir(parents=True, exist_ok=True)
    paths = paths_of(source.result).items()
    return Exported([_write_path(mesh, path.recorded, name, target) for name, path in paths])


def _write_path(mesh: xr.Dataset, path: xr.Dataset, name: str, target: Target) -> Path:
    """Write every step of a path and the list of them."""
    for old in _steps_listed(target.path, name):
        old.unlink(missing_ok=True)  # of a longer run
    time, rows = path["time"].values, []
    timed = bool(np.all(np.diff(time) > 0.0))
    for step in range(path.sizes["step"]):
        file = target.write(f"{name}_{step:04d}.vtu", _grid(mesh, path.isel(step=step)))
        when = float(time[step]) if timed else float(step)
        rows.append(f'<DataSet timestep="{when:.9g}" group="" part="0" file={quoteattr(file.name)}/>')
    body = "\n".join(rows)
    return target.write(f"{name}.pvd", _wrapped("Collection", f"<Collection>\n{body}\n</Collection>"))


def _steps_listed(folder: Path, name: str) -> list[Path]:
    """Return the step files of a path that its `.pvd` in a folder lists."""
    try:
        text = (folder / f"{name}.pvd").read_text(encoding="utf-8")
    except (OSError, ValueError):
        return []
    return [folder / name_of_step for name_of_step in re.findall(rf'file="({re.escape(name)}_\d{{4,}}\.vtu)"', text)]


def _wrapped(kind: str, body: str) -> str:
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    head = f'<VTKFile type="{kind}" version="1.0" byte_order="{order}" header_type="UInt64">'
    return f'<?xml version="1.0"?>\n{head}\n{body}\n</VTKFile>\n'


def _grid(mesh: xr.Dataset, state: xr.Dataset) -> str:
    """Return one step as XML."""
    points = np.stack([mesh[f"volume_{axis}"].values for axis in "xyz"], axis=1)
    cells = mesh["volume_hex"].transpose("volume_cell", "vertex").values.astype(np.int32)
    move = np.stack([state[f"volume_u{axis}"].values for axis in "xyz"], axis=1)
    at_nodes = {"displacement_m": move, "gap_m": state["volume_gap"].values}
    if "volume_pore_pressure" in state:
        at_nodes["pore_pressure_Pa"] = state["volume_pore_pressure"].values
    stress = np.stack([state[f"volume_s{name}"].values for name in STRESSES], axis=1)
    in_cells = {
        "effective_stress_Pa": stress,
        "plastic_strain": state["volume_plastic_strain"].values,
        "steel": mesh["volume_steel"].values,
    }
    n = len(cells)
    topology = (
        _array("connectivity", cells.ravel()),
        _array("offsets", 8 * np.arange(1, n + 1, dtype=np.int32)),
        _array("types", np.full(n, _HEXAHEDRON, dtype=np.uint8)),
    )
    parts = (
        _section("PointData", [_array(name, values) for name, values in at_nodes.items()]),
        _section("CellData", [_array(name, values) for name, values in in_cells.items()]),
        _section("Points", [_array("points", points)]),
        _section("Cells", topology),
    )
    piece = f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{n}">\n' + "\n".join(parts) + "\n</Piece>"
    return _wrapped("UnstructuredGrid", f"<UnstructuredGrid>\n{piece}\n</UnstructuredGrid>")


def _section(name: str, arrays: list[str] | tuple[str, ...]) -> str:
    return "\n".join([f"<{name}>", *arrays, f"</{name}>"])


def _array(name: str, values: np.ndarray) -> str:
    """Return one array as XML; stresses have their components named, in VTK's order of a symmetric tensor."""
    width = values.shape[1] if values.ndim == 2 else 1
    names = "".join(f' ComponentName{i}="{label.upper()}"' for i, label in enumerate(STRESSES)) if width == 6 else ""
    data = np.ascontiguousarray(values)
    text = base64.b64encode(np.uint64(data.nbytes).tobytes() + data.tobytes()).decode("ascii")
    kind = _TYPES[data.dtype.name]
    return (
        f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}"{names} format="binary">{text}</DataArray>'
    )
