/* SPDX-License-Identifier: MIT
 *
 * Reactions of a caisson on a fan of load paths, in six degrees of freedom.
 *
 * Frame of SoilDyn: z up, forces on the soil. The springs have a rotation of each vertical plane, positive where the
 * caisson leans towards x (that about y), or towards y (less that about x). In a plane of motion the reactions are those of `pysprings.macro` (solver.fan_loads,
 * vertical.VerticalTable):
 *
 *   H, M = loads of the fan at (u, rotation);   V = vertical springs at w - w_lateral(u, rotation).
 *
 * Out of one plane, an assumption: let a = (u_x, u_y), b = L (rotations turned into the direction of motion) and
 * G = [a.a, a.b; a.b, b.b]. G has the eigenvalues s1^2 >= s2^2 and the direction phi in the plane (u, rotation L) of the
 * larger one; rho^2 = s1^2 + s2^2. The secant stiffness S(rho, phi), which gives the loads of the fan at (rho, phi) and
 * (rho, phi + 90 deg), is blended with its mean over phi by the share P = (s1^2 - s2^2)/rho^2:
 *
 *   (H, M/L) = (P S(rho, phi) + (1 - P) mean S(rho)) (a, b).
 *
 * P is 1 for a motion in one plane. The law is exact for linear springs and has no preferred direction.
 *
 * Elements with a memory, where the file has them, give H and M in place of the fan (memory.c), and the settlement or the
 * torsion where the file says so; the fan then gives the shares of its range.
 */
#include <math.h>
#include <string.h>

#include "springs.h"

#define ORIGIN 1e-12     /* m: nearer than this the caisson is at rest */
#define STRAIGHT 1e-3    /* rad: nearer than this to a ray its own range counts */
#define SLIGHT 0.01      /* share of the mean over directions below which it does not count for how far the springs are used */
#define WIDEST (PI / 3)  /* rad: rays farther apart do not cover what is between them, as pysprings.macro.fan */
#define MEAN 8           /* directions of the mean secant stiffness, over half a turn */
#define BISECTIONS 60
#define SAME 1e-3        /* share by which vertical loads differ that are one, as pysprings.core.loads */
#define CLOSE (0.1 * (1.0 + 1e-9)) /* and share up to which lateral springs of one hold for both */
#define LOST 0.2         /* share of lateral loads at equal motion that a V near its capacity may lose */
#define FLAT 1e-3        /* share of the initial stiffness below which the last step of a vertical curve carries no more */

typedef struct { const double *knots[4]; int count[4], failed[4]; double sign[4], weight[4], mean[4], t, gap; } Sector;
typedef struct { double H, M, w, V, used; int failed, off; } Loads;

/* --- curves --- */

/* Value of a cubic curve at x >= 0, last slope beyond the end; its columns are value and slope. */
static double curve(const double *knots, int count, int columns, int column, double x) {
  const double *low, *high;
  double h, s, step, d0, d1;
  int first = 0, last = count - 1, middle;
  high = knots + last * columns;
  if (x >= high[0]) return high[column] + high[column + 1] * (x - high[0]);
  while (last - first > 1) {
    middle = (first + last) / 2;
    if (x >= knots[middle * columns]) first = middle; else last = middle;
  }
  low = knots + first * columns;
  high = low + columns;
  h = high[0] - low[0];
  s = (x - low[0]) / h;
  step = (high[column] - low[column]) / h;
  d0 = low[column + 1];
  d1 = high[column + 1];
  return low[column] + h * s * (d0 + s * ((3.0 * step - 2.0 * d0 - d1) + s * (d0 + d1 - 2.0 * step)));
}

/* --- a fan of rays: see pysprings.macro.solver.fan_stencil --- */

const double *pysprings_ray(const double *P, int k) {
  const double *ray = P + P_FIRST;
  while (k-- > 0) ray += RAY_HEAD + COLUMNS * (int)ray[1];
  return ray;
}

