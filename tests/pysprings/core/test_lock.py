# SPDX-License-Identifier: MIT
"""The lock of a result folder: one run at a time, and none after its process."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from pysprings.core.errors import ResourceError
from pysprings.core.written import exclusive
from tests.support.commands import environment

HOLD = """
import sys, time
from pathlib import Path
from pysprings.core.written import exclusive
with exclusive(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def hold(folder: Path) -> subprocess.Popen[str]:
    """Start a process that holds the lock of a folder."""
    env = environment()
    other = subprocess.Popen([sys.executable, "-c", HOLD, str(folder)], stdout=subprocess.PIPE, text=True, env=env)
    assert other.stdout is not None and other.stdout.readline() == "held\n"
    return other


def test_another_process_is_named_and_its_death_frees_the_folder(tmp_path: Path) -> None:
    with hold(tmp_path) as other:
        with pytest.raises(ResourceError) as refused, exclusive(tmp_path):
            pass
        assert f"another run (process {other.pid} on " in str(refused.value)
        assert str(tmp_path) in str(refused.value)
        other.send_signal(signal.SIGKILL if os.name != "nt" else signal.SIGTERM)
        other.wait(timeout=30)
        with exclusive(tmp_path):
            pass
    assert list(tmp_path.iterdir()) == []


def test_a_thread_may_take_its_lock_again_and_another_may_not(tmp_path: Path) -> None:
    noted: list[str] = []

    def try_it() -> None:
        try:
            with exclusive(tmp_path):
                noted.append("taken")
        except ResourceError as error:
            noted.append(str(error))

    with exclusive(tmp_path), exclusive(tmp_path / "."):
        thread = threading.Thread(target=try_it)
        thread.start()
        thread.join()
        assert f"process {os.getpid()}" in noted[0]
    try_it()
    assert noted[1] == "taken"


def test_a_holder_that_cannot_be_read_is_not_named(tmp_path: Path) -> None:
    with hold(tmp_path) as other:
        (tmp_path / ".pysprings.lock.json").write_text("{")
        with pytest.raises(ResourceError, match=": another run writes into this folder;"), exclusive(tmp_path):
            pass
        other.kill()


def test_an_error_inside_frees_the_folder(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), exclusive(tmp_path):
        raise ZeroDivisionError
    with exclusive(tmp_path):
        pass
