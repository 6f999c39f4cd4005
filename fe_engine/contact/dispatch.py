# SPDX-License-Identifier: MIT
"""Traction of a station, and its linear model, by the code of its law."""

from __future__ import annotations

from fe_engine.contact.laws import CONTACT_LAWS

update_contact = CONTACT_LAWS.chain("update", "p, slide, traction", __name__)
linearise_contact = CONTACT_LAWS.chain("linearise", "p, slide, guess, traction, tangent", __name__)