/* Weights of the four rays around an angle, by the distances between them and the share t of the sector. */
static void weigh(Sector *s, const double at[4], double phi) {
  double d0 = at[1] - at[0], d = at[2] - at[1], d2 = at[3] - at[2], t = (phi - at[1]) / d;
  double left = d / (d0 + d) * d * t * (1.0 - t) * (1.0 - t), right = -d / (d + d2) * d * t * t * (1.0 - t);
  s->weight[0] = -left / sin(d0);
  s->weight[1] = sin(at[2] - phi) / sin(d) + left * (1.0 / tan(d0) + 1.0 / tan(d)) + right / sin(d);
  s->weight[2] = sin(phi - at[1]) / sin(d) - left / sin(d) - right * (1.0 / tan(d2) + 1.0 / tan(d));
  s->weight[3] = right / sin(d2);
  s->mean[0] = s->mean[3] = 0.0;
  s->mean[1] = 1.0 - t;
  s->mean[2] = t;
  s->t = t;
  s->gap = d;
}

static void sector(const double *P, double phi, Sector *s) {
  int n = (int)P[P_RAYS], low = 0, k, place, lap;
  double first = pysprings_ray(P, 0)[0], sign = 1.0, at[4];
  const double *ray;
  while (phi < first) { phi += PI; sign = -sign; }
  while (phi >= first + PI) { phi -= PI; sign = -sign; }
  while (low < n - 1 && phi >= pysprings_ray(P, low + 1)[0]) low++;
  for (k = 0; k < 4; k++) {
    place = low - 1 + k;
    lap = place < 0 ? -1 : place / n;
    if (place < 0) place += n;
    ray = pysprings_ray(P, place % n);
    at[k] = ray[0] + lap * PI;
    s->sign[k] = lap % 2 == 0 ? sign : -sign;
    s->count[k] = (int)ray[1];
    s->failed[k] = ray[2] != 0.0;
    s->knots[k] = ray + RAY_HEAD;
  }
  weigh(s, at, phi);
}

static double reach(const Sector *s, int k) { return s->knots[k][COLUMNS * (s->count[k] - 1)]; }

/* Share of the calibrated range, as pysprings.macro.fan.FanTable.support: on a ray its own, else the shorter one. */
static void support(const Sector *s, double rho, Loads *out) {
  double nearest = s->gap * (s->t < 0.5 ? s->t : 1.0 - s->t), range;
  int k, on_ray = nearest < STRAIGHT, own = s->t < 0.5 ? 1 : 2;
  range = reach(s, 1) < reach(s, 2) ? reach(s, 1) : reach(s, 2);
  if (on_ray) range = reach(s, own);
  out->used = rho / range;
  out->off = !on_ray && s->gap > WIDEST + SLACK;
  out->failed = 0;
  for (k = 1; k <= 2; k++)
    if (s->failed[k] && rho > reach(s, k) * (1.0 + SLACK) && (!on_ray || k == own)) out->failed = 1;
}

/* Loads of the fan at (rho, phi); H and M are divided by rho (slopes at the origin). */
static void fan(const double *P, double rho, double phi, Loads *out) {
  Sector s;
  int k;
  double odd, at_rest = rho > ORIGIN ? 0.0 : 1.0;
  memset(out, 0, sizeof *out);
  sector(P, phi, &s);
  for (k = 0; k < 4; k++) {
    odd = s.sign[k] * s.weight[k];
    if (at_rest) {
      out->H += odd * s.knots[k][LOAD_H + 1];
      out->M += odd * s.knots[k][LOAD_M + 1];
    } else {
      out->H += odd * curve(s.knots[k], s.count[k], COLUMNS, LOAD_H, rho) / rho;
      out->M += odd * curve(s.knots[k], s.count[k], COLUMNS, LOAD_M, rho) / rho;
    }
    if (s.mean[k] != 0.0) {
      out->w += s.mean[k] * curve(s.knots[k], s.count[k], COLUMNS, HEAVE, rho);
      out->V += s.mean[k] * curve(s.knots[k], s.count[k], COLUMNS, LOAD_V, rho);
    }
  }
  support(&s, rho, out);
}

