# SPDX-License-Identifier: MIT
"""Linear solvers: all backends against a dense solve, reuse of the analysis, refusals."""

import importlib.util
import re
import sys
import warnings

import numba
import numpy as np
import pytest
from scipy.sparse import csr_matrix, diags, identity, kron

from fe_engine import memory
from fe_engine.errors import LinearSolverError
from fe_engine.linear import backends
from fe_engine.linear.backends import SUPERLU_COMFORT, SymmetricPardiso, available_backends, make_backend
from fe_engine.linear.solver import LinearSolver

HAS_PARDISO, HAS_RSLAB = (importlib.util.find_spec(name) is not None for name in ("pypardiso", "rslab"))
needs_pardiso = pytest.mark.skipif(not HAS_PARDISO, reason="pypardiso is not installed")
needs_rslab = pytest.mark.skipif(not HAS_RSLAB, reason="rslab is not installed")
BACKENDS = ["superlu", pytest.param("pardiso", marks=needs_pardiso), pytest.param("rslab", marks=needs_rslab)]


@pytest.fixture(params=BACKENDS)
def name(request):
    return request.param


def laplacian(n=7, shift=1.0):
    """Grid Laplacian (n*n) plus shift; singular (constants) for shift 0."""
    line = diags([-np.ones(n - 1), np.r_[1.0, 2.0 * np.ones(n - 2), 1.0], -np.ones(n - 1)], [-1, 0, 1])
    return csr_matrix(kron(line, identity(n)) + kron(identity(n), line) + shift * identity(n * n))


def unsymmetric(seed):
    """Well-conditioned values, not symmetric, on the pattern of a grid."""
    matrix = laplacian()
    rng = np.random.default_rng(seed)
    matrix.data = rng.uniform(-1.0, 1.0, matrix.nnz)
    matrix.setdiag(rng.uniform(5.0, 50.0, matrix.shape[0]))
    return matrix


def rhs_of(matrix, shape=()):
    return np.random.default_rng(9).normal(size=(matrix.shape[0], *shape))


# --- condition --------------------------------------------------------------------------------------------


def test_condition_is_estimated_from_below(name):
    values = np.r_[np.geomspace(1.0, 10.0, 40), 1e-4, 1e3]
    matrix = csr_matrix(diags(values))
    solver = LinearSolver(name, len(values))
    assert solver.condition_estimate() is None
    solver.factorise(matrix)
    assert 0.5e7 < solver.condition_estimate() <= 1e7 * (1.0 + 1e-9)
    solver.close()


# --- right answers ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(), (1,), (4,)], ids=["vector", "one column", "four columns"])
def test_solution_equals_the_dense_one(name, shape):
    matrix = unsymmetric(1)
    rhs = rhs_of(matrix, shape)
    before = rhs.copy()
    solver = LinearSolver(name, matrix.shape[0])
    solver.factorise(matrix)
    x = solver.solve(rhs)
    assert x.shape == rhs.shape
    np.testing.assert_allclose(x, np.linalg.solve(matrix.toarray(), rhs), rtol=1e-10, atol=1e-14)
    np.testing.assert_array_equal(rhs, before)
    solver.close()


def test_new_values_on_the_old_pattern(name):
    """New objects and values changed in place: each factorisation answers for its own values."""
    matrix = unsymmetric(1)
    solver, rhs = LinearSolver(name, matrix.shape[0]), rhs_of(matrix, (2,))
    for seed in (1, 2, 3):
        matrix.data[...] = 10.0 ** (3 * seed) * unsymmetric(seed).data
        for each in (matrix, 1.0e-6 * unsymmetric(seed + 10)):
            solver.factorise(each)
            np.testing.assert_allclose(solver.solve(rhs), np.linalg.solve(each.toarray(), rhs), rtol=1e-10)
    assert (solver.n_factorisations, solver.n_solves) == (6, 6)
    assert solver.worst_residual < 1.0e-12
    solver.close()


