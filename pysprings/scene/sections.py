# SPDX-License-Identifier: MIT
"""The sections of a scene: caisson, domain, soil, interface, drainage, load paths, mesh, solver, output, in SI, frozen.

Defaults of the caisson are that of Cerfontaine, Charlier & Collin (2018); the ground has none but neutral values:
`pysprings.scene.defaults` lists what a scene does not give. Lengths in m, angles in rad, forces in N, stresses in Pa.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, get_args

from pydantic import BaseModel, ConfigDict, Field as Key, create_model

from pysprings.core.path_kinds import LOADS, MOTIONS, PATH_KINDS, ROLES
from pysprings.core.units import MOST_MOVED, MOST_TURNED
from pysprings.core.words import AUTO, FROM_CASES, Discretisation, Figures, MeshPreset
from pysprings.scene.by_depth import ByDepth, BySurface, Profile
from pysprings.scene.fields import Choice, Count, Flag, Number, Quantity, QuantityList, Text, field_of
from pysprings.scene.soils import LAW_KEYS, SOIL_LAWS
from pysprings.scene.soils.clay import TABLES
from pysprings.scene.then import Then, ThenList

# pydantic annotations of the fields, short enough to be read as a table
_PENALTY = 'penalty stiffness of the interface; "auto" is 390 times Young modulus over diameter'
_STIFFNESS = Quantity("N/m^3", "[1e3, 1e16]", _PENALTY, "1e10 N/m^3", word="auto")
_SHIFT = Quantity("mm", "[-1e4, 1e4]", "lateral displacement of the lid centre, towards +x", "20 mm")
_TURN = Quantity("deg", "[-30, 30]", "rotation, positive where the caisson leans towards +x", "0.1 deg")
_SINK_TEXT = "vertical displacement of the lid centre, positive down (pull-out is negative)"
_SINK = Quantity("mm", "[-1e4, 1e4]", _SINK_TEXT, "20 mm")
_PUSH = Quantity("MN", "[-1e4, 1e4]", "lateral force on the whole caisson, towards +x", "5 MN")
_ARM = Quantity("m", "[-1e3, 1e3]", "height of the load above mudline", "8 m")
_ARM_FROM = Quantity("m", "[-1e3, 1e3]", "height where a load acts first; it then climbs to arm", "0 m")
_LOAD_ANGLE = Quantity(
    "deg", "[-180, 180]", "direction of a probe: angle of the load in the plane of H and M/D", "45 deg"
)
_TORSION_ANGLE = Quantity(
    "deg", "[-90, 90]", "direction of a probe: angle of the load out of the plane of H and M/D, towards T/D", "30 deg"
)
_PACE = "velocity of the lid centre, of a probe that of what it imposes; not used when drained"
_RATE = Quantity("mm/s", "[1e-9, 1e4]", _PACE, "0.05 mm/s")
_LASTS = "time to the end value, instead of a rate; a load that climbs takes it twice"
_TIME = Quantity("s", "[1e-6, 1e12]", _LASTS, "400 s")
_LINEAR = Choice(("auto", "pardiso", "rslab", "superlu"), "linear solver", planned=("mumps",))
_DIRECTION = Quantity("deg", "[-360, 360]", "direction of the load, from +x towards +y", "45 deg")
_TWIST = Quantity("mrad", "[-500, 500]", "rotation about the vertical axis, from +x towards +y", "10 mrad")
_ROUND = Quantity("mm", "[1e-6, 1e4]", "radius of the circle on which the lid centre goes once round", "5 mm")


def _end(unit: str, text: str, example: str) -> Quantity:
    return Quantity(unit, "[-1e4, 1e4]" if unit != "mrad" else "[-500, 500]", text, example)


_ALONG_X, _ALONG_Y, _TURNED = (_end(unit, 'end value of a path of kind "motion"', f"5 {unit}")
                               for unit in ("mm", "mm", "mrad"))  # fmt: skip
_OF_LOAD = 'end value of a path of kind "load": V down, moments about the lid centre with z up'
_FORCE, _MOMENT = (_end(unit, _OF_LOAD, f"2 {unit}") for unit in ("MN", "MN m"))
_QUANTITIES = {
    "": _SHIFT, "twist": _TWIST, "radius": _ROUND, "lateral_displacement": _SHIFT,
    "rotation": _TURN, "lateral_force": _PUSH, "vertical_displacement": _SINK,
}  # fmt: skip
_IMPOSED = tuple((name, _QUANTITIES[kind.imposed]) for name, kind in PATH_KINDS.items())
_AT_REST = (
    'initial horizontal over vertical effective stress; "auto" is 1 - sin(friction_angle_final), of law sand 1 - '
    "sin(critical_friction_angle); needed by soil with friction, 1 where others do not give it"
)
_E = Quantity("MPa", "[0.001, 1e6]", "Young modulus", "200 MPa")
_NU = Number("[0, 0.5)", "Poisson ratio; 0.3 where not given, 0.495 of undrained clay", 0.3, common=(0.05, 0.4999))
_WEIGHT = Quantity("kN/m^3", "[0, 100]", "effective (submerged) unit weight", "10 kN/m^3", common=(3.0, 14.0))
_CONDUCTS = Quantity("m/s", "[1e-20, 10]", "hydraulic conductivity; used and needed where drainage is coupled",
                     "1e-4 m/s", common=(1e-13, 0.1))  # fmt: skip
# G: peat to very dense sand at depth, short of rock
_G = Quantity("MPa", "[1e-4, 1e6]", "shear modulus, instead of young_modulus", "5 MPa", common=(0.1, 1500.0))
_ADHESION = BySurface(
    Number("[0, 1]", "largest shear over su (or over the cohesion)", 0.65), ("api",),
    "largest shear of the interface over su of the soil beside it",
)  # fmt: skip
_OPENING = BySurface(
    None, ("vented", "sealed", "bonded"),
    "tension of the contact: none (vented), suction down to cavitation (sealed), any (bonded)",
)  # fmt: skip
_DRAINED = Choice(
    ("total-stress", "drained", "coupled", "undrained"),
    "water of the layer: total-stress for undrained clay, for others that of [drainage] (default) or drained",
)
_KNOWN_TO = Quantity("m", "(0, 1e4]", "depth to which its values are known; they hold on below it", "20 m")
_SEA = "depth of the sea; where given, suction is checked for cavitation"
_DEPTH = Quantity("m", "[0, 2e4]", _SEA, "30 m")
_VISCOSITY = Quantity("Pa s", "[1e-6, 1e3]", "dynamic viscosity of water", "0.001 Pa s")
_BULK = 'bulk modulus of water; "incompressible" is possible too'
_BALANCED = 'constant load on the whole caisson, positive down; "balanced" carries the initial contact stresses'
_CARRIED = Quantity("MN", "[-1e4, 1e4]", _BALANCED, "4 MN", word="balanced")
_INSTEAD = 'vertical load of this path instead of caisson.vertical_load; or "balanced"'
_OWN_LOAD = Quantity("MN", "[-1e4, 1e4]", _INSTEAD, "4 MN", word="balanced")
_DISCRETISED = "bricks (hex8), or Fourier series in azimuth; by default series where they can represent the scene"
_RADIUS = Quantity("m", "[0.01, 1e4]", 'radius of the cylinder of soil; "auto" follows the caisson', "24 m", word=AUTO)
_BOTTOM = Quantity(
    "m", "[0.01, 1e4]", 'depth of the cylinder of soil; "auto" follows caisson and layers', "12 m", word=AUTO
)
_REACH = Quantity("mm", "[1e-6, 1e4]", "largest motion of the fan of load paths", "20 mm")
_FURTHER_LOADS = QuantityList(
    "", (("", Quantity("MN", "[-1e4, 1e4]", "vertical load", "4 MN")),),
    'further vertical loads under which the rays are computed, beside that of [caisson]; "from cases" takes the fewest '
    "that are within 10 % of every V of [design] cases",
    word=FROM_CASES,
)  # fmt: skip
_RAYS = QuantityList(
    "", (("", Quantity("deg", "(-90, 90]", "direction of a ray", "30 deg")),),
    "directions of the rays, in place of the usual eight: angles of (u, rotation * skirt_length)",
)  # fmt: skip
_RATES = QuantityList(
    "", (("", Quantity("mm/s", "[1e-9, 1e4]", "rate", "0.05 mm/s")),),
    "rates of the reach, and of w, at which rays and vertical paths are computed; needed where water flows",
)  # fmt: skip
_VISCOUS = Quantity(
    "mm", "[1e-9, 100]",
    "imposed motion in which stress beyond yield relaxes once an attempt at a step has failed: carries paths through "
    "localised sand",
    "0.001 mm",
)  # fmt: skip
_FRACTION = Number("[1e-12, 1]", "first step, as a fraction of the path", 0.02)
_LARGEST_FRACTION = Number("[1e-9, 1]", "largest step, as a fraction of the path", 0.1)


class Section(BaseModel):
    """A table of the scene file: frozen, unknown keys refused, each key with its default."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_by_name=True, validate_by_alias=True)


