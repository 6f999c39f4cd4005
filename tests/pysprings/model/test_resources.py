# SPDX-License-Identifier: MIT
"""What cannot fit in memory or on disk is refused before anything is built, with the figures."""

import math
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from fe_engine import memory
from fe_engine.assembly.system import System
from pysprings import Scene
from pysprings.core.errors import ResourceError
from pysprings.model.build import build_model
from pysprings.model.forecast import resources
from pysprings.model.forecast.estimate import describe
from pysprings.results.folder import run_to_folder
from tests.support import tiny
from tests.support.commands import command, environment


@pytest.mark.parametrize("mode", ["drained", "coupled"])
@pytest.mark.parametrize("side", ["sealed", "drained"])
@pytest.mark.parametrize("mesh", [{}, {"azimuth": 12, "refinement": 0.6}, {"preset": "fine", "refinement": 0.3}])
@pytest.mark.parametrize("steel", ["rigid", "elastic"])
def test_counts_without_a_mesh_are_those_of_the_mesh(mode: str, side: str, mesh: dict, steel: str) -> None:
    given = {"drainage": {"mode": mode}, "domain": {"side_drainage": side}, "caisson": {"behaviour": steel}}
    scene = tiny.paper(mesh=mesh, paths=[tiny.PULL | {"rate": 1e-4}], **given)
    about, size = describe(scene), resources.size_of(scene)
    counts = about["mesh"]["nodes"], about["mesh"]["elements"], about["unknowns"]
    assert (size.nodes, size.elements, size.unknowns) == counts
    assert (about["mesh"]["steel_elements"] > 0) == (steel == "elastic")


def test_bytes_of_a_step_are_those_of_a_result() -> None:
    result = tiny.result()["paths/pull"].to_dataset(inherit=False)
    assert resources.size_of(tiny.scene()).step_bytes == pytest.approx(result.nbytes / result.sizes["step"], rel=0.15)


@pytest.mark.parametrize(
    ("unknowns", "water", "measured"),
    [(52_099, False, 1.1e9), (71_241, True, 2.3e9), (6_575, True, 0.42e9), (4_631, False, 0.44e9)],
)
def test_memory_is_what_was_measured(unknowns: int, water: bool, measured: float) -> None:
    """Peak memory on two cores with Pardiso: the `paper` mesh drained and coupled, `coarse` coupled and drained."""
    assert resources.memory_bytes(unknowns, water) == pytest.approx(measured, rel=0.1)


def limited(monkeypatch: pytest.MonkeyPatch, limit: float) -> None:
    monkeypatch.setattr(resources, "memory_limit", lambda: limit)


def test_a_model_that_cannot_fit_is_refused_before_it_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    """An eightfold refined `fine` mesh has a hundred million unknowns: this must not take a second."""
    pytest.importorskip("pypardiso")  # its memory
    huge = tiny.paper(mesh={"preset": "fine", "refinement": 8})
    with pytest.raises(ResourceError, match=r"about [0-9,]+ GB of memory \([0-9,]+ nodes.* GB are there: choose"):
        describe(huge)
    limited(monkeypatch, 0.4e9)
    with pytest.raises(ResourceError, match=r"needs about 0\.401 GB of memory \(1,848 nodes.*, 0\.4 GB are there"):
        describe(tiny.paper())
    with pytest.raises(ResourceError, match="1,848 nodes"):
        run_to_folder(tiny.paper(), "never")
    assert not Path("never").exists()


def test_too_many_increments_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = tiny.scene(solver={"first_step_fraction": 1e-9, "max_step_fraction": 1e-9})
    with pytest.raises(ResourceError, match=r"1 path of 1e\+09 increments at least, which need .* GB of memory"):
        describe(scene)
    monkeypatch.setattr(resources, "memory_limit", lambda: math.inf)
    with pytest.raises(ResourceError, match=r"increments at least, .* GB in full_model.nc; .* free: take a larger"):
        resources.refuse_full_disk(scene.replace(solver={"max_step_fraction": 1e-9}), tmp_path / "a" / "b")