@needs_pardiso
def test_pardiso_analyses_the_pattern_once(monkeypatch):
    backend, phases = make_backend("pardiso", 10), []
    call = backend.call
    monkeypatch.setattr(backend, "call", lambda phase, *given: phases.append(phase) or call(phase, *given))
    for seed in (1, 2, 3):
        backend.factorise(unsymmetric(seed))
        backend.solve(rhs_of(laplacian()))
    assert phases == [11, 22, 33, 22, 33, 22, 33]
    backend.close()


@needs_rslab
def test_what_rslab_factorised_before_leaves_no_trace_in_a_bit():
    """Of a first matrix that needs rows exchanged, either, nor do threads."""
    first, second, rhs = unsymmetric(1), unsymmetric(2), rhs_of(laplacian())
    first[0, 0] = 0.0
    answers = []
    for matrices, threads in (((second,), 1), ((first, second), 1), ((second,), numba.config.NUMBA_NUM_THREADS)):
        backend, before = make_backend("rslab", 49), numba.get_num_threads()
        numba.set_num_threads(threads)
        for matrix in matrices:
            backend.factorise(matrix)
        answers.append(backend.solve(rhs))
        numba.set_num_threads(before)
    assert np.array_equal(answers[0], answers[1]) and np.array_equal(answers[0], answers[2])
    np.testing.assert_allclose(second @ answers[0], rhs, atol=1e-12)


@pytest.mark.parametrize("name", BACKENDS[1:])
def test_what_factors_need_is_judged_before_they_are_made(name, monkeypatch):
    backend, matrix = make_backend(name, 10), laplacian()
    with monkeypatch.context() as short:
        short.setattr(memory, "left", lambda: 0.0)
        with pytest.raises(MemoryError, match=rf"factorisation of {matrix.shape[0]} unknowns needs \S+ GB, 0 GB are"):
            backend.factorise(matrix)
    backend.factorise(matrix)
    np.testing.assert_allclose(matrix @ backend.solve(rhs_of(matrix)), rhs_of(matrix), atol=1e-12)
    backend.close()


@pytest.mark.parametrize("other", BACKENDS[1:])
def test_backends_agree(other):
    matrix, answers = unsymmetric(4), []
    for name in ("superlu", other):
        solver = LinearSolver(name, matrix.shape[0])
        solver.factorise(matrix)
        answers.append(solver.solve(rhs_of(matrix)))
        solver.close()
    np.testing.assert_allclose(*answers, rtol=1e-12)


def test_zero_right_hand_side_has_the_zero_solution(name):
    solver = LinearSolver(name, 49)
    solver.factorise(laplacian())
    np.testing.assert_array_equal(solver.solve(np.zeros((49, 2))), 0.0)
    solver.close()


def test_time_is_counted_by_phase(name):
    solver = LinearSolver(name, 49)
    solver.factorise(laplacian())
    solver.solve(np.ones(49))
    assert set(solver.clock.wall) == set(solver.clock.cpu) == {"factorisation", "solve"}
    assert all(seconds > 0.0 for seconds in solver.clock.wall.values())
    solver.close()


# --- refusals ---------------------------------------------------------------------------------------------


def empty_row():
    matrix = laplacian().tolil()
    matrix[3, :] = 0.0
    out = csr_matrix(matrix)
    return out + csr_matrix(([0.0], ([3], [3])), out.shape)


@pytest.mark.parametrize("matrix", [laplacian(shift=0.0), empty_row()], ids=["free to float", "empty row"])
def test_singular_matrix_is_refused(name, matrix):
    solver = LinearSolver(name, 49)
    with pytest.raises(LinearSolverError):
        solver.factorise(matrix)
        solver.solve(np.ones(49) + rhs_of(matrix))
    solver.close()


@pytest.mark.parametrize("spoil", [lambda x: 1.01 * x, np.zeros_like, lambda x: np.full_like(x, np.nan)])
def test_a_wrong_solution_is_refused(monkeypatch, spoil):
    solver = LinearSolver("superlu", 49)
    solver.factorise(laplacian())
    solve = solver.backend.solve
    monkeypatch.setattr(solver.backend, "solve", lambda rhs: spoil(solve(rhs)))
    with pytest.raises(LinearSolverError, match="superlu returned a solution with relative residual"):
        solver.solve(np.ones(49))


