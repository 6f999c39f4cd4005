# SPDX-License-Identifier: MIT
"""From site investigations to the ground of a scene: cone penetration tests, points by depth and layers -> a proposal.

`files` reads what people bring, `sounding` holds a cone penetration test, its stresses and
layers, `correlations` names each formula with its source and range, `proposal` puts layers and values together,
`output` prints and writes them, `picture` draws them. A proposal becomes the ground of a scene by the table that a
person reads, edits and names in `soil.profile`.
"""