def test_a_full_disk_is_refused_by_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda place: SimpleNamespace(free=100))
    with pytest.raises(ResourceError, match=f"{tmp_path} has 1e-07 GB free"):
        run_to_folder(tiny.scene(), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_check_ends_with_exit_code_4(tmp_path: Path) -> None:
    (tmp_path / "c.toml").write_text(
        tiny.grounded("[mesh]\nrefinement = 8\npreset = 'fine'\ndiscretisation = 'hex8'\n")
    )
    done = command("check", str(tmp_path / "c.toml"))
    assert done.code == 4
    assert done.err.startswith("fatal: resources: the model needs about ")
    assert done.err.count("\n") == 1


def test_check_names_warnings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Memory that other programs use now, and motions beyond small strains."""
    pytest.importorskip("pypardiso")  # its memory
    monkeypatch.setattr("pysprings.model.forecast.estimate.memory_available", lambda: 1e6)
    text = '[mesh]\ndiscretisation = "hex8"\n[[path]]\nname = "a"\nkind = "pull"\nlateral_displacement = "0.5 m"\n'
    (tmp_path / "c.toml").write_text(tiny.grounded(text))
    done = command("check", str(tmp_path / "c.toml"))
    assert done.code == 0
    assert re.search(r"warning: the run needs about 0\.4\d* GB of memory; 0\.001 GB are free now", done.err)
    assert "warning: path 'a': a displacement of 0.5 m" in done.err


# --- control groups ---


@pytest.mark.parametrize(
    ("line", "files", "limit"),
    [
        ("0::/a/b", {"a/memory.max": "5000\n", "a/b/memory.max": "max\n"}, 5000.0),
        ("0::/", {"memory.max": "7000"}, 7000.0),
        ("4:memory:/c", {"memory/c/memory.limit_in_bytes": "9000"}, 9000.0),
        ("3:cpu:/c", {"memory.max": "1"}, math.inf),
        ("0::/../..", {}, math.inf),
    ],
)
def test_limits_of_control_groups_are_found(tmp_path: Path, line: str, files: dict[str, str], limit: float) -> None:
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "self").write_text(line + "\n")
    assert min(memory.cgroup_limits(tmp_path, tmp_path / "self")) == limit


def test_the_limit_is_no_more_than_the_machine() -> None:
    import psutil

    assert 0.0 < memory.left() <= memory.limit() <= psutil.virtual_memory().total


# --- a limit of the shell on the address space ---

# a run loads the libraries; the next has 20 MB left when its model is there
SQUEEZED = """
import resource
import psutil
from pysprings.full_model.compute import compute
from tests.support import tiny

def squeeze(path, fraction, message):
    if (path, fraction) == ("model", 1.0):
        room = psutil.Process().memory_info().vms + 20_000_000
        resource.setrlimit(resource.RLIMIT_AS, (room, resource.RLIM_INFINITY))

compute(tiny.scene())
try:
    compute(tiny.scene(mesh={"preset": "medium", "refinement": 0.5}), progress=squeeze)
except MemoryError as error:
    print(error)
"""


def limited_process(*args: object, room: int | None = None, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run Python in a process of its own, with ``room`` bytes of address space."""
    resource = pytest.importorskip("resource")
    if not sys.platform.startswith("linux"):
        pytest.skip("other systems do not hold the limit")

    def limit() -> None:
        if room is not None:
            resource.setrlimit(resource.RLIMIT_AS, (room, room))

    env = environment()
    command = [sys.executable, *map(str, args)]
    return subprocess.run(command, preexec_fn=limit, capture_output=True, text=True, cwd=cwd, env=env, timeout=300)


@pytest.mark.slow
def test_a_run_without_room_for_libraries_is_refused(tmp_path: Path) -> None:
    """Issue: OpenBLAS took all of a core for ever, deaf to SIGTERM, or MKL ended the process without a message."""
    scene = tiny.write(tiny.scene(), tmp_path / "a.toml")
    done = limited_process("-m", "pysprings", "run", scene, "--out", "out", room=850_000_000, cwd=tmp_path)
    assert done.returncode == 4, done.stderr
    (message,) = [line for line in done.stderr.splitlines() if line.startswith("fatal: ")]
    pattern = r"fatal: resources: the run needs about (\S+) GB of address space \(.* GB for libraries\), 0\.85 GB are"
    assert float(re.match(pattern, message)[1]) > 0.85
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_what_a_dense_block_needs_is_judged_before_it_is_made(tmp_path: Path) -> None:
    """Issue: OpenBLAS asked for its working memory for ever."""
    pytest.importorskip("pypardiso")
    done = limited_process("-c", SQUEEZED, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    pattern = r"(the inverse of the interface|the factorisation|what is left).* needs \S+ GB, 0\.0\d* GB are left\n"
    assert re.fullmatch(pattern, done.stdout), done.stdout


def test_more_unknowns_need_more_address_space(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resources, "address_space", lambda: 1.0)

    def needed(scene: Scene) -> float:
        with pytest.raises(ResourceError, match="address space") as caught:
            resources.refuse_what_cannot_fit(scene)
        return float(re.search(r"about (\S+) GB of address", str(caught.value))[1])

    assert needed(tiny.scene()) < needed(tiny.paper(mesh={"preset": "paper"}))
    monkeypatch.setattr(resources, "address_space", lambda: math.inf)
    resources.refuse_what_cannot_fit(tiny.scene())


def test_what_is_not_left_is_refused_with_the_figures() -> None:
    memory.require(1e3, "a little")
    with pytest.raises(MemoryError, match=r"^a world needs 1e\+09 GB, \S+ GB are left$"):
        memory.require(1e18, "a world")


# --- what `pysprings check` says before anything is solved ---


def test_counts_are_those_of_the_model_that_would_run() -> None:
    scene = tiny.scene(caisson={"vertical_load": "3 MN"})
    about, built = describe(scene), build_model(scene)
    system = System(built.model)
    assert about["mesh"]["nodes"] == built.model.mesh.n_nodes
    assert about["mesh"]["elements"] == built.model.mesh.n_elements
    assert about["mesh"]["interface_stations"] == len(system.stations.area)
    assert about["unknowns"] == system.pattern.n_free + 3
    assert about["vertical_load_N"] == pytest.approx(3e6)
    assert about["left_out"]


def test_a_path_off_a_plane_needs_the_whole_model_beside_the_half() -> None:
    """Both families: pressures of 2 N + 1 slots instead of N + 1, the interface with their square."""
    twist = {"name": "t", "kind": "twist", "twist": 1e-3, "duration": 9.0, "role": "held-back"}
    for mode in ("drained", "coupled"):
        pull = {"name": "p", "kind": "pull", "lateral_displacement": 1e-3} | (
            {"rate": 1e-4} if mode == "coupled" else {}
        )
        sections = {"mesh": {"discretisation": "fourier"}, "drainage": {"mode": mode}}
        half, both = (resources.model_bytes(tiny.scene(paths=each, **sections)) for each in ((pull,), (pull, twist)))
        assert half < both < half + 4.5 * (half - 0.37e9)


def test_the_fit_of_springs_with_memory_counts() -> None:
    """The fan of the template on `coarse`, one process: 1.04 GB with memory, of which 0.38 were stated."""
    scene = tiny.scene(mesh={"discretisation": "fourier"}, springs={"reach": 0.02}, paths=())
    more = resources.model_bytes(scene.replace(springs={"memory": True})) - resources.model_bytes(scene)
    assert more == pytest.approx(0.6e9)


def test_the_estimate_for_the_coarse_mesh_is_of_the_right_size() -> None:
    """Measured on two cores, with the slower solver of before: 25 to 40 s, and 0.43 GB, for the default scene."""
    about = describe(tiny.paper())
    assert 5.0 < about["time_s"] < 150.0
    assert 0.2 < about["memory_GB"] < 1.0
