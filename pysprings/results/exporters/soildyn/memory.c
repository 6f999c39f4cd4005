/* SPDX-License-Identifier: MIT
 *
 * Elements with a memory, as `pysprings.memory.elements`, for motions in two planes at right angles and a twist.
 *
 * A motion q = (u_x, rotation_x L, u_y, rotation_y L, twist R) [m] gives the loads F = (H_x, M_x/L, H_y, M_y/L, T/R) [N].
 *
 * An element with a direction (px, py, pz) takes the motion of one plane, a = px (q1, q2) + py (q3, q4) + pz (q5, 0), and
 * gives its force back the same way. One without takes both planes, but no twist:
 *
 * A plastic element keeps an elastic motion e, of one plane or of both, and its way p:
 *
 *   f = B e in each plane,   gauge^2 = e_x.G e_x + e_y.G e_y <= r(p)^2,   r(p) = d (1 + a p/(p + h)),
 *
 * with a radial return. In a plane of any direction this is the element of the macro-model; turned motions give turned
 * loads, and no closed way gives work. A gap element of both planes is one plate for each: it is that of the macro-model
 * in both planes, and too strong between them (up to the root of 2; the spring file states the error of the whole).
 *
 * A frictional element is a plate whose walls do not press at rest, with friction along t = (g11, g12), of g22 times what both
 * walls are pressed: one for each plane, too.
 *
 * A reversible element keeps nothing: f = B e with e = q min(1, d/gauge of q), of both planes together.
 *
 * Where the file has w and V of the elements, these follow the ways p and what they store, as sums of p/(1 + p/(s d)) and
 * gauge^2/d.
 */
#include <math.h>
#include <string.h>

#include "springs.h"

#define SHORTEST 1e-4    /* share of a step below which it is not halved again */
enum { PLASTIC, GAP, REVERSIBLE, FRICTIONAL };

static int is_plate(const double *row) { return row[0] == GAP || row[0] == FRICTIONAL; }

/* Motions that an element takes: those of one plane, or of both. */
static int motions_of(const double *row) {
  const double *p = row + TOWARDS;
  return p[0] != 0.0 || p[1] != 0.0 || p[2] != 0.0 ? 2 : 4;
}

/* Numbers that an element keeps. */
static int size_of(const double *row) {
  int m = motions_of(row);
  return row[0] == PLASTIC ? m + 1 : row[0] == REVERSIBLE ? 0 : 3 * (m / 2);
}

/* Numbers of StVar that the elements need. */
int pysprings_states(const double *P) {
  const double *row = P + (int)P[P_ELEMENTS];
  int k, n = S_FIRST;
  for (k = 0; k < (int)P[P_COUNT]; k++, row += ELEMENT) n += size_of(row);
  return n;
}

/* Stiffness at rest of one plane (u, rotation L), returned that of torsion (twist R): both walls of a plate where they press on it
 * and do not yield, else one; without friction. */
double pysprings_rest(const double *P, double K[2][2]) {
  const double *row = P + (int)P[P_ELEMENTS];
  double torsion = 0.0;
  int k;
  memset(K, 0, 4 * sizeof(double));
  for (k = 0; k < (int)P[P_COUNT]; k++, row += ELEMENT) {
    double share = motions_of(row) == 4 ? 1.0 : row[TOWARDS] * row[TOWARDS];
    double walls = row[0] == GAP && row[1] > 0.0 && row[1] < row[7] ? 2.0 * row[6] : row[6];
    double K00 = is_plate(row) ? walls * row[4] * row[4] : row[4];
    K[0][0] += share * K00;
    K[0][1] += share * (is_plate(row) ? walls * row[4] * row[5] : row[5]);
    K[1][1] += share * (is_plate(row) ? walls * row[5] * row[5] : row[6]);
    torsion += row[TOWARDS + 2] * row[TOWARDS + 2] * K00;
  }
  K[1][0] = K[0][1];
  return torsion;
}

