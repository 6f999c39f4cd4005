# SPDX-License-Identifier: MIT
"""The model: mesh, materials, interface, constraints and stages as plain data."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fe_engine.contact import coulomb
from fe_engine.contact.law import ContactLaw
from fe_engine.elements.interface import Film, Stations
from fe_engine.errors import ModelError
from fe_engine.material import Material, contact_shapes, is_smooth, material_shapes
from fe_engine.mesh import Mesh


@dataclass(frozen=True)
class Stage:
    """A monotonic stretch of loading on the border degrees of freedom.

    ``control`` (nc, nb) are the combinations of border dofs that are imposed and ``target`` (nc,) their values
    at the end of the stage; ``load`` (nb, nc) is the pattern of the unknown force that imposes each of them.
    ``force`` (nb,) is the known external force at the end of the stage. Everything varies linearly over the
    stage from the values that held at its start. ``stops`` are fractions of the stage where a converged state
    must land. ``lag`` is the relaxation time of a viscous soil over the duration of the stage (see soil.viscous); it
    counts once an attempt has been given up (see solve.stepping). A stage that ``continues`` is as long as the one
    before it and goes nearly the same way: its first increment extrapolates the last one.
    """

    name: str
    control: np.ndarray
    target: np.ndarray
    load: np.ndarray
    force: np.ndarray
    stops: tuple[float, ...] = (1.0,)
    first_fraction: float = 0.01
    max_fraction: float = 0.1
    duration: float = 0.0
    lag: float = 0.0
    continues: bool = False


@dataclass(frozen=True)
class Water:
    """Pore water of the soil, and of the interface where there is a film.

    Pressures are excess pressures over hydrostatic, Pa, compression positive; a vector of them holds the n mesh
    nodes first, then the nf film nodes.

    Attributes
    ----------
    mobility : hydraulic conductivity over unit weight of water, m2/(Pa s); one value, or (ne,).
    storage : porosity over bulk modulus of water, 1/Pa; 0 is incompressible water.
    stabilisation : 1/Pa, factor of the pressure projection of the elements (see biot); one value, or (ne,).
    fixed : (n + nf,) bool, where the pressure keeps its initial value.
    initial : (n + nf,) Pa, pressures at the start.
    scale : Pa/m, turns a pressure into an unknown of the size of a displacement.
    film : water in the interface, None where the interface holds none.
    wet : (ne,) bool, elements that hold water; None: all. The others neither store, squeeze nor pass water, so that
        their boundary is impervious; nodes of them alone are fixed.
    """

    mobility: float | np.ndarray
    storage: float
    stabilisation: float | np.ndarray
    fixed: np.ndarray
    initial: np.ndarray
    scale: float
    film: Film | None = None
    wet: np.ndarray | None = None


@dataclass(frozen=True)
class Linear:
    """Elements of constant stiffness beside the soil's (see solid_shell); their displacement 0 is without stress.

    hexes : (nl, 8) nodes; stiffness : (nl, 24, 24) N/m in global axes.
    """

    hexes: np.ndarray
    stiffness: np.ndarray


@dataclass
class Model:
    """Everything the engine needs to compute.

    Attributes
    ----------
    mesh : nodes and hexahedra.
    materials : laws in use; material : (ne,) index into them. Where the parameters of a material have several rows,
        these stand in the order of its elements.
    initial_stress : (ne, 8, 6) Pa, in equilibrium with weight, surcharge and initial contact pressure. The
        equations are written for the change from this state, so it is an exact equilibrium at zero displacement.
    fixed : (n, 3) bool, dofs held at zero, in the nodal frame where one is given.
    frames : node -> (3, 3) rows are the axes of that node's dofs.
    followers : (k, 4) rows (node, component, border dof, weight): nodal dofs that move with a border dof.
    n_border : number of border dofs (3 for a rigid body).
    border_scale : (nb,) lengths that turn border dofs into displacements (norms and scaling only).
    stations, contact : interface stations, and the contact parameters (ns, n) of each, or one row (1, n) for all.
    contact_laws, contact_law : laws of the stations, and the index (ns,) of each into them; None: all have the first.
    initial_pressure : (ns,) Pa, effective contact pressure of each station in the initial state.
    water : pore water; None leaves every pressure unknown out (drained).
    linear : elements of constant stiffness, whose nodes stand behind the soil's; None where there are none.
    """

    mesh: Mesh
    materials: list[Material]
    material: np.ndarray
    initial_stress: np.ndarray
    fixed: np.ndarray
    frames: dict[int, np.ndarray] = field(default_factory=dict)
    followers: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))
    n_border: int = 0
    border_scale: np.ndarray = field(default_factory=lambda: np.zeros(0))
    stations: Stations | None = None
    contact: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    initial_pressure: np.ndarray = field(default_factory=lambda: np.zeros(0))
    water: Water | None = None
    linear: Linear | None = None
    contact_laws: tuple[ContactLaw, ...] = (coulomb.LAW,)
    contact_law: np.ndarray | None = None

    @property
    def displacement_shape(self) -> tuple[int, int]:
        """Shape (n, 3) of the displacement."""
        return self.mesh.n_nodes, 3

    @property
    def n_film(self) -> int:
        """Number of film nodes."""
        return 0 if self.water is None or self.water.film is None else self.water.film.n_nodes

    @property
    def symmetric(self) -> bool:
        """Whether the sparse part of every tangent is symmetric and positive definite.

        So it is where the soil is elastic, nothing rubs and there is no water. The coupling of water is one-sided where
        the interface is closed: the pressure of the film presses on its faces, and their motion moves no water.
        """
        soil = all(material.law.symmetric for material in self.materials)
        return soil and self.water is None and is_smooth(self)

    def check(self) -> None:
        """Raise ModelError where the parts contradict each other."""
        ne, n = self.mesh.n_elements, self.mesh.n_nodes
        shapes = {
            "material": (self.material.shape, (ne,)),
            "initial_stress": (self.initial_stress.shape, (ne, 8, 6)),
            "fixed": (self.fixed.shape, (n, 3)),
            "border_scale": (self.border_scale.shape, (self.n_border,)),
        }
        if self.stations is not None:
            shapes["initial_pressure"] = (self.initial_pressure.shape, (len(self.stations),))
            shapes |= contact_shapes(self)
        if self.water is not None:
            shapes["water.fixed"] = (self.water.fixed.shape, (n + self.n_film,))
            shapes["water.initial"] = (self.water.initial.shape, (n + self.n_film,))
            if self.water.wet is not None:
                shapes["water.wet"] = self.water.wet.shape, (ne,)
            if self.n_film and self.stations is None:
                raise ModelError("a film needs the stations of an interface")
        if self.linear is not None:
            nl = len(self.linear.hexes)
            shapes["linear.stiffness"] = (self.linear.stiffness.shape, (nl, 24, 24))
            if skew := sorted(set(self.frames) & set(self.linear.hexes.ravel().tolist())):
                raise ModelError(f"node {skew[0]} has axes of its own and a linear element; these have global axes")
        shapes |= material_shapes(self)
        for name, (got, expected) in shapes.items():
            if got != expected:
                raise ModelError(f"{name} has shape {got}, expected {expected}")
        if self.stations is not None and (skew := sorted(set(self.frames) & set(self.stations.nodes.ravel().tolist()))):
            raise ModelError(f"node {skew[0]} has axes of its own and a contact station; the stations read global axes")
