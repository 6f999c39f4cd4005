# SPDX-License-Identifier: MIT
"""The case of Cerfontaine, Charlier & Collin (2018): its runs, figures, claims, and what decides them.

``cases`` lists the runs, ``runs`` runs it, ``measures`` reads numbers from a run, ``claims`` and ``sensitivity`` make
tables of them, ``figures`` draws, ``text`` and ``page`` write, ``reference`` keeps small results, ``study`` does
it all.
"""