/* Square of the gauge of e (m). */
static double square(const double *row, int m, const double *e) {
  double found = 0.0;
  int k;
  for (k = 0; k < m; k += 2)
    found += e[k] * (row[1] * e[k] + row[2] * e[k + 1]) + e[k + 1] * (row[2] * e[k] + row[3] * e[k + 1]);
  return found;
}

/* Write the force of an elastic motion e (m). */
static void carry(const double *row, int m, const double *e, double *f) {
  int k;
  for (k = 0; k < m; k += 2) {
    f[k] = row[4] * e[k] + row[5] * e[k + 1];
    f[k + 1] = row[5] * e[k] + row[6] * e[k + 1];
  }
}

/* Write the force of a reversible element at x (m); return the square of the gauge of e. */
static double reversible(const double *row, int m, const double *x, double *f) {
  double e[4], gauge = sqrt(square(row, m, x)), share = gauge > row[7] ? row[7] / gauge : 1.0;
  int k;
  for (k = 0; k < m; k++) e[k] = share * x[k];
  carry(row, m, e, f);
  return share * share * gauge * gauge;
}

/* Advance a plastic element by dx (m); write its force, return the square of its gauge. */
static double plastic(const double *row, int m, double *s, const double *dx, double *f) {
  double a = row[8], h = row[9], d = row[7], gauge, radius, over, c, p = s[m], share = 1.0;
  int k;
  for (k = 0; k < m; k++) s[k] += dx[k];
  gauge = sqrt(square(row, m, s));
  radius = a != 0.0 ? d * (1.0 + a * p / (p + h)) : d;
  if (gauge > radius) {
    if (a != 0.0) {
      over = gauge + p - d;
      c = over - h - a * d;
      s[m] = 0.5 * (c + sqrt(c * c + 4.0 * over * h));
      share = (gauge + p - s[m]) / gauge;
    } else {
      s[m] = p + gauge - d;
      share = d / gauge;
    }
  }
  for (k = 0; k < m; k++) s[k] *= share;
  carry(row, m, s, f);
  return square(row, m, s);
}

/* Press the plate against a wall that has come the way `s` by `x`; return the force. */
static double wall(double d, double *s, double *way, double x, double sign) {
  double over = x - d;
  if (x <= 0.0) return 0.0;
  if (over <= 0.0) return x;
  *s += sign * over;
  *way += over;
  return d;
}

/* Advance the plate of one plane, on which both walls press at rest, to x; return its force. */
static double plate(double pressed, double d, double *s, double x) {
  double ahead = wall(d, s, s + 2, x + pressed - s[0], 1.0);
  return ahead - wall(d, s + 1, s + 2, s[1] + pressed - x, -1.0);
}

/* Advance the plate of one plane, which friction holds, by dx to x; write its elastic motion (2). */
static void friction(const double *row, double *s, const double *x, const double *dx, double *e) {
  double way = 0.0, at = row[4] * x[0] + row[5] * x[1];
  double ahead = wall(row[7], s, &way, at - s[0], 1.0), behind = wall(row[7], s + 1, &way, s[1] - at, -1.0);
  double most = row[3] * (ahead + behind), n = ahead - behind;
  s[2] = fmin(most, fmax(-most, s[2] + row[1] * dx[0] + row[2] * dx[1]));
  e[0] = row[4] * n + row[1] * s[2];
  e[1] = row[5] * n + row[2] * s[2];
}