class Caisson(Section):
    """The suction caisson, wished in place."""

    outer_diameter: Annotated[float, Quantity("m", "[0.01, 200]", "outer diameter of the skirt", "7.8 m")] = 7.8
    skirt_length: Annotated[float, Quantity("m", "[0.01, 200]", "depth of the tip below mudline", "4 m")] = 4.0
    skirt_thickness: Annotated[float, Quantity("m", "[1e-4, 10]", "wall thickness of the skirt", "0.1 m")] = 0.1
    lid_thickness: Annotated[float, Quantity("m", "[1e-4, 10]", "thickness of the lid", "0.4 m")] = 0.4
    behaviour: Annotated[str, Choice(("rigid", "elastic"), "how the steel behaves")] = "rigid"
    young_modulus: Annotated[
        float, Quantity("GPa", "[0.001, 1e6]", "Young modulus of an elastic caisson", "200 GPa")
    ] = 200e9
    poisson_ratio: Annotated[float, Number("[0, 0.5)", "Poisson ratio of an elastic caisson", 0.3)] = 0.3
    vertical_load: Annotated[float | str, _CARRIED] = "balanced"


class Domain(Section):
    """The cylinder of soil that is modelled."""

    radius: Annotated[float | str, _RADIUS] = AUTO
    depth: Annotated[float | str, _BOTTOM] = AUTO
    side: Annotated[str, Choice(("roller", "fixed"), "the outer side slides (roller) or is held (fixed)")] = "roller"
    side_drainage: Annotated[
        str, Choice(("drained", "sealed"), "the outer side keeps hydrostatic pressure, or lets no water through")
    ] = "sealed"


