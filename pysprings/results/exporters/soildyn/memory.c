/* SPDX-License-Identifier: MIT
 *
 * Elements with a memory, as `pysprings.memory.elements`, for motions in two planes at right angles.
 *
 * A motion q = (u_x, rotation_x L, u_y, rotation_y L) [m] gives the loads F = (H_x, M_x/L, H_y, M_y/L) [N].
 *
 * A plastic element keeps an elastic motion e in both planes, and its way p:
 *
 *   f = B e in each plane,   gauge^2 = e_x.G e_x + e_y.G e_y <= r(p)^2,   r(p) = d (1 + a p/(p + h)),
 *
 * with a radial return. In a plane of any direction this is the element of the macro-model; turned motions give turned
 * loads, and no closed way gives work. A gap element is one plate for each plane: it is that of the macro-model in both
 * planes, and too strong between them (up to the root of 2; the spring file states the error of the whole).
 *
 * A frictional element is a plate whose walls do not press at rest, with friction along t = (g11, g12), of g22 times what both
 * walls are pressed: one for each plane, too.
 *
 * A reversible element keeps nothing: f = B e with e = q min(1, d/gauge of q), of both planes together.
 *
 * w and V follow the ways p of the elements and what they store, as sums of p/(1 + p/(s d)) and gauge^2/d.
 */
#include <math.h>
#include <string.h>

#include "springs.h"

#define SHORTEST 1e-4    /* share of a step below which it is not halved again */
enum { PLASTIC = 5, PLATES = 6 };   /* numbers that an element keeps */

static int size_of(const double *row) { return row[0] == 0.0 ? PLASTIC : row[0] == 2.0 ? 0 : PLATES; }

/* Numbers of StVar that the elements need. */
int pysprings_states(const double *P) {
  const double *row = P + (int)P[P_ELEMENTS];
  int k, n = S_FIRST;
  for (k = 0; k < (int)P[P_COUNT]; k++, row += ELEMENT) n += size_of(row);
  return n;
}

/* Stiffness at rest (u, rotation L): both walls of a plate where they press on it and do not yield, else one; without friction. */
void pysprings_rest(const double *P, double K[2][2]) {
  const double *row = P + (int)P[P_ELEMENTS];
  int k;
  memset(K, 0, 4 * sizeof(double));
  for (k = 0; k < (int)P[P_COUNT]; k++, row += ELEMENT) {
    int plate = row[0] == 1.0 || row[0] == 3.0;
    double walls = row[0] == 1.0 && row[1] > 0.0 && row[1] < row[7] ? 2.0 * row[6] : row[6];
    K[0][0] += plate ? walls * row[4] * row[4] : row[4];
    K[0][1] += plate ? walls * row[4] * row[5] : row[5];
    K[1][1] += plate ? walls * row[5] * row[5] : row[6];
  }
  K[1][0] = K[0][1];
}

/* Square of the gauge of e (4). */
static double square(const double *row, const double *e) {
  double found = 0.0;
  int k;
  for (k = 0; k < 4; k += 2)
    found += e[k] * (row[1] * e[k] + row[2] * e[k + 1]) + e[k + 1] * (row[2] * e[k] + row[3] * e[k + 1]);
  return found;
}

/* Add the loads of an elastic motion e (4). */
static void carry(const double *row, const double *e, double F[4]) {
  int k;
  for (k = 0; k < 4; k += 2) {
    F[k] += row[4] * e[k] + row[5] * e[k + 1];
    F[k + 1] += row[5] * e[k] + row[6] * e[k + 1];
  }
}

/* Add the loads of a reversible element at q; return the square of the gauge of e. */
static double reversible(const double *row, const double q[4], double F[4]) {
  double e[4], gauge = sqrt(square(row, q)), share = gauge > row[7] ? row[7] / gauge : 1.0;
  int k;
  for (k = 0; k < 4; k++) e[k] = share * q[k];
  carry(row, e, F);
  return share * share * gauge * gauge;
}