/* Advance the plates of each plane by dx to x (m); write their force, return the square of their elastic motion, add their way. */
static double plates(const double *row, int m, double *s, const double *x, const double *dx, double *f, double *p) {
  double e[2], n, stored = 0.0;
  int k;
  for (k = 0; k < m; k += 2, s += 3) {
    if (row[0] == FRICTIONAL) {
      friction(row, s, x + k, dx + k, e);
    } else {
      n = plate(row[1], row[7], s, row[4] * x[k] + row[5] * x[k + 1]);
      e[0] = row[4] * n;
      e[1] = row[5] * n;
    }
    *p += row[0] == FRICTIONAL ? s[0] - s[1] : s[2];
    f[k] = row[6] * e[0];
    f[k + 1] = row[6] * e[1];
    stored += e[0] * e[0] + e[1] * e[1];
  }
  return stored;
}

/* Motion (m) that an element takes of q (5). */
static void taken(const double *row, int m, const double *q, double *x) {
  const double *p = row + TOWARDS;
  if (m == 4) {
    memcpy(x, q, 4 * sizeof(double));
    return;
  }
  x[0] = p[0] * q[0] + p[1] * q[2] + p[2] * q[4];
  x[1] = p[0] * q[1] + p[1] * q[3];
}

/* Add the force (m) of an element to the loads (5). */
static void given(const double *row, int m, const double *f, double *F) {
  const double *p = row + TOWARDS;
  int k;
  for (k = 0; k < 4; k++) F[k] += m == 4 ? f[k] : p[k / 2] * f[k % 2];
  F[4] += p[2] * f[0];
}

/* Advance all elements by dq to q; write loads, and the sums of their ways and of what they store for w and V. */
static void step(const double *P, double *s, const double *q, const double *dq, double *F, double even[2]) {
  const double *row = P + (int)P[P_ELEMENTS], *factor;
  double x[4], dx[4], f[4], p, stored;
  int k, m;
  memset(F, 0, MOTIONS * sizeof(double));
  even[0] = even[1] = 0.0;
  for (k = 0; k < (int)P[P_COUNT]; k++, row += ELEMENT) {
    m = motions_of(row);
    taken(row, m, q, x);
    taken(row, m, dq, dx);
    p = 0.0;
    if (row[0] == PLASTIC) {
      stored = plastic(row, m, s, dx, f);
      p = s[m];
    } else {
      stored = row[0] == REVERSIBLE ? reversible(row, m, x, f) : plates(row, m, s, x, dx, f, &p);
    }
    given(row, m, f, F);
    s += size_of(row);
    p /= 1.0 + p * P[P_LIMIT] / row[7];
    stored /= row[7];
    factor = row + SETTLING;
    even[0] += factor[0] * p + factor[2] * stored;
    even[1] += factor[1] * p + factor[3] * stored;
  }
}

/* Go from the motion of the state to q; steps are halved until they are short enough, as `elements.follow` does. w and V stay
 * as they are where they are not those of the elements. */
void pysprings_elements(const double *P, double *state, const double *q, double *F, double *w, double *V) {
  double from[MOTIONS], dq[MOTIONS], at[MOTIONS], even[2], length = 0.0, lateral = 0.0;
  int k, j, parts = 1;
  memcpy(from, state + S_MOTION, sizeof from);
  for (k = 0; k < MOTIONS; k++) {
    length += (q[k] - from[k]) * (q[k] - from[k]);
    if (k == MOTIONS - 2) lateral = sqrt(length); /* a twist, the last one, leaves w as it is */
  }
  length = sqrt(length);
  while (length > P[P_LARGEST] * parts && parts * SHORTEST < 1.0) parts *= 2;
  for (k = 0; k < MOTIONS; k++) dq[k] = (q[k] - from[k]) / parts;
  for (j = 1; j <= parts; j++) {
    for (k = 0; k < MOTIONS; k++) at[k] = j == parts ? q[k] : from[k] + j * dq[k];
    step(P, state + S_FIRST, at, dq, F, even);
  }
  memcpy(state + S_MOTION, q, sizeof from);
  state[S_WAY] += lateral;
  if (P[P_WAY] == 0.0) return;
  *w = P[P_HEAVE] + even[0];
  *V = P[P_CARRIED] + even[1];
}