class SoilState(Section):
    """A frictional soil that hardens, or undrained clay, and its initial state.

    A value that is None is not given: `pysprings.scene.ground.values_of` puts the default of the law in its place, and
    a scene without stiffness, strength, unit weight, K0 of a frictional soil, or conductivity where water flows is
    refused. The keys of the laws stand in `pysprings.scene.soils`.
    """

    young_modulus: Annotated[float | None, _E] = None
    poisson_ratio: Annotated[float | None, _NU] = None
    yield_surface: Annotated[str, Choice(tuple(SOIL_LAWS), "shape of the yield surface")] = "drucker-prager"
    effective_unit_weight: Annotated[float | None, _WEIGHT] = None
    surcharge: Annotated[float, Quantity("kPa", "[0, 1e5]", "vertical effective stress at mudline", "10 kPa")] = 0.0
    K0: Annotated[float | str | None, Number("[0.01, 10]", _AT_REST, 0.5, word="auto", common=(0.25, 3.0))] = None
    hydraulic_conductivity: Annotated[float | None, _CONDUCTS] = None
    shear_modulus: Annotated[float | ByDepth | None, Profile(_G, powers=True)] = None
    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...


_OF_LAWS: dict[str, Any] = {name: (Annotated[Any | None, field], None) for name, field in LAW_KEYS.items()}
if TYPE_CHECKING:

    class SoilValues(SoilState): ...
