# SPDX-License-Identifier: MIT
"""Choose the next step of an increment from its iterations: length, accuracy, and whether to continue.

Friction makes the residual a poor judge. Where a station slips past its stick range the residual jumps by the whole
friction force, and the next iteration, which lets that station stick (see contact.coulomb), takes it away again. The
corrections, displacements, separate such a jump from a diverging iteration: a full step is taken where the residual
does not grow, or where the correction that would follow is no larger than this one (natural monotonicity, Deuflhard
2004); it is then the next step, and has cost nothing. Else the step is halved.
"""

from __future__ import annotations

from dataclasses import dataclass, field

HALVINGS = 3  # of a step: shorter ones would leave the iterate where it is
_ASTRAY = 0.3  # relative residual beyond which the next correction is not computed: it has always been larger

# An increment stalls if no correction of the window is smaller than those before. It is given up, since a smaller
# increment has fewer contact states to find. Close to the solution few stations alternate between two states, and half
# steps converge between them.
_WINDOW = 4  # corrections
CLOSE = 1.0e-3  # relative residual below which half steps are taken
HALF = 0.5  # length of a half step
_GAIN = 0.7  # the residual must fall to this share ...
_PATIENCE = 4  # ... in so many half steps
_LINEAR = (0.45, 0.55)  # share left by a half step of linear equations: half steps end

# Relative residual of a linear solve: of the first one, then by the fall of the residual (choice 2 of Eisenstat &
# Walker 1996). Where contact limits that fall, an exact step gains nothing.
_FIRST = 0.03
_GAMMA = 0.9  # factor on the fall
_POWER = 2.0  # exponent of the fall

# Bounds of that relative residual, reached with _OF_UNKNOWNS unknowns.
_ENOUGH = 1.0e-2  # smallest
_LOOSEST = 0.1  # largest
_OF_UNKNOWNS = 50_000
_SMALL = 10_000  # unknowns; smaller models solve to EXACT: their results do not depend on the number of threads
EXACT = 1.0e-8
# An increment without a guess has to find all contact states, from displacements that a residual of 1 % may leave
# wrong by their own size.
_FAR = 1.0e-4


def bounds(n_unknowns: int) -> tuple[float, float]:
    """Return the shares of its residual within which a linear system of so many unknowns is solved."""
    if n_unknowns < _SMALL:
        return EXACT, EXACT
    size = min(n_unknowns / _OF_UNKNOWNS, 1.0)
    return size * _ENOUGH, size * _LOOSEST


@dataclass
class Course:
    """Residuals and corrections of the iterates of one increment so far.

    Attributes
    ----------
    merits, errors : residuals of the iterates, in N and relative.
    sizes : of the full corrections from them, m.
    half : whether half steps are being taken.
    far : whether the increment began without a guess.
    bounds : shares of its residual within which a linear system is solved.
    close : relative residual below which an increment that stalls goes on by half steps.
    """

    far: bool = False
    bounds: tuple[float, float] = (_ENOUGH, _LOOSEST)
    close: float = CLOSE
    merits: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    sizes: list[float] = field(default_factory=list)
    half: bool = False
    _since: int = 0  # iterate from which on it is watched, or half steps are taken
    _best: float = 0.0  # merit that half steps are held against

    def add(self, merit: float, error: float) -> bool:
        """Note an iterate; return False where the increment should be given up."""
        self.merits.append(merit)
        self.errors.append(error)
        if self.half:
            return self._go_on_by_halves()
        sizes = self.sizes[self._since :]
        if len(sizes) <= _WINDOW or min(sizes[-_WINDOW:]) < min(sizes[:-_WINDOW]):
            return True
        self.half, self._since, self._best = error <= self.close, len(self.merits), max(self.merits[-2:])
        return self.half

    def _go_on_by_halves(self) -> bool:
        before, now = self.merits[-2:]
        if _LINEAR[0] * before < now < _LINEAR[1] * before:
            self.half, self._since = False, len(self.sizes)
            return True
        best = min(self.merits[self._since :])
        if best < _GAIN * self._best:
            self._since, self._best = len(self.merits), best
        return len(self.merits) - self._since < _PATIENCE

    def accepts(self, merit: float) -> bool:
        """Accept a step if the residual does not grow; always accept the first step of an increment."""
        return len(self.merits) == 1 or merit <= self.merits[-1]

    def may_converge(self, error: float) -> bool:
        """Return True if the next correction may still accept the step."""
        return error <= _ASTRAY

    def share(self, error: float, ahead: bool) -> float:
        """Return the relative residual of the linear solve at the last iterate, or at one that lies ``ahead``."""
        if self.far:
            return min(_FAR, self.bounds[1])
        before = self.errors if ahead else self.errors[:-1]
        share = _FIRST
        if before:
            share = _GAMMA * (min(error / before[-1], 1.0) if before[-1] > 0.0 else 1.0) ** _POWER
        return min(max(share, self.bounds[0]), self.bounds[1])
