# SPDX-License-Identifier: MIT
"""Contact laws of the engine, one line each; see `register` for laws from outside."""

from __future__ import annotations

from fe_engine.contact import adhesion, coulomb
from fe_engine.contact.law import ContactLaw
from fe_engine.register import Register

CONTACT_LAWS: Register[ContactLaw] = Register("contact law", coulomb.LAW, adhesion.LAW)