/* --- lateral reactions in both directions --- */

/* Add a share of the secant stiffness S (H, M/L by u, rotation L) and of w, V at (rho, phi). */
static void add_secant(const double *P, double rho, double phi, double share, double S[2][2], Loads *sum) {
  Loads one;
  int k;
  double c, s, turned;
  for (k = 0; k < 2; k++) {
    turned = phi + 0.5 * PI * k;
    fan(P, rho, turned, &one);
    c = cos(turned);
    s = sin(turned);
    S[0][0] += share * one.H * c;
    S[0][1] += share * one.H * s;
    S[1][0] += share * one.M / P[P_LENGTH] * c;
    S[1][1] += share * one.M / P[P_LENGTH] * s;
    if (k == 0) {
      sum->w += share * one.w;
      sum->V += share * one.V;
      sum->failed |= one.failed;
      sum->off |= one.off;
      if (one.used > sum->used) sum->used = one.used;
    }
  }
}

/* Secant stiffness, w and V at motions a, b (2,) in m. Elements are used as far as the rays beside the larger motion, as in
 * pysprings.memory.space_model; a fan as far as any direction of the mean, where that counts. */
static void secant(const double *P, const double a[2], const double b[2], double S[2][2], Loads *sum) {
  double aa = a[0] * a[0] + a[1] * a[1], bb = b[0] * b[0] + b[1] * b[1], ab = a[0] * b[0] + a[1] * b[1];
  double rho = sqrt(aa + bb), plane = 0.0;
  Loads larger;
  int k;
  memset(S, 0, 4 * sizeof(double));
  memset(sum, 0, sizeof *sum);
  if (rho > ORIGIN) plane = sqrt((aa - bb) * (aa - bb) + 4.0 * ab * ab) / (rho * rho);
  if (1.0 - plane < 1e-12) plane = 1.0;
  if (rho > ORIGIN) add_secant(P, rho, 0.5 * atan2(2.0 * ab, aa - bb), plane, S, sum);
  larger = *sum;
  for (k = 0; k < MEAN && plane < 1.0; k++) add_secant(P, rho, PI * k / MEAN, (1.0 - plane) / MEAN, S, sum);
  sum->off = larger.off; /* the mean is over all directions */
  if (P[P_COUNT] > 0.0 || 1.0 - plane < SLIGHT) {
    sum->used = larger.used;
    sum->failed = larger.failed;
  }
}

/* --- vertical springs: see pysprings.macro.vertical --- */

static const double *branch(const double *P, double change) {
  int place = (int)P[change >= 0.0 ? P_DOWN : P_UP];
  return place ? P + place : NULL;
}

static int is_near(double a, double b, double share) {
  double most = share * (fabs(a) > fabs(b) ? fabs(a) : fabs(b));
  return fabs(a - b) <= (most > 1.0 ? most : 1.0);
}

/* Whether lateral springs at V own hold at V: close to it, and not near its capacity; as pysprings.macro.vertical.covered. */
static int is_covered(const double *P, double V, double own) {
  const double *b;
  double end, sign, at;
  int k;
  if (is_near(own, P[P_REST_V], SAME)) own = P[P_REST_V];
  b = branch(P, V - own);
  if (!is_near(V, own, CLOSE)) return 0;
  if (!b || is_near(V, own, SAME)) return 1;
  sign = V >= own ? 1.0 : -1.0;
  for (end = b[BRANCH_HEAD + 1], k = 1; k < (int)b[0]; k++) {
    at = b[BRANCH_HEAD + BRANCH * k + 1];
    if (sign * (at - end) > 0.0) end = at;
  }
  return !((V - end) / (own - end) < 1.0 - LOST);
}

