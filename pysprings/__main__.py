# SPDX-License-Identifier: MIT
"""`python -m pysprings` is the command `pysprings`."""

from pysprings.cli.app import main

if __name__ == "__main__":
    main()