else:
    SoilValues = create_model(
        "SoilValues", __base__=SoilState, __module__=__name__, __doc__=SoilState.__doc__, **_OF_LAWS
    )


class LayerPlace(Section):
    """A layer of the soil: its top, its law and its values. Values that are not given are those of [soil]."""

    top: Annotated[float, Quantity("m", "[0, 1e4]", "depth of the top of the layer below mudline", "0 m")]
    name: Annotated[str, Text("name of the layer in tables")] = "layer"
    law: Annotated[str | None, Choice(tuple(SOIL_LAWS), "constitutive law; by default that of [soil]")] = None
    drainage: Annotated[str | None, _DRAINED] = None
    known_to: Annotated[float | None, _KNOWN_TO] = None
    remark: Annotated[str | None, Text("what a reader of results has to know of its values")] = None


_NOT_BY_LAYER = ("yield_surface", "surcharge")
_BY_STRESS = ("young_modulus",)


def plain_field(name: str, model: type[BaseModel] = SoilValues) -> Any:
    """Return the field of a value of a section (the soil), that of its constant value where it varies with depth."""
    field = field_of(model.model_fields[name])
    return field.quantity if isinstance(field, Profile) else field


def _layer_field(name: str) -> Any:
    """Return the optional field of a layer for a value of the soil."""
    field = field_of(SoilValues.model_fields[name])
    if not isinstance(field, Quantity | Number) or getattr(field, "constant", False):
        return Annotated[Any | None, field], None
    return Annotated[Any | None, Profile(field, name in _BY_STRESS)], None


_VALUES = {name: _layer_field(name) for name in SoilValues.model_fields if name not in _NOT_BY_LAYER}
BY_LAYER = tuple(name for name in _VALUES if name not in TABLES)  # the numbers of a layer
if TYPE_CHECKING:
    Layer = LayerPlace
else:
    Layer = create_model("Layer", __base__=LayerPlace, __module__=__name__, __doc__=LayerPlace.__doc__, **_VALUES)


class Soil(SoilValues):
    """A frictional soil that hardens, or undrained clay, and its initial state; [[soil.layer]] tables divide it."""

    layers: tuple[Layer, ...] = Key((), validation_alias="layer")


class Interface(Section):
    """Contact, friction and flow between caisson and soil."""

    normal_stiffness: Annotated[float | str, _STIFFNESS] = "auto"
    shear_stiffness: Annotated[float | str, _STIFFNESS] = "auto"
    friction_coefficient: Annotated[
        float, Number("[0, 5]", "Coulomb friction coefficient; not used beside undrained clay", 0.5)
    ] = 0.5
    adhesion_factor: Annotated[float | str | dict[str, Any] | None, _ADHESION] = None
    opening: Annotated[str | dict[str, Any], _OPENING] = "vented"
    transversal_conductivity: Annotated[
        float, Quantity("m/(Pa s)", "[1e-24, 1]", "transversal conductivity; not used when drained", "1e-8 m/(Pa s)")
    ] = 1e-8
    residual_aperture: Annotated[
        float,
        Quantity("mm", "[1e-9, 100]", "aperture of a closed interface for flow; not used when drained", "0.01 mm"),
    ] = 1e-5


