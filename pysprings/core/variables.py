# SPDX-License-Identifier: MIT
"""One table: what every variable of the result and of the springs means, its units, dimensions and sign.

Axes: x = loading direction, z = depth, down from mudline, y = out of the symmetry plane. Rotation and M are positive
where the caisson leans towards +x. Reference point of the rigid body: lid centre at the mudline. Loads and reactions
are those of the whole caisson. Soil reactions oppose positive displacements: their sum is the applied load. Units are
UDUNITS text, as the CF conventions require.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import xarray as xr

TreeKind = Literal["result", "springs"]

SIDES = ("outside", "inside")
COMPONENTS = ("normal", "shear", "water")
DOFS = ("u", "w", "rotation")

TORSION = "torsional_stiffness_Nm_per_rad"  # attribute of results and springs: of the full model at rest

_OPPOSES = "soil reaction, positive when it opposes a positive displacement"
_CONJUGATE = "work conjugate of rotation, about the lid centre at mudline; a load H at height h has M = H*h"
_FIELD = ("step", "side", "azimuth", "depth")


def known_torsion(attrs: Mapping[Any, Any]) -> float | None:
    """Return the torsional stiffness [N m/rad] in the attributes of a result or of springs; None where it has none."""
    value = attrs.get(TORSION)
    return float(value) if isinstance(value, int | float) and 0.0 < value < math.inf else None


@dataclass(frozen=True, slots=True)
class Variable:
    """Meaning of one variable: name, words, units (UDUNITS), dimensions in order, sign."""

    name: str
    long_name: str
    units: str
    dims: tuple[str, ...]
    comment: str = ""
    attrs: Mapping[str, str] = field(default_factory=dict)
    required: bool = True

    def attributes(self) -> dict[str, str]:
        """Return the NetCDF attributes of the variable."""
        attrs = {"long_name": self.long_name, "units": self.units, **self.attrs}
        if self.comment:
            attrs["comment"] = self.comment
        return attrs


def _table(*variables: Variable) -> dict[str, Variable]:
    return {variable.name: variable for variable in variables}


V = Variable

# fmt: off

_AXES = _table(
    V("depth", "depth below mudline", "m", ("depth",),
      "where the forces of a slice act: at its ring of stations, or in its middle (series; beside a layer boundary)",
      {"standard_name": "depth", "positive": "down", "axis": "Z", "bounds": "depth_bounds"}),
    V("depth_bounds", "top and bottom of the slice that belongs to each depth", "m", ("depth", "bound"),
      "the slices touch and cover the skirt from 0 to its length"),
    V("side", "side of the skirt", "1", ("side",), "outside or inside (soil plug)"),
    V("component", "part of the reaction", "1", ("component",),
      "normal: effective contact stress; shear: friction; water: pore-water pressure"),
)

_BODY = _table(
    V("u", "lateral displacement of the lid centre", "m", ("step",),
      "positive along +x, the loading direction"),
    V("w", "vertical displacement of the lid centre", "m", ("step",), "positive down; heave is negative"),
    V("rotation", "rotation of the caisson (of the lid's centre where it is elastic)", "radian", ("step",),
      "positive where the caisson leans towards +x: u(z) = u - rotation*z"),
    V("H", "lateral load on the caisson", "N", ("step",), "positive along +x; whole caisson"),
    V("V", "vertical load on the caisson", "N", ("step",),
      "positive down; whole caisson; constant dead load included"),
    V("M", "moment on the caisson about the lid centre at mudline", "N m", ("step",), _CONJUGATE),
    V("converged", "1 where the step converged, 0 where it did not", "1", ("step",)),
)


def _resultants(part: str, words: str, about: str) -> tuple[Variable, ...]:
    return (
        V(f"H_{part}", f"lateral force on {words}", "N", ("step",), _OPPOSES),
        V(f"V_{part}", f"vertical force on {words}", "N", ("step",),
          _OPPOSES + " (downwards); initial force included"),
        V(f"M_{part}", f"moment on {words}", "N m", ("step",), f"{about}; sum of f_z*x - f_x*z"),
    )


_TIP = _resultants("tip", "the skirt tip", "about the axis point at the depth of the tip")
_LID = _resultants("lid", "the underside of the lid", "about the lid centre")
_SKIRT = _resultants("outer", "the outer face of the skirt", "about the lid centre") + _resultants(
    "inner", "the inner face of the skirt", "about the lid centre"
)

_Y = V("y", "lateral displacement of the mean fibre", "m", ("depth", "step"),
       "positive along +x; u - rotation*depth of a rigid caisson, the mean around the section of an elastic one; NaN "
       "in an answer of springs of an elastic caisson")


def _slices() -> tuple[Variable, ...]:
    mean = {"cell_methods": "depth: mean"}
    return (
        V("p", "lateral soil reaction per metre of depth, both sides together", "N m-1", ("depth", "step"), _OPPOSES,
          mean),
        V("p_component", "lateral soil reaction per metre of depth", "N m-1", ("depth", "side", "component", "step"),
          _OPPOSES, mean),
        V("m", "distributed moment of the vertical shear per metre of depth", "N m m-1",
          ("depth", "side", "step"),
          "sum of f_z*x; opposes a positive rotation; about the axis of the caisson", mean),
        V("t", "vertical soil reaction per metre of depth", "N m-1", ("depth", "side", "step"),
          "positive when the caisson pulls the soil down; initial shear included", mean),
        _Y,
    )


def _patch(part: str, words: str) -> tuple[Variable, ...]:
    point = f"{part}_point"
    return (
        V(f"{part}_x", f"x of the stations under {words}", "m", (point,), "along the loading direction"),
        V(f"{part}_y", f"y of the stations under {words}", "m", (point,),
          "out of the symmetry plane, half model"),
        V(f"{part}_normal_effective_stress", f"effective normal stress under {words}", "Pa", ("step", point),
          "compression positive"),
        V(f"{part}_gap", f"opening under {words}", "m", ("step", point), "zero or positive"),
        V(f"{part}_pore_pressure", f"excess pore pressure under {words}", "Pa", ("step", point),
          "compression positive, over hydrostatic", required=False),
    )


def _volume(name: str, words: str, comment: str = "since the initial state; whole caisson") -> Variable:
    return V(f"water_{name}", words, "m3", ("step",), comment, required=False)


_WATER = (
    _volume("expelled", "pore volume that the soil has lost", "from the displacements of its boundary alone"),
    _volume("compressed", "volume stored by compression of the water"),
    _volume("film", "volume of water in the gaps of the interface"),
    _volume("outflow", "volume that has left over the drained boundary",
            "Darcy flow into its nodes, and what the cells of these nodes gave off themselves"),
    _volume("moved", "volume that has flowed between nodes, whatever the direction"),
    _volume("imbalance", "water_expelled less water_compressed, water_film and water_outflow"),
    V("pressure_min", "lowest excess pore pressure in soil and interface", "Pa", ("step",),
      "suction is negative", required=False),
    V("pressure_max", "highest excess pore pressure in the soil", "Pa", ("step",), required=False),
    V("cavitation_margin", "lowest absolute water pressure over vapour pressure", "Pa", ("step",),
      "below zero the water would cavitate, which the model does not include", required=False),
    V("section_pore_pressure", "excess pore pressure in the symmetry plane", "Pa", ("step", "section_node"),
      "compression positive, over hydrostatic", required=False),
)

STRESSES = ("xx", "yy", "zz", "xy", "yz", "zx")


def _volume_field(name: str, words: str, units: str, place: str, comment: str) -> Variable:
    return V(name, words, units, ("step", place), comment, required=False)


_FIELDS = (
    *(_volume_field(f"volume_u{a}", f"displacement along {a}", "m", "volume_node", "z is down; soil and steel")
      for a in "xyz"),
    *(_volume_field(f"volume_s{a}", f"effective stress {a}", "Pa", "volume_cell",
                    "tension positive, mean of the cell; not a number in steel") for a in STRESSES),
    _volume_field("volume_plastic_strain", "equivalent plastic strain", "1", "volume_cell",
                  "mean of the cell; 0 in steel"),
    _volume_field("volume_pore_pressure", "excess pore pressure", "Pa", "volume_node",
                  "compression positive, over hydrostatic; 0 in steel"),
    _volume_field("volume_gap", "opening between soil and caisson", "m", "volume_node",
                  "largest of the stations at the node; 0 elsewhere"),
)

_RESULT_PATH = (
    _AXES
    | _BODY
    | _table(
        V("time", "time", "s", ("step",)),
        V("azimuth", "angle around the caisson from +x", "radian", ("azimuth",),
          "0 at +x, pi at -x; half model"),
        V("diameter_change_x", "change of the skirt's diameter in the loading direction", "m", ("depth", "step"),
          "positive where it has grown; of the middle of the wall; elastic caisson only", required=False),
        V("diameter_change_y", "change of the skirt's diameter across the loading direction", "m", ("depth", "step"),
          "positive where it has grown; of the middle of the wall; elastic caisson only", required=False),
        *_SKIRT,
        *_LID,
        *_TIP,
        V("F_pw", "change of the water force under the lid", "N", ("step",),
          "force of the lid on the water from the initial state, positive down: suction is negative; 0 when drained"),
        V("F_in", "change of the vertical shear force on the inner face", "N", ("step",),
          "force of the caisson on the soil from the initial state, positive down"),
        V("F_out", "change of the vertical shear force on the outer face", "N", ("step",),
          "force of the caisson on the soil from the initial state, positive down"),
        *_slices(),
        V("normal_effective_stress", "effective normal stress on the skirt", "Pa", _FIELD,
          "compression positive; undrained clay: total stress over hydrostatic, suction < 0", required=False),
        V("shear_lateral", "lateral (x) traction of the caisson on the soil", "Pa", _FIELD,
          "positive along +x", required=False),
        V("shear_vertical", "vertical (z) traction of the caisson on the soil", "Pa", _FIELD,
          "positive down", required=False),
        V("pore_pressure", "excess pore pressure in the interface", "Pa", _FIELD,
          "compression positive, over hydrostatic", required=False),
        V("gap", "opening between soil and skirt", "m", _FIELD, "zero or positive", required=False),
        *_WATER,
        *_FIELDS,
        *_patch("lid", "the lid"),
        *_patch("tip", "the skirt tip"),
        V("section_ux", "lateral displacement in the symmetry plane", "m", ("step", "section_node"),
          "positive along +x", required=False),
        V("section_uz", "vertical displacement in the symmetry plane", "m", ("step", "section_node"),
          "positive down", required=False),
    )
)

_SPACE = "x at azimuth 0, y to its left seen from above; whole caisson"
_RIGHT = "right-handed about axes with z up"
_SPACE_PATH = {name: _AXES[name] for name in ("depth", "depth_bounds", "side")} | _table(
    V("u_x", "displacement of the lid centre along x", "m", ("step",), _SPACE),
    V("u_y", "displacement of the lid centre along y", "m", ("step",), _SPACE),
    _BODY["w"],
    *(V(f"rot_{axis}", f"rotation of the caisson about {axis}", "radian", ("step",), _RIGHT) for axis in "xyz"),
    V("H_x", "lateral load on the caisson along x", "N", ("step",), _SPACE),
    V("H_y", "lateral load on the caisson along y", "N", ("step",), _SPACE),
    _BODY["V"],
    V("M_x", "moment on the caisson about x", "N m", ("step",), _RIGHT + ", about the lid centre at mudline"),
    V("M_y", "moment on the caisson about y", "N m", ("step",), _RIGHT + ", about the lid centre at mudline"),
    V("T", "torsion on the caisson", "N m", ("step",), "about z up, at the axis of the caisson"),
    _BODY["converged"],
    _RESULT_PATH["time"],
    V("azimuth", "angle around the caisson", "radian", ("azimuth",), "from +x towards +y", required=False),
    *(V(f"p_{axis}", f"lateral soil reaction along {axis} per metre of depth", "N m-1", ("depth", "side", "step"),
        _OPPOSES, {"cell_methods": "depth: mean"}) for axis in "xy"),
    _RESULT_PATH["t"],
    V("torque", "soil reaction to torsion per metre of depth", "N m m-1", ("depth", "side", "step"), _OPPOSES,
      {"cell_methods": "depth: mean"}),
    _RESULT_PATH["normal_effective_stress"],
    V("shear_around", "traction of the caisson on the soil around the skirt", "Pa", _FIELD,
      "positive along a growing azimuth", required=False),
    *(_RESULT_PATH[name] for name in ("shear_vertical", "pore_pressure", "gap", "cavitation_margin")),
)

_SECTION = _table(
    V("section_x", "x of the mesh nodes in the symmetry plane", "m", ("section_node",), "whole diameter"),
    V("section_depth", "depth of the mesh nodes in the symmetry plane", "m", ("section_node",),
      "positive down"),
    V("section_quad", "nodes of each quadrilateral of the symmetry plane", "1", ("section_cell", "corner"),
      "zero-based section_node numbers"),
)

_VOLUME = _table(
    *(V(f"volume_{a}", f"{a} of the nodes", "m", ("volume_node",), "half model; z is down") for a in "xyz"),
    V("volume_hex", "nodes of each cell", "1", ("volume_cell", "vertex"), "zero-based volume_node numbers"),
    V("volume_steel", "1 where a cell is steel, 0 where it is soil", "1", ("volume_cell",)),
)

_CONVERGENCE = _table(
    V("increment", "step of the path the iteration leads to", "1", ("iteration",),
      "0 and below: increments of the dead load"),
    V("attempt", "attempt at the increment; each cut-back starts another", "1", ("iteration",)),
    V("iteration", "iteration number in its attempt", "1", ("iteration",)),
    V("load_fraction", "fraction of the path (or of the dead load) the iteration aims at", "1", ("iteration",)),
    V("residual", "norm of the out-of-balance force", "1", ("iteration",),
      "relative to the contact-force norm"),
    V("correction", "displacement correction", "m", ("iteration",), "root mean square over all unknowns"),
    V("damping", "line-search factor taken", "1", ("iteration",)),
    V("n_open", "interface points open", "1", ("iteration",)),
    V("n_slip", "interface points slipping", "1", ("iteration",)),
    V("n_plastic", "soil points yielding", "1", ("iteration",)),
    V("n_apex", "soil points at the apex of the yield surface", "1", ("iteration",)),
)

_SPRINGS_ROOT = _table(
    V("dof", "degree of freedom of the reaction", "1", ("dof",), "u lateral, w vertical (down), rotation"),
    V("dof_conjugate", "degree of freedom that is displaced", "1", ("dof_conjugate",), "u, w, rotation"),
    V("stiffness_initial", "initial tangent stiffness of the full model at the lid centre", "1",
      ("dof", "dof_conjugate"),
      "mixed units: N m-1 for u and w; N radian-1 between u or w and rotation; N m radian-1 for rotation"),
)

_SPRINGS_PATH = (
    _AXES
    | _BODY
    | _table(
        *_slices(),
        *_TIP,
        *_LID,
        replace(_RESULT_PATH["time"], required=False),
        _RESULT_PATH["cavitation_margin"],
    )
)

# springs from a table have no vertical direction, and user curves no path
_PREDICTED = (replace(v, required=False) if v.name in ("w", "V") else v for v in _BODY.values())
_TANGENT = (
    "mixed units: N m-1 for u and w; N radian-1 between u and rotation; N m radian-1 for rotation; "
    "w: slope of the vertical springs under the V asked for, else elastic stiffness of the full model; uncoupled, and "
    "without the lateral load, which softens it"
)
_DEVIATION = "of springs of an atlas: one standard deviation; 0 for what was imposed"
_PREDICTION = _table(_AXES["depth"], _AXES["depth_bounds"], _Y, *_PREDICTED, _RESULT_PATH["p"]) | _table(
    V("p_water", "part of p that pore water carries, by side", "N m-1", ("side", "depth", "step"), _OPPOSES,
      required=False),
    replace(_AXES["side"], required=False),
    V("usable", "1 where the p-y curve of the depth is usable over the whole path", "1", ("depth",),
      "0: y turns back, changes sign or stays small; p is read from another displacement, or in part"),
    V("range_used", "largest spring displacement over its calibrated range", "1", ("step",),
      "above 1 is extrapolation"),
    V("utilisation", "load over the largest one that is known in its direction", "1", ("step",),
      "attribute capacity_kind: that one is a limit load, or the end of what is known; 0 without load", required=False),
    V("utilisation_V", "vertical load over the largest one that is known downwards, or upwards in tension", "1",
      ("step",), "attribute capacity_V_kind; NaN where no vertical path has a load of this sign", required=False),
    V("mesh_error_pct", "estimate of the error of the load that the mesh of the full model makes", "percent", ("step",),
      "of the largest load of the paths beside the state", required=False),
    V("extrapolated", "1 where a spring is used beyond its calibrated range", "1", ("step",)),
    V("path_distance", "distance from the path the springs come from", "1", ("step",),
      "in (u, rotation*skirt_length), relative to the size of the state; of a fan: from its nearest ray",
      required=False),
    V("off_path", "1 where the state is far from the path the springs come from", "1", ("step",),
      "springs of one path do not hold on another; of a fan: 1 between rays more than 60 degrees apart; "
      "1 after a sequence has left its first direction", required=False),
    V("past_peak", "1 where a spring is beyond the peak of a curve that softens", "1", ("step",),
      "the equilibrium is one of several, and under a load it may not be stable", required=False),
    V("unbounded", "1 where the largest load of an atlas, 1.96 deviations less, is below the load", "1", ("step",),
      "u and rotation have no upper bound: their deviations are infinite", required=False),
    V("beyond_end", "1 where the state is beyond a limit load of the full model", "1", ("step",),
      "there is no answer beyond it"),
    V("turned_back", "1 after the sequence has turned back", "1", ("step",),
      "the springs go back on the same curve, without hysteresis; the soil does not"),
    V("off_load", "1 where V is more than 10 % from that of the lateral springs, or near its largest", "1", ("step",),
      "reactions to u and rotation are those at the first V of a sequence, or at the nearest of the springs, where the "
      "springs do not follow V; with memory also after changes of V that add up to more than on their rays",
      required=False),
    V("time", "time", "s", ("step",), required=False),
    V("off_rate", "1 where the step is faster or slower than the rate of the springs", "1", ("step",),
      "more than sqrt(10) times; or vertical springs of such a rate carry V", required=False),
    *(V(f"{name}_deviation", f"standard deviation of {name}", _BODY[name].units, ("step",), _DEVIATION, required=False)
      for name in ("u", "rotation", "H", "M")),
    _SPRINGS_ROOT["dof"], _SPRINGS_ROOT["dof_conjugate"],
    V("stiffness", "stiffness of the springs at the state: tangent at the lid centre", "1",
      ("step", "dof", "dof_conjugate"), _TANGENT),
)

_OF_BODY = ("u_x", "u_y", "w", "rot_x", "rot_y", "rot_z", "H_x", "H_y", "V", "M_x", "M_y", "T", "converged", "time")
_SPACE_PREDICTION = {
    name: replace(_SPACE_PATH[name], required=name not in ("V", "time")) for name in _OF_BODY
} | _table(
    *(_PREDICTION[name] for name in ("depth", "depth_bounds", "range_used", "extrapolated", "off_load", "off_path")),
    _PREDICTION["off_rate"],
    *(V(f"p_{axis}", f"lateral soil reaction along {axis} per metre of depth", "N m-1", ("depth", "step"), _OPPOSES)
      for axis in "xy"),
    V("torsion_apart", "1 where torsion and a lateral load act together", "1", ("step",),
      "the elements of torsion share no friction with the lateral ones"),
    V("unchecked", "1 within the range, beyond the motions of held-back paths out of one plane", "1", ("step",)),
)

EXTRAPOLATED = "extrapolated"  # group of a path: values of two meshes, in the place of those of its own mesh
_EXTRAPOLATED = {
    v.name: replace(v, required=False)
    for v in (*_BODY.values(), *_SKIRT, *_LID, *_TIP, *(_RESULT_PATH[n] for n in ("F_pw", "F_in", "F_out")), *_slices())
    if v.name != "converged"
}

GROUPS: dict[str, dict[str, Variable]] = {
    "result_root": {name: replace(variable, required=False) for name, variable in _SPRINGS_ROOT.items()},
    "result_path": _RESULT_PATH,
    "space_path": _SPACE_PATH,
    "section": _SECTION,
    "volume": _VOLUME,
    "convergence": _CONVERGENCE,
    EXTRAPOLATED: _EXTRAPOLATED,
    "springs_root": _SPRINGS_ROOT,
    "springs_path": _SPRINGS_PATH,
    "prediction": _PREDICTION,
    "space_prediction": _SPACE_PREDICTION,
}

# fmt: on


def group_of(path: str, kind: TreeKind) -> str | None:
    """Return the table that rules a group of a tree (``/paths/pull`` ...), or None where nothing does."""
    parts = [part for part in path.split("/") if part]
    if not parts:
        return f"{kind}_root"
    if parts in (["section"], ["volume"]):
        return parts[0]
    if parts[0] == "paths" and len(parts) == 2:
        return f"{kind}_path"
    if parts[0] == "space" and len(parts) == 2:
        return "space_path"
    if parts[0] in ("paths", "space") and parts[2:] in (["convergence"], [EXTRAPOLATED]):
        return parts[2]
    return None


def described(values: Mapping[str, Any], group: str) -> dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]:
    """Return values by name with the dimensions and attributes of the table of their group, as xarray takes them."""
    table = GROUPS[group]
    return {name: (table[name].dims, value, table[name].attributes()) for name, value in values.items()}


def attach(dataset: xr.Dataset, group: str) -> xr.Dataset:
    """Return the dataset with long_name, units, sign and CF attributes from the table of its group."""
    table = GROUPS[group]
    out = dataset.copy()
    for name in out.variables:
        if name in table:
            out[name].attrs = {**out[name].attrs, **table[str(name)].attributes()}
    return out


def problems(dataset: xr.Dataset, group: str) -> Iterator[tuple[str, str]]:
    """Yield (variable, message) for everything in a dataset that the table of its group does not allow."""
    table = GROUPS[group]
    for variable in table.values():
        if variable.required and variable.name not in dataset.variables:
            yield variable.name, "missing variable"
    for name, data in dataset.variables.items():
        if name not in table:
            if name not in dataset.dims:  # a plain index (step, bound ...) needs no entry
                yield str(name), "unknown variable"
            continue
        yield from ((str(name), message) for message in _mismatches(data, table[str(name)]))


def _mismatches(data: Any, variable: Variable) -> Iterator[str]:
    if data.dims != variable.dims:
        yield f"dimensions ({', '.join(map(str, data.dims))}) instead of ({', '.join(variable.dims)})"
    units = data.attrs.get("units")
    if units is None and variable.name.endswith("_bounds"):
        return  # CF: bounds have the units of their coordinate, and xarray leaves them out of a file
    if units is None:
        yield f"no units (expected '{variable.units}')"
    elif not isinstance(units, str) or units != variable.units:
        shown = str(units) if len(str(units)) <= 60 else f"{str(units)[:57]}..."
        yield f"units '{shown}' instead of '{variable.units}'"


def tree_problems(tree: xr.DataTree, kind: TreeKind) -> list[tuple[str, str]]:
    """Return (group/variable, message) for everything in a tree that the tables do not allow."""
    listed: list[tuple[str, str]] = []
    for node in tree.subtree:
        group = group_of(node.path, kind)
        if group is not None:
            place = node.path.strip("/")
            dataset = node.to_dataset(inherit=False)
            listed += [("/".join(filter(None, (place, name))), text) for name, text in problems(dataset, group)]
    return listed