/* V at a change of w from rest; beyond the end along the last step. */
static double vertical_load(const double *P, double change, double *used, int *failed) {
  const double *b = branch(P, change), *last;
  int n;
  double x = fabs(change);
  *failed = 0;
  *used = 0.0;
  if (!b) return P[P_REST_V] + P[P_VERTICAL] * change;
  n = (int)b[0];
  last = b + BRANCH_HEAD + BRANCH * (n - 1);
  *used = x / last[0];
  *failed = b[1] != 0.0 && *used > 1.0 + SLACK;
  if (x <= last[0]) return curve(b + BRANCH_HEAD, n, BRANCH, 1, x);
  return last[1] + (last[1] - last[1 - BRANCH]) / (last[0] - last[-BRANCH]) * (x - last[0]);
}

/* Change of w from rest under V: the first x that carries it; of a flat end, the end. */
static double vertical_change(const double *P, double V) {
  double change = V - P[P_REST_V], sign = change >= 0.0 ? 1.0 : -1.0, low, high, x, chord;
  const double *b = branch(P, change), *knots, *last;
  int n, k = 0, i;
  if (change == 0.0) return 0.0;
  if (!b) return change / P[P_VERTICAL];
  n = (int)b[0];
  knots = b + BRANCH_HEAD;
  last = knots + BRANCH * (n - 1);
  while (k < n && sign * (knots[BRANCH * k + 1] - V) < 0.0) k++;
  if (k == n) {
    chord = (last[1] - last[1 - BRANCH]) / (last[0] - last[-BRANCH]);
    return sign * (sign * chord < FLAT * fabs(knots[2]) ? last[0] : last[0] + (V - last[1]) / chord);
  }
  if (k == 0) return 0.0;
  low = knots[BRANCH * (k - 1)];
  high = knots[BRANCH * k];
  for (i = 0; i < BISECTIONS; i++) {
    x = 0.5 * (low + high);
    if (sign * (curve(knots, n, BRANCH, 1, x) - V) >= 0.0) high = x; else low = x;
  }
  return sign * 0.5 * (low + high);
}

/* --- six degrees of freedom --- */

/* V at w under lateral springs that settle by lateral->w and carry lateral->V; names what the springs do not support. */
static double vertical(const double *P, double w, const Loads *lateral, Answer *out) {
  int failed = 0, elastic = 1;
  double V, change;
  if (P[P_DOWN] == 0.0 && P[P_UP] == 0.0) {
    V = lateral->V + P[P_VERTICAL] * (w - lateral->w);
  } else {
    change = w - lateral->w - P[P_SETTLED] + vertical_change(P, lateral->V);
    V = vertical_load(P, change, &out->used_vertical, &failed);
    elastic = !branch(P, change);
  }
  out->V = V;
  out->own_V = lateral->V;
  out->off_load = !is_covered(P, V, lateral->V);
  if (failed) out->beyond = "the vertical path of the full model stopped before this displacement";
  if (elastic && (V < P[P_LOW] - SLACK * fabs(P[P_LOW]) || V > P[P_HIGH] + SLACK * fabs(P[P_HIGH])))
    out->beyond = "without vertical springs in this direction the vertical load is not known here";
  return V;
}

