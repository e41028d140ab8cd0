"""The beam of beam.py with dolfinx and PETSc: dolfinx_beam.py FILE [icc | gamg | jacobi]

With gamg the preconditioner of the first linear system is kept for all later ones.
"""

import json
import sys
import time

import dolfinx
import dolfinx.fem.petsc
import numpy as np
import ufl
from mpi4py import MPI
from petsc4py import PETSc

# The loops over elements get all instructions of this processor. PETSc is as it was packaged.
COMPILER = {"cffi_extra_compile_args": ["-O3", "-march=native", "-ffast-math"]}
MOST_ITERATIONS = 50


def peak_bytes():
    """The same as in beam.h."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(1024 * int(line.split()[1]) for line in file if line.startswith("VmHWM:"))


def read_beam(path):
    """The numbers and tables of the file by their names."""
    tables = {"vertices": float, "tetrahedra": np.int64, "held": np.int64, "tip": np.int64}
    beam = {}
    with open(path, encoding="ascii") as file:
        for line in file:
            name, value = line.split()
            if name in tables:
                rows = int(value)
                beam[name] = np.loadtxt(file, dtype=tables[name], max_rows=rows).reshape(rows, -1)
            else:
                beam[name] = float(value)
    return beam


def compiled(form):
    return dolfinx.fem.form(form, jit_params=COMPILER)


class Body:
    def __init__(self, beam, solver):
        self.beam, self.h, self.kept = beam, beam["step"], solver == "gamg"
        element = ufl.VectorElement("Lagrange", ufl.tetrahedron, 1)
        mesh = dolfinx.mesh.create_mesh(MPI.COMM_SELF, beam["tetrahedra"], beam["vertices"], ufl.Mesh(element))
        space = dolfinx.fem.FunctionSpace(mesh, element)
        self.set_vertices(mesh, space)
        self.set_forms(mesh, space)
        self.set_solver(solver)
        count = len(self.mass)
        self.velocity, self.earlier_velocity = np.zeros(count), np.zeros(count)
        self.steps, self.first_forcing, self.iterations = 0, 0.01, 0

    def set_vertices(self, mesh, space):
        """dolfinx numbers the vertices anew, both of the mesh and of functions."""
        names = np.asarray(mesh.geometry.input_global_indices)[mesh.geometry.dofmap.array]
        block_of = np.empty(len(self.beam["vertices"]), dtype=np.int32)
        block_of[names] = space.dofmap.list.array
        held = block_of[self.beam["held"].ravel()]
        self.held = (3 * held[:, None] + np.arange(3)).ravel()
        self.wall = dolfinx.fem.dirichletbc(np.zeros(3), held, space)
        self.tip_blocks = block_of[self.beam["tip"].ravel()]
        self.points = np.empty((len(block_of), 3))
        self.points[block_of] = self.beam["vertices"]

    def set_forms(self, mesh, space):
        young, poisson = self.beam["youngs_modulus"], self.beam["poissons_ratio"]
        mu = dolfinx.fem.Constant(mesh, young / (2 * (1 + poisson)))
        lambda_ = dolfinx.fem.Constant(mesh, young * poisson / ((1 + poisson) * (1 - 2 * poisson)))
        self.u = dolfinx.fem.Function(space)
        change, test = ufl.TrialFunction(space), ufl.TestFunction(space)
        deformation = ufl.Identity(3) + ufl.grad(self.u)
        log = ufl.ln(ufl.det(deformation))
        energy = mu / 2 * (ufl.tr(deformation.T * deformation) - 3 - 2 * log) + lambda_ / 2 * log**2
        gradient = ufl.derivative(energy * ufl.dx(metadata={"quadrature_degree": 0}), self.u, test)
        self.gradient, self.hessian = compiled(gradient), compiled(ufl.derivative(gradient, self.u, change))
        density = dolfinx.fem.Constant(mesh, np.full(3, self.beam["density"]))
        mass = compiled(ufl.inner(density, test) * ufl.dx(metadata={"quadrature_degree": 1}))
        self.mass = dolfinx.fem.petsc.assemble_vector(mass).array.copy()
        self.load = np.zeros_like(self.mass)
        self.load[1::3] = -self.beam["gravity"] * self.mass[1::3]
        # Products with 3 × 3 blocks take less than half the time. GAMG cannot read them.
        kind = "aij" if self.kept else "baij"
        self.matrix = dolfinx.fem.petsc.create_matrix(self.hessian, kind)
        self.matrix.setOption(PETSc.Mat.Option.SPD, True)
        self.residual = dolfinx.fem.petsc.create_vector(self.gradient)
        self.correction, self.diagonal = self.matrix.createVecRight(), self.matrix.createVecRight()
        self.diagonal.array = self.mass / self.h**2

    def set_solver(self, solver):
        self.solver = PETSc.KSP().create(MPI.COMM_SELF)
        self.solver.setType("cg")
        self.solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        self.solver.setOperators(self.matrix)
        self.solver.getPC().setType({"icc": "icc", "gamg": "gamg", "jacobi": "pbjacobi"}[solver])
        if self.kept:
            options = PETSc.Options()
            options["mg_levels_ksp_type"], options["mg_levels_pc_type"] = "chebyshev", "jacobi"
            options["pc_gamg_threshold"] = 0.01
            self.matrix.setNearNullSpace(self.rigid_motions())
        self.solver.setFromOptions()

    def rigid_motions(self):
        x, y, z = self.points.T
        motions = np.zeros((len(self.mass), 6))
        for axis in range(3):
            motions[axis::3, axis] = 1
        motions[0::3, 3], motions[1::3, 3] = -y, x
        motions[1::3, 4], motions[2::3, 4] = -z, y
        motions[2::3, 5], motions[0::3, 5] = -x, z
        vectors = []
        for motion in np.linalg.qr(motions)[0].T:
            vectors.append(self.matrix.createVecLeft())
            vectors[-1].array = motion
        return PETSc.NullSpace().create(vectors=vectors)

    def assemble_residual(self, inertial):
        """Returns the norm."""
        with self.residual.localForm() as local:
            local.set(0)
        dolfinx.fem.petsc.assemble_vector(self.residual, self.gradient)
        r = self.residual.array
        r += self.mass / self.h**2 * (self.u.x.array - inertial) - self.load
        r[self.held] = 0
        return np.linalg.norm(r)

    def assemble_matrix(self):
        self.matrix.zeroEntries()
        dolfinx.fem.petsc.assemble_matrix(self.matrix, self.hessian, bcs=[self.wall])
        self.matrix.assemble()
        self.matrix.setDiagonal(self.diagonal, addv=True)

    def solve(self, forcing):
        self.solver.setOperators(self.matrix)
        self.solver.setTolerances(rtol=forcing, max_it=100000)
        self.solver.solve(self.residual, self.correction)
        if self.solver.getConvergedReason() < 0:
            raise RuntimeError(f"Conjugate gradients failed: {self.solver.getConvergedReason()}.")
        self.iterations += self.solver.getIterationNumber()
        if self.kept:
            self.solver.getPC().setReusePreconditioner(True)

    def step(self):
        """Makes a step; returns its iterations of Newton's method."""
        u = self.u.x.array
        start = u.copy()
        inertial = start + self.h * self.velocity
        force = self.load + self.mass * self.velocity / self.h
        force[self.held] = 0
        limit = self.beam["tolerance"] * np.linalg.norm(force)

        if self.steps > 0:
            u += self.h * (2 * self.velocity - self.earlier_velocity)
        norm = self.assemble_residual(inertial)
        forcing, newton = self.first_forcing, 0
        while norm > limit:
            if newton == MOST_ITERATIONS or not np.isfinite(norm):
                raise RuntimeError("Newton's method failed.")
            self.assemble_matrix()
            self.solve(max(min(forcing, 0.1), 0.3 * limit / norm))
            u -= self.correction.array
            reduction = self.assemble_residual(inertial) / norm
            norm *= reduction
            forcing = 0.5 * reduction**2
            newton += 1
            if newton == 1:
                self.first_forcing = min(max(0.5 * reduction, 1e-4), 0.1)
        self.earlier_velocity, self.velocity = self.velocity, (u - start) / self.h
        self.steps += 1
        return newton

    def tip(self):
        return float(self.u.x.array[3 * self.tip_blocks + 1].mean())


def main():
    before = peak_bytes()
    solver = sys.argv[2] if len(sys.argv) > 2 else "icc"
    beam = read_beam(sys.argv[1])
    body = Body(beam, solver)
    seconds, newton = [], 0
    for _ in range(int(beam["steps"])):
        start = time.perf_counter()
        newton += body.step()
        seconds.append(time.perf_counter() - start)
    print(json.dumps({
        "program": "dolfinx", "version": dolfinx.__version__, "solver": solver, "seconds": seconds,
        "newton": newton, "iterations": body.iterations, "bytes": peak_bytes() - before, "tip": body.tip(),
    }))  # fmt: skip


if __name__ == "__main__":
    main()