def test_a_wrong_column_among_good_ones_is_refused(monkeypatch):
    """Also where it is small beside the others."""
    solver = LinearSolver("superlu", 49)
    solver.factorise(laplacian())
    solve = solver.backend.solve
    monkeypatch.setattr(solver.backend, "solve", lambda rhs: solve(rhs) * [1.0, 0.5])
    with pytest.raises(LinearSolverError):
        solver.solve(np.column_stack([1.0e9 * np.ones(49), np.ones(49)]))


def test_an_inaccurate_solution_is_refined(monkeypatch):
    matrix = unsymmetric(1)
    solver, rhs = LinearSolver("superlu", 49), rhs_of(matrix)
    solver.factorise(matrix)
    solve = solver.backend.solve
    monkeypatch.setattr(solver.backend, "solve", lambda b: (1.0 + 1.0e-5) * solve(b))
    np.testing.assert_allclose(solver.solve(rhs), np.linalg.solve(matrix.toarray(), rhs), rtol=2e-10)
    assert 0.0 < solver.worst_residual < 2.0e-10


# --- choice -----------------------------------------------------------------------------------------------


def test_unknown_name_lists_what_there_is():
    with pytest.raises(LinearSolverError, match=r"unknown linear solver 'mumps'; available: .*superlu"):
        make_backend("mumps", 10)


def test_auto_takes_the_best_one():
    best = "pardiso" if HAS_PARDISO else "rslab" if HAS_RSLAB else "superlu"
    assert make_backend("auto", 10).name == available_backends()[0] == best


def test_superlu_warns_where_it_gets_slow():
    with pytest.warns(UserWarning, match="SuperLU on 30001 unknowns"):
        make_backend("superlu", SUPERLU_COMFORT + 1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        make_backend("superlu", SUPERLU_COMFORT)


def broken_pardiso(single):
    raise OSError("libmkl_rt.so.2: cannot open shared object file")


def test_pardiso_that_does_not_load_says_so(monkeypatch):
    monkeypatch.setattr(backends, "Pardiso", broken_pardiso)
    with pytest.raises(LinearSolverError, match="pardiso does not load here: libmkl_rt"):
        make_backend("pardiso", 10)


def test_auto_falls_back_where_pardiso_does_not_load(monkeypatch):
    monkeypatch.setattr(backends, "available_backends", lambda: ["pardiso", "superlu"])
    monkeypatch.setattr(backends, "Pardiso", broken_pardiso)
    assert make_backend("auto", 10).name == "superlu"


def test_rslab_that_is_not_installed_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "rslab", None)
    with pytest.raises(LinearSolverError, match="rslab does not load here"):
        make_backend("rslab", 10)


# --- memory -------------------------------------------------------------------------------------------------


def test_a_solver_that_was_never_used_is_closed(name):
    LinearSolver(name, 9).close()


@needs_pardiso
def test_pardiso_without_memory_says_so(monkeypatch):
    """A smaller step would not help, as it does where a factorisation fails."""
    solver = LinearSolver("pardiso", 49)

    def fail(*arguments):
        arguments[-1].value = -2

    monkeypatch.setattr(solver.backend, "pardiso", fail)
    with pytest.raises(MemoryError, match="not enough memory"):
        solver.factorise(laplacian())


@pytest.mark.parametrize("name", BACKENDS[1:])
def test_factors_in_single_precision_are_good_to_seven_digits(name):
    matrix, rhs = laplacian(), rhs_of(laplacian(), (3,))
    found = []
    for single in (False, True):
        backend = make_backend(name, 49, single=single)
        backend.factorise(matrix)
        found.append(backend.solve(rhs))
        backend.close()
    error = np.linalg.norm(found[1] - found[0]) / np.linalg.norm(found[0])
    assert 1.0e-9 < error < 1.0e-5