class Drainage(Section):
    """How the water takes part: not at all, with its flow in time, or without time to flow.

    All but `mode` is not used when drained. The bottom of the domain and the lid are sealed, the mudline outside the
    caisson keeps hydrostatic pressure.
    """

    mode: Annotated[str, Choice(("drained", "coupled", "undrained"), "how the water takes part")] = "drained"
    porosity: Annotated[float, Number("(0, 1)", "volume of water per volume of soil", 0.4)] = 0.4
    water_bulk_modulus: Annotated[
        float | str, Quantity("GPa", "[1e-6, 1e6]", _BULK, "2.2 GPa", word="incompressible")
    ] = 2.2e9
    water_unit_weight: Annotated[float, Quantity("kN/m^3", "[1, 30]", "unit weight of water", "9.81 kN/m^3")] = 9.81e3
    water_viscosity: Annotated[float, _VISCOSITY] = 1e-3
    water_depth: Annotated[float | None, _DEPTH] = None
    stabilisation: Annotated[
        float, Number("[0, 100]", "factor on the stabilisation of the pore pressure (0 to see why it is there)", 1.0)
    ] = 1.0


class Path(Section):
    """One way of moving the caisson from its initial state.

    pull: the lid centre is moved, the rotation is free, the load acts at height `arm`. translation: the lid
    centre is moved, the rotation is imposed in proportion (zero by default). rotation: imposed about the lid
    centre. swipe: a translation, and then the rotation about the lid centre, whose displacement is held: H and M
    change places under a constant vertical load. load: a lateral force at height `arm`; with `arm_from` it grows at
    that height and then climbs to `arm`, so that M grows under constant H and V. probe: the load keeps its direction,
    H = R cos(load_angle) and M = R D sin(load_angle), D the outer diameter, and `lateral_displacement` is conjugate to
    it, u cos(load_angle) + rotation D sin(load_angle); like a load it ends where the caisson has moved by 10 % of D or
    turned by 5 deg; with `torsion_angle` b, H and M are these times cos(b) and T = R D sin(b). vertical: the lid centre
    moves down (or up: pull-out), u and rotation are held at zero. `direction` turns a path in one plane about the
    axis. Paths that leave a plane (series; with water each part takes its `duration` or time) check
    springs only: twist: the caisson turns about its axis, all else is free. circle: the lid centre moves by
    `radius` in `direction` and then once round, from +x towards +y, without rotation. motion: u_x, u_y, rot_x,
    rot_y and rot_z grow in proportion, those not given are held. load with H_x, H_y, V, M_x, M_y, T: these grow in
    proportion; V from the dead load. "12 mm towards 90 deg" in `then` moves the lid centre of a pull (T is 0) or
    translation (no rotation) on by 12 mm.
    `vertical_load` is the dead load of this path alone. `report_at` lists values of the imposed quantity where a
    converged step must land. `then` goes on from the end value: "rest 2 hour" holds what is imposed, "20 mm at 0.5
    mm/s" and "0 mm in 10 min" lead on to another value; a load goes on to "1 MN, 4 MN m" (H and M), a swipe to "5
    mm, 2 mrad" (u and rotation); "V 3 MN in 10 min" changes the vertical load and holds what is imposed. `role =
    "memory"` is for a translation or rotation that turns back: spring set "memory".
    """

    name: Annotated[
        str,
        Text(
            "name of the path in every table",
            pattern=r"[A-Za-z][A-Za-z0-9_-]{0,59}",
            meaning="a name (a letter, then letters, digits, _ or -, at most 60)",
            names_files=True,
        ),
    ]
    kind: Annotated[str, Choice(tuple(PATH_KINDS), "what is imposed")]
    lateral_displacement: Annotated[float | None, _SHIFT] = None
    rotation: Annotated[float | None, _TURN] = None
    lateral_force: Annotated[float | None, _PUSH] = None
    vertical_displacement: Annotated[float | None, _SINK] = None
    arm: Annotated[float, _ARM] = 0.0
    arm_from: Annotated[float | None, _ARM_FROM] = None
    load_angle: Annotated[float | None, _LOAD_ANGLE] = None
    torsion_angle: Annotated[float | None, _TORSION_ANGLE] = None
    direction: Annotated[float | None, _DIRECTION] = None
    twist: Annotated[float | None, _TWIST] = None
    radius: Annotated[float | None, _ROUND] = None
    u_x: Annotated[float | None, _ALONG_X] = None
    u_y: Annotated[float | None, _ALONG_Y] = None
    rot_x: Annotated[float | None, _TURNED] = None
    rot_y: Annotated[float | None, _TURNED] = None
    rot_z: Annotated[float | None, _TURNED] = None
    H_x: Annotated[float | None, _FORCE] = None
    H_y: Annotated[float | None, _FORCE] = None
    V: Annotated[float | None, _FORCE] = None
    M_x: Annotated[float | None, _MOMENT] = None
    M_y: Annotated[float | None, _MOMENT] = None
    T: Annotated[float | None, _MOMENT] = None
    rate: Annotated[float | None, _RATE] = None
    duration: Annotated[float | None, _TIME] = None
    vertical_load: Annotated[float | str | None, _OWN_LOAD] = None
    heave: Annotated[str, Choice(("free", "fixed"), "the vertical displacement of the caisson")] = "free"
    role: Annotated[
        str, Choice(ROLES, "whether springs are made from this path, their memory of reversals, or it only checks them")
    ] = "calibration"
    report_at: Annotated[
        tuple[float, ...],
        QuantityList("kind", _IMPOSED, "values of the imposed quantity where a converged step must land"),
    ] = ()
    then: Annotated[
        tuple[Then, ...],
        ThenList("kind", _IMPOSED, "what follows: a rest, another vertical load, or a new end value, with their pace"),
    ] = ()

    def given(self, names: tuple[str, ...]) -> dict[str, float]:
        """Return the end values of these components that the path gives."""
        values = {name: getattr(self, name, None) for name in names}
        return {name: value for name, value in values.items() if value is not None}

    @property
    def in_space(self) -> bool:
        """Whether the path leaves the plane of one load: the whole caisson moves in six degrees of freedom."""
        turns = any(each.towards is not None for each in self.then)
        beyond = PATH_KINDS[self.kind].space or self.torsion_angle is not None
        return beyond or turns or bool(self.given(LOADS) or self.given(MOTIONS))


