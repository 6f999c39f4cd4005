# SPDX-License-Identifier: MIT
"""`pysprings explore`: a page on this machine to try loads on a run, and caissons, ground and loads on an atlas."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pysprings.cli.atlas import SHIPPED_ATLASES
from pysprings.cli.options import argument, option
from pysprings.cli.support import refuse, to_stderr

if TYPE_CHECKING:
    import socket

PORT = 8050
HOST = "127.0.0.1"


def explore(
    result: Annotated[Path | None, argument("[OUT]", "folder of a run, or springs.nc; or none with --atlas")] = None,
    atlas: Annotated[str | None, option("--atlas", f"explore {SHIPPED_ATLASES} instead of a run", "NAME|FILE")] = None,
    port: Annotated[
        int, typer.Option("--port", help="port of the page on 127.0.0.1; 0: any free one", min=0, max=65535)
    ] = PORT,
) -> None:
    """Serve a page on 127.0.0.1 to try loads. Of an atlas also caisson and ground; until Ctrl-C.

    It answers as `predict` and `design` do, with their marks and refusals, and shows the command of each answer. Needs
    the extra `explore`.
    """
    if (result is None) == (atlas is None):
        refuse("OUT", "give the folder of a run (or its springs.nc), or --atlas NAME")
    import logging

    from werkzeug.serving import make_server

    from pysprings.cli.page.page import application
    from pysprings.cli.page.sources import AtlasSource, RunSource

    app = application(AtlasSource.of(atlas) if atlas is not None else RunSource.of(result or Path()))
    taken = bound(port)
    number = taken.getsockname()[1]
    server = make_server(HOST, number, app.server, threaded=True, fd=taken.fileno())
    logging.getLogger("werkzeug").setLevel(logging.ERROR)  # a line a request
    print(f"http://{HOST}:{number}/", flush=True)
    to_stderr("the page is at this address of this machine; Ctrl-C ends it")
    server.serve_forever()


def bound(port: int) -> socket.socket:
    """Return a socket bound to a port of this machine (0: a free one); refuse one that is in use."""
    import socket

    try:
        return socket.create_server((HOST, port))
    except OSError as error:
        refuse("--port", f"{port} cannot be used ({error.strerror}): give another, or 0 for any free one")