/* Forces on the soil in the frame of SoilDyn at a displacement in it; elements with a memory go on from the state. */
void pysprings_forces(const double *P, double *state, const double d[6], Answer *out) {
  double L = P[P_LENGTH], a[2], b[2], S[2][2], Ha[2], Mb[2], q[MOTIONS], F[MOTIONS], w = P[P_REST_W] - d[2], twist = P[P_RADIUS] * d[5];
  Loads lateral;
  int i;
  memset(out, 0, sizeof *out);
  a[0] = d[0];
  a[1] = d[1];
  b[0] = L * d[4];
  b[1] = -L * d[3];
  secant(P, a, b, S, &lateral);
  for (i = 0; i < 2; i++) {
    Ha[i] = S[0][0] * a[i] + S[0][1] * b[i];
    Mb[i] = L * (S[1][0] * a[i] + S[1][1] * b[i]);
    q[2 * i] = a[i];
    q[2 * i + 1] = b[i];
  }
  q[4] = twist;
  F[4] = 0.0;
  if (P[P_COUNT] > 0.0) {
    pysprings_elements(P, state, q, F, &lateral.w, &lateral.V);
    for (i = 0; i < 2; i++) {
      Ha[i] = F[2 * i];
      Mb[i] = L * F[2 * i + 1];
    }
  }
  out->used = lateral.used;
  if (fabs(twist) > out->used * P[P_TWIST]) out->used = fabs(twist) / P[P_TWIST];
  if (lateral.failed) out->beyond = "a load path of the full model stopped, or met a limit load, before this displacement";
  out->force[0] = Ha[0];
  out->force[1] = Ha[1];
  out->force[2] = P[P_OFFSET] - vertical(P, w, &lateral, out);
  out->off_path = lateral.off;
  if (a[0] == 0.0 && a[1] == 0.0 && b[0] == 0.0 && b[1] == 0.0) out->off_load = out->off_path = 0;
  out->force[3] = -Mb[1];
  out->force[4] = Mb[0];
  out->force[5] = P[P_TORSION] * d[5] + P[P_RADIUS] * F[4];
  if (P[P_STOP] != 0.0 && (out->used > 1.0 + SLACK || out->used_vertical > 1.0 + SLACK))
    out->beyond = "the displacement is beyond the calibrated range of the springs";
}

/* Forces from a state that stays as it is. */
static void tried(const double *P, const double *state, const double d[6], Answer *out) {
  double copy[STATES];
  memcpy(copy, state, sizeof copy);
  pysprings_forces(P, copy, d, out);
}

/* Whether elements have not moved yet. */
static int is_at_rest(const double *state) {
  int k;
  for (k = S_WAY; k < STATES; k++)
    if (state[k] != 0.0) return 0;
  return 1;
}

/* Stiffness (6, 6), column-major: at rest that of the springs there, elsewhere differences of the forces. */
void pysprings_stiffness(const double *P, const double *state, const double d[6], double *D) {
  double zero[2] = {0.0, 0.0}, S[2][2], x[6], size, step, L = P[P_LENGTH], R = P[P_RADIUS];
  Loads lateral;
  Answer more, less;
  int i, j;
  memset(D, 0, 36 * sizeof(double));
  size = sqrt(d[0] * d[0] + d[1] * d[1] + L * L * (d[3] * d[3] + d[4] * d[4]) + R * R * d[5] * d[5]);
  if (size <= ORIGIN && fabs(d[2]) <= ORIGIN && is_at_rest(state)) {
    D[35] = P[P_TORSION];
    if (P[P_COUNT] > 0.0) D[35] += R * R * pysprings_rest(P, S);
    else secant(P, zero, zero, S, &lateral);
    D[0] = D[7] = S[0][0];
    D[21] = D[28] = L * L * S[1][1];
    D[24] = L * S[0][1];
    D[19] = -L * S[0][1];
    D[4] = L * S[1][0];
    D[9] = -L * S[1][0];
    D[14] = P[P_VERTICAL];
    return;
  }
  step = 1e-5 * (size > 1e-4 ? size : 1e-4);
  for (j = 0; j < 6; j++) {
    memcpy(x, d, sizeof x);
    x[j] = d[j] + (j < 3 ? step : step / L);
    tried(P, state, x, &more);
    x[j] = d[j] - (j < 3 ? step : step / L);
    tried(P, state, x, &less);
    for (i = 0; i < 6; i++) D[i + 6 * j] = (more.force[i] - less.force[i]) / (2.0 * (j < 3 ? step : step / L));
  }
}