MOST_HALVINGS = 4


class Mesh(Section):
    """Size of the mesh: a preset, and what overrides it."""

    preset: Annotated[str, Choice(get_args(MeshPreset), "size of the mesh")] = "coarse"
    azimuth: Annotated[int | None, Count(8, 256, "cells around the half ring", multiple_of=4)] = None
    refinement: Annotated[float, Number("[0.25, 8]", "factor on all numbers of cells of the preset", 1.0)] = 1.0
    discretisation: Annotated[str, Choice((AUTO, *get_args(Discretisation)), _DISCRETISED)] = AUTO
    harmonics: Annotated[int | None, Count(1, 64, "highest harmonic of the series")] = None
    halvings: Annotated[
        int, Count(0, MOST_HALVINGS, "times that elements beside skirt and tip are halved (series)")
    ] = 0


class Solver(Section):
    """Newton iterations, load steps and the linear solver."""

    tolerance: Annotated[
        float, Number("[1e-12, 0.01]", "largest residual, relative to the norm of the contact forces", 1e-5)
    ] = 1e-5
    linear: Annotated[str, _LINEAR] = "auto"
    max_iterations: Annotated[int, Count(2, 1000, "Newton iterations before a step is cut back")] = 20
    first_step_fraction: Annotated[float | None, _FRACTION] = None
    max_step_fraction: Annotated[float | None, _LARGEST_FRACTION] = None
    viscous_displacement: Annotated[float | None, _VISCOUS] = None


class Limit(Section):
    """Largest motion under a given load: where a path of kind "load" ends, and its load counts as the limit load."""

    displacement_over_diameter: Annotated[
        float,
        Number(
            "[0.001, 1]", "displacement over diameter: of lid centre or tip sideways, or of the caisson vertically", 0.1
        ),
    ] = MOST_MOVED
    rotation: Annotated[float, Quantity("deg", "[0.01, 45]", "rotation of the caisson", "5 deg")] = MOST_TURNED