/* Advance a plastic element by dq; add its loads. */
static void plastic(const double *row, double *s, const double dq[4], double F[4]) {
  double a = row[8], h = row[9], d = row[7], gauge, radius, over, c, p = s[4], share = 1.0;
  int k;
  for (k = 0; k < 4; k++) s[k] += dq[k];
  gauge = sqrt(square(row, s));
  radius = a != 0.0 ? d * (1.0 + a * p / (p + h)) : d;
  if (gauge > radius) {
    if (a != 0.0) {
      over = gauge + p - d;
      c = over - h - a * d;
      s[4] = 0.5 * (c + sqrt(c * c + 4.0 * over * h));
      share = (gauge + p - s[4]) / gauge;
    } else {
      s[4] = p + gauge - d;
      share = d / gauge;
    }
  }
  for (k = 0; k < 4; k++) s[k] *= share;
  carry(row, s, F);
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

/* Advance the plate of one plane, which friction holds, by dq to q; add its loads, return the square of its elastic motion. */
static double friction(const double *row, double *s, const double q[2], const double dq[2], double F[2]) {
  double way = 0.0, x = row[4] * q[0] + row[5] * q[1];
  double ahead = wall(row[7], s, &way, x - s[0], 1.0), behind = wall(row[7], s + 1, &way, s[1] - x, -1.0);
  double most = row[3] * (ahead + behind), n = ahead - behind, e[2];
  s[2] = fmin(most, fmax(-most, s[2] + row[1] * dq[0] + row[2] * dq[1]));
  e[0] = row[4] * n + row[1] * s[2];
  e[1] = row[5] * n + row[2] * s[2];
  F[0] += row[6] * e[0];
  F[1] += row[6] * e[1];
  return e[0] * e[0] + e[1] * e[1];
}

/* Advance all elements by dq to q; write loads, and the sums of their ways and of what they store for w and V. */
static void step(const double *P, double *s, const double q[4], const double dq[4], double F[4], double even[2]) {
  const double *row = P + (int)P[P_ELEMENTS];
  double p, e, stored;
  int k, j;
  memset(F, 0, 4 * sizeof(double));
  even[0] = even[1] = 0.0;
  for (k = 0; k < (int)P[P_COUNT]; k++, row += ELEMENT) {
    if (row[0] == 0.0) {
      plastic(row, s, dq, F);
      p = s[4];
      stored = square(row, s);
    } else if (row[0] == 2.0) {
      p = 0.0;
      stored = reversible(row, q, F);
    } else if (row[0] == 3.0) {
      stored = friction(row, s, q, dq, F) + friction(row, s + 3, q + 2, dq + 2, F + 2);
      p = s[0] - s[1] + s[3] - s[4];
    } else {
      for (j = 0, stored = 0.0; j < 4; j += 2) {
        e = plate(row[1], row[7], s + 3 * (j / 2), row[4] * q[j] + row[5] * q[j + 1]);
        F[j] += row[4] * row[6] * e;
        F[j + 1] += row[5] * row[6] * e;
        stored += e * e;
      }
      p = s[2] + s[5];
    }
    s += size_of(row);
    p /= 1.0 + p * P[P_LIMIT] / row[7];
    stored /= row[7];
    even[0] += row[10] * p + row[12] * stored;
    even[1] += row[11] * p + row[13] * stored;
  }
}

/* Go from the motion of the state to q; steps are halved until they are short enough, as `elements.follow` does. */
void pysprings_elements(const double *P, double *state, const double q[4], double F[4], double *w, double *V) {
  double from[4], dq[4], at[4], even[2], length = 0.0;
  int k, j, parts = 1;
  memcpy(from, state + S_MOTION, sizeof from);
  for (k = 0; k < 4; k++) length += (q[k] - from[k]) * (q[k] - from[k]);
  length = sqrt(length);
  while (length > P[P_LARGEST] * parts && parts * SHORTEST < 1.0) parts *= 2;
  for (k = 0; k < 4; k++) dq[k] = (q[k] - from[k]) / parts;
  for (j = 1; j <= parts; j++) {
    for (k = 0; k < 4; k++) at[k] = j == parts ? q[k] : from[k] + j * dq[k];
    step(P, state + S_FIRST, at, dq, F, even);
  }
  memcpy(state + S_MOTION, q, sizeof from);
  state[S_WAY] += length;
  *w = P[P_HEAVE] + even[0];
  *V = P[P_CARRIED] + even[1];
}
