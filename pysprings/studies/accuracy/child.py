# SPDX-License-Identifier: MIT
"""One run in a process of its own: its peak memory is its own, and a lack of memory ends only it.

The process is this program again, started with the values of a checked scene; it answers in JSON. Nothing else in the
packages starts a process (`tests/fuzz/test_no_code.py`).
"""

from __future__ import annotations

import json
import multiprocessing
import signal
from collections.abc import Callable
from dataclasses import asdict
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.core.errors import Problem, PyspringsError, ResourceError, RunIncomplete, UserInputError

if TYPE_CHECKING:
    from pysprings.core.progress import Progress
    from pysprings.scene.load import Scene

Run = Callable[["Scene", Path, "Progress"], None]


def run_here(scene: Scene, folder: Path, progress: Progress) -> None:
    """Run a scene into a folder, or go on there, and time its unit; raises as `run_to_folder` does."""
    from pysprings.results.folder import run_or_go_on

    run_or_go_on(scene, folder, progress, time_unit=True)


def run_in_child(scene: Scene, folder: Path, progress: Progress) -> None:
    """Run a scene in a new process. KeyboardInterrupt passes through after the process has saved converged steps."""
    context = multiprocessing.get_context("spawn")
    mine, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(scene.model_dump(), folder, theirs), daemon=True)
    process.start()
    theirs.close()
    try:
        error = _listen(mine, progress)
        process.join()
    except KeyboardInterrupt:
        process.terminate()  # asks it to stop after its step: see _work
        process.join()
        raise
    finally:
        mine.close()
    if error is not None:
        raise error
    if process.exitcode:
        raise _ended(process.exitcode)


def _listen(pipe: Connection, progress: Progress) -> PyspringsError | None:
    """Pass on the progress of the process until it ends; return the message that ended it early."""
    error: PyspringsError | None = None
    while True:
        try:
            kind, content = json.loads(pipe.recv_bytes())
        except EOFError:
            return error
        if kind == PROGRESS:
            progress(*content)
        elif kind == REFUSED:
            error = UserInputError([Problem(**each) for each in content])
        else:
            error = _ERRORS[kind](content)


PROGRESS, REFUSED = "progress", "refused"
_ERRORS: dict[str, type[PyspringsError]] = {"incomplete": RunIncomplete, "resources": ResourceError}


def _work(values: dict[str, Any], folder: Path, pipe: Connection) -> None:
    """Run in the new process: Ctrl-C is the parent's affair, which asks with SIGTERM, once."""
    from pysprings.scene.load import Scene

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    def send(kind: str, content: Any) -> None:
        pipe.send_bytes(json.dumps([kind, content]).encode())

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, interrupt)
    try:
        run_here(Scene.model_validate(values), folder, lambda *report: send(PROGRESS, report))
    except UserInputError as error:
        send(REFUSED, [asdict(each) for each in error.problems])
    except (RunIncomplete, ResourceError) as error:
        send("incomplete" if isinstance(error, RunIncomplete) else "resources", str(error))
    except (KeyboardInterrupt, BrokenPipeError):
        pass
    finally:
        pipe.close()


def _ended(code: int) -> Exception:
    """Return the error for a process that ended by itself: killed, or a bug whose traceback it has left on stderr."""
    if code > 0:
        return RuntimeError(f"the process of the run ended with exit code {code}")
    hint = " (out of memory?)" if -code == _KILLED else ""
    return ResourceError(f"the process of the run was ended by {signal.Signals(-code).name}{hint}")


_KILLED = 9