class Output(Section):
    """What is kept beside springs and curves."""

    interface_fields: Annotated[bool, Flag("keep contact stresses and gaps by azimuth and depth at every step")] = True
    section: Annotated[bool, Flag("keep displacements of the symmetry plane at every step")] = True
    figures: Annotated[
        bool | str,
        Flag(
            "draw the pictures that the report shows (true), or all",
            (("none", False), ("report", True), ("all", "all")),
        ),
    ] = True
    paraview: Annotated[bool, Flag("keep the whole model at every step, and write ParaView files of it")] = False

    @property
    def pictures(self) -> Figures:
        """Which pictures of a run are drawn."""
        return "all" if self.figures == "all" else "report" if self.figures else "none"


class Springs(Section):
    """A fan of load paths, made from diameter, skirt length and reach; [[path]] tables add to it.

    Eight rays move the lid centre by u and turn the caisson in proportion, until sqrt(u^2 + (rotation skirt_length)^2)
    is `reach`. Two vertical paths at each rate and five pulls, held back, go to half of it. With `memory` three rays at
    each vertical load and rate go back and forth, at 12, 24 (twice) and 40 % of it, and with `vertical_loads`, without
    `rates`, three more at 12 % while the vertical load changes. `rays` has other directions than these. With
    `directions` a circle at a quarter of it, a bow tie, a twist, and a held-back walk of five legs leave the plane.
    """

    reach: Annotated[float | None, _REACH] = None
    rays: Annotated[tuple[float, ...], _RAYS] = ()
    vertical: Annotated[bool, Flag("also compute the two vertical paths")] = True
    vertical_loads: Annotated[tuple[float, ...], _FURTHER_LOADS] = ()
    rates: Annotated[tuple[float, ...], _RATES] = ()
    held_back: Annotated[bool, Flag("also compute pulls at five heights, on which the springs are only checked")] = True
    memory: Annotated[bool, Flag("also compute rays that turn back, which give the springs a memory")] = False
    directions: Annotated[
        bool, Flag("also compute a circle, a bow tie and a twist, which give springs with memory all directions")
    ] = False


# of Cerfontaine, Charlier & Collin (2018)
PAPER_SOIL = {
    "young_modulus": 200e6, "poisson_ratio": 0.3, "friction_angle_initial": math.radians(5.0),
    "friction_angle_final": math.radians(30.0), "hardening_parameter": 0.005, "effective_unit_weight": 10.56e3,
    "surcharge": 10.56e3, "K0": 1.0, "hydraulic_conductivity": 1e-4,
}  # fmt: skip
PAPER_PATH = Path(name="pull", kind="pull", lateral_displacement=20e-3, rate=0.05e-3, report_at=(2.5e-3,))


PAPER = {"radius": 24.0, "depth": 12.0}  # m, the domain of Cerfontaine, Charlier & Collin (2018)
# diameters between the axis and the side, and between the tip and the bottom: see `model.forecast.domain_effect`
RADIUS, BELOW_TIP = 40.0, 40.0
GROUND = 3.0  # diameters below the tip, where an automatic depth turns the soil into an elastic one: see `ground`
_OF_LAST = 1.0  # diameter of the last layer that is modelled at the least


@dataclass(frozen=True)
class Extent:
    """Radius and depth of the domain, m, the depth down to which the soil has its own values, and that of the tip."""

    radius: float
    depth: float
    ground: float
    tip: float


def make_extent(domain: Domain, caisson: Caisson, soil: Soil) -> Extent:
    """Return the size of the domain; what is "auto" follows from caisson and layers."""
    diameter, tip = caisson.outer_diameter, caisson.skirt_length
    last = max((layer.top for layer in soil.layers), default=0.0)
    radius = RADIUS * diameter if domain.radius == AUTO else float(domain.radius)
    if domain.depth != AUTO:
        return Extent(radius, float(domain.depth), float(domain.depth), tip)
    ground = max(tip + GROUND * diameter, last + _OF_LAST * diameter)
    return Extent(radius, max(tip + BELOW_TIP * diameter, 2.0 * ground), ground, tip)