# --- symmetric matrices -----------------------------------------------------------------------------------


@needs_pardiso
def test_symmetric_factors_solve_the_whole_matrix_on_new_values_too():
    matrix, rhs = laplacian(), rhs_of(laplacian(), (3,))
    solver = LinearSolver("auto", matrix.shape[0], symmetric=True)
    assert isinstance(solver.backend, SymmetricPardiso)
    for factor in (1.0, 3.0):
        changed = matrix.copy()
        changed.data *= factor
        changed.setdiag(changed.diagonal() + factor**2)
        solver.factorise(changed)
        np.testing.assert_allclose(solver.solve(rhs), np.linalg.solve(changed.toarray(), rhs), rtol=1e-10, atol=1e-14)
    solver.close()


@needs_pardiso
def test_a_matrix_that_is_not_symmetric_is_refused_with_its_solution():
    matrix = unsymmetric(1)
    solver = LinearSolver("pardiso", matrix.shape[0], symmetric=True)
    solver.factorise(matrix)
    with pytest.raises(LinearSolverError, match="relative residual"):
        solver.solve(rhs_of(matrix))
    solver.close()


@needs_pardiso
def test_a_matrix_that_is_not_positive_definite_is_refused():
    matrix = laplacian(shift=-1.0)
    solver = LinearSolver("pardiso", matrix.shape[0], symmetric=True)
    with pytest.raises(LinearSolverError, match="Pardiso"):
        solver.factorise(matrix)
    solver.close()


def test_superlu_takes_symmetric_matrices_as_any_other():
    matrix, rhs = laplacian(), rhs_of(laplacian())
    solver = LinearSolver("superlu", matrix.shape[0], symmetric=True)
    solver.factorise(matrix)
    np.testing.assert_allclose(solver.solve(rhs), np.linalg.solve(matrix.toarray(), rhs), rtol=1e-10)


# --- refinement -------------------------------------------------------------------------------------------


class Rough:
    """A backend whose answers are a share too large, as factors of single precision may be."""

    name = "rough"

    def __init__(self, matrix, share):
        self.dense, self.share, self.calls = matrix.toarray(), share, 0

    def solve(self, rhs):
        self.calls += 1
        return (1.0 + self.share) * np.linalg.solve(self.dense, rhs)

    def close(self):
        pass


@pytest.mark.parametrize(("share", "calls"), [(0.0, 1), (1e-10, 1), (1e-8, 2), (1e-4, 2)])
def test_a_rough_answer_is_refined_once(share, calls):
    """A relative residual of ``share`` is squared by one more solve."""
    matrix = unsymmetric(3)
    rhs, solver = rhs_of(matrix), LinearSolver("superlu", matrix.shape[0])
    solver.factorise(matrix)
    solver.backend = rough = Rough(matrix, share)
    x = solver.solve(rhs)
    assert (rough.calls, solver.n_solves) == (calls, 1)
    assert solver.worst_residual == pytest.approx(share if calls == 1 else share**2, rel=1e-2, abs=1e-13)
    np.testing.assert_allclose(x, np.linalg.solve(matrix.toarray(), rhs), rtol=max(2.0 * share**calls, 1e-10))


def test_an_answer_that_stays_rough_is_refused():
    matrix = unsymmetric(3)
    rhs, solver = rhs_of(matrix), LinearSolver("superlu", matrix.shape[0])
    solver.factorise(matrix)
    solver.backend = Rough(matrix, 2e-3)
    with pytest.raises(LinearSolverError, match=r"^rough returned a solution with relative residual 4\.0e-06$"):
        solver.solve(rhs)


@pytest.mark.parametrize("name", BACKENDS)
def test_a_record_has_what_last_digits_depend_on(name):
    found = make_backend(name, 10).versions()
    assert set(found) == {"superlu": set(), "pardiso": {"MKL", "threads of MKL"}, "rslab": {"rslab"}}[name]
    assert all(re.fullmatch(r"\d+(\.\d+)*", text) for text in found.values())
