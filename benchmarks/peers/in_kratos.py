# SPDX-License-Identifier: MIT
"""The elastic caisson in Kratos: `python in_kratos.py elastic problem.npz` (StructuralMechanicsApplication)."""

import json
import sys

import KratosMultiphysics as Kratos
import KratosMultiphysics.StructuralMechanicsApplication as Structural
import numpy as np


def main() -> None:
    """Print H/u and M/u of the whole caisson; its bricks have no mean dilatation."""
    data = np.load(sys.argv[2])
    part = Kratos.Model().CreateModelPart("soil", 2)
    for name in (Kratos.DISPLACEMENT, Kratos.REACTION, Kratos.VOLUME_ACCELERATION):
        part.AddNodalSolutionStepVariable(name)
    part.ProcessInfo[Kratos.DOMAIN_SIZE] = 3
    for k, x in enumerate(data["nodes"], 1):
        part.CreateNewNode(k, *map(float, x))
    law = part.CreateNewProperties(1)
    law[Kratos.YOUNG_MODULUS], law[Kratos.POISSON_RATIO] = float(data["young"]), float(data["poisson"])
    law[Kratos.CONSTITUTIVE_LAW] = Structural.LinearElastic3DLaw()
    for k, corners in enumerate(data["hexes"], 1):
        part.CreateNewElement("SmallDisplacementElement3D8N", k, [int(c) + 1 for c in corners], law)
    dofs = ((Kratos.DISPLACEMENT_X, Kratos.REACTION_X), (Kratos.DISPLACEMENT_Y, Kratos.REACTION_Y))
    dofs = (*dofs, (Kratos.DISPLACEMENT_Z, Kratos.REACTION_Z))
    for dof in dofs:
        Kratos.VariableUtils().AddDof(*dof, part)
    skirt = np.unique(data["node"])
    for k, held in enumerate(data["fixed"]):
        for dof in range(3):
            if held[dof] or k in skirt:
                node = part.Nodes[k + 1]
                node.Fix(dofs[dof][0])
                value = 1.0 if k in skirt and dof == 0 and not held[dof] else 0.0
                node.SetSolutionStepValue(dofs[dof][0], 0, value)
    solver = Kratos.LinearSolverFactory().Create(Kratos.Parameters('{"solver_type": "skyline_lu_factorization"}'))
    scheme = Kratos.ResidualBasedIncrementalUpdateStaticScheme()
    builder = Kratos.ResidualBasedBlockBuilderAndSolver(solver)
    Kratos.ResidualBasedLinearStrategy(part, scheme, builder, True, False, False, False).Solve()
    force = np.array([list(part.Nodes[int(k) + 1].GetSolutionStepValue(Kratos.REACTION)) for k in skirt])
    x = data["nodes"][skirt]
    print(json.dumps({"H": 2.0 * force[:, 0].sum(), "M": 2.0 * (force[:, 2] @ x[:, 0] - force[:, 0] @ x[:, 2])}))


if __name__ == "__main__":
    main()
