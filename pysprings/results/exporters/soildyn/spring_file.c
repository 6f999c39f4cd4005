/* SPDX-License-Identifier: MIT
 *
 * The spring file: text, one row a line, comments behind `!`. Whatever is not as written by pysprings is refused.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "springs.h"

/* Next line that is neither blank nor a comment, without what exceeds LINE; NULL at the end. */
static char *next_line(Reader *r) {
  char *p;
  int rest;
  while (fgets(r->text, LINE, r->file)) {
    r->line++;
    if (!strchr(r->text, '\n'))
      while ((rest = fgetc(r->file)) != EOF && rest != '\n') ;
    for (p = r->text; *p == ' ' || *p == '\t'; p++) ;
    if (*p != '!' && *p != '\n' && *p != '\r' && *p != '\0') return p;
  }
  return NULL;
}

static int refuse(Reader *r, const char *why) {
  r->why = why;
  return 0;
}

/* Read n finite numbers from the text behind a word (blank word: from its start). */
static int numbers(Reader *r, const char *word, double *out, int n) {
  char *p = next_line(r), *end;
  size_t size = strlen(word);
  int k;
  if (!p) return refuse(r, "the file ends early");
  if (size && (strncmp(p, word, size) || (p[size] != ' ' && p[size] != '\t'))) return refuse(r, "another keyword was expected");
  for (p += size, k = 0; k < n; k++, p = end) {
    out[k] = strtod(p, &end);
    if (end == p) return refuse(r, "a number is missing or not readable");
    if (!(fabs(out[k]) <= 1e300)) return refuse(r, "a number is not finite");
  }
  for (; *p == ' ' || *p == '\t' || *p == '\r' || *p == '\n'; p++) ;
  return *p ? refuse(r, "there is more on the line than expected") : 1;
}

/* Read the knots of a curve behind its head; the first column starts at 0 and increases. */
static int knots(Reader *r, double *P, int *place, int count, int columns) {
  double *row = P + *place;
  int k;
  if (count < 2) return refuse(r, "a curve needs two points at least");
  if (*place + count * columns > PROPS) return refuse(r, "more numbers than SoilDyn keeps for a point (Props, 20,000)");
  for (k = 0; k < count; k++, row += columns) {
    if (!numbers(r, "", row, columns)) return 0;
    if (k == 0 ? row[0] != 0.0 : row[0] <= row[-columns]) return refuse(r, "displacements start at 0 and increase");
  }
  *place += count * columns;
  return 1;
}

static int count_of(double value) { return value >= 0.0 && value <= PROPS && value == floor(value) ? (int)value : -1; }

static int read_rays(Reader *r, double *P, int *place) {
  int k, n = count_of(P[P_RAYS]);
  if (n < 2) return refuse(r, "a fan has two rays at least");
  for (k = 0; k < n; k++) {
    double *ray = P + *place;
    if (*place + RAY_HEAD > PROPS) return refuse(r, "more numbers than SoilDyn keeps for a point (Props, 20,000)");
    if (!numbers(r, "ray", ray, RAY_HEAD)) return 0;
    if (k && ray[0] <= pysprings_ray(P, k - 1)[0]) return refuse(r, "angles of rays increase");
    if (ray[0] >= pysprings_ray(P, 0)[0] + PI) return refuse(r, "angles of rays cover less than half a turn");
    *place += RAY_HEAD;
    if (!knots(r, P, place, count_of(ray[1]), COLUMNS)) return 0;
  }
  return 1;
}

static int read_branch(Reader *r, const char *word, double *P, int *place, int which) {
  double head[BRANCH_HEAD];
  if (!numbers(r, word, head, BRANCH_HEAD)) return 0;
  P[which] = 0.0;
  if (head[0] == 0.0) return 1;
  if (*place + BRANCH_HEAD > PROPS) return refuse(r, "more numbers than SoilDyn keeps for a point (Props, 20,000)");
  P[which] = (double)*place;
  memcpy(P + *place, head, sizeof head);
  *place += BRANCH_HEAD;
  return knots(r, P, place, count_of(head[0]), BRANCH);
}

/* Read elements with a memory; none is allowed. */
static int read_elements(Reader *r, double *P, int *place) {
  double head[1];
  int k, n;
  if (!numbers(r, "elements", head, 1)) return 0;
  n = count_of(head[0]);
  if (n < 0) return refuse(r, "the number of elements is not a count");
  P[P_COUNT] = (double)n;
  P[P_ELEMENTS] = (double)*place;
  if (n == 0) return 1;
  if (!numbers(r, "memory", P + P_LARGEST, 7)) return 0;
  if (!(P[P_LARGEST] > 0.0)) return refuse(r, "the largest step is positive");
  for (k = P_RADIUS; k <= P_LIMIT; k++)
    if (!(P[k] >= 0.0)) return refuse(r, "radius, twist, way and the limit of ways are not negative");
  if (P[P_RADIUS] > 0.0 && P[P_TWIST] == 0.0) return refuse(r, "elements of torsion have a largest twist");
  if (*place + n * ELEMENT > PROPS) return refuse(r, "more numbers than SoilDyn keeps for a point (Props, 20,000)");
  for (k = 0; k < n; k++, *place += ELEMENT) {
    if (!numbers(r, "", P + *place, ELEMENT)) return 0;
    if (P[*place] != 0.0 && P[*place] != 1.0 && P[*place] != 2.0 && P[*place] != 3.0)
      return refuse(r, "the kind of an element is 0 (plastic), 1 (gap), 2 (reversible) or 3 (frictional)");
    if (!(P[*place + 7] > 0.0)) return refuse(r, "the size of an element is positive");
  }
  if (pysprings_states(P) > STATES) return refuse(r, "more numbers than SoilDyn keeps of a state (StVar, 1,200)");
  return 1;
}

/* Fill Props from an open spring file; 0, with the reason in the reader, where it is refused. */
int pysprings_read(Reader *r, double *P) {
  static const struct { const char *word; int at, n; } heads[] = {
    {"length_m", P_LENGTH, 1}, {"torsion_Nm", P_TORSION, 1}, {"rest_w_m_V_N", P_REST_W, 2}, {"offset_N", P_OFFSET, 1},
    {"vertical_stiffness_N_per_m", P_VERTICAL, 1}, {"settled_m", P_SETTLED, 1}, {"elastic_V_N", P_LOW, 2},
    {"stop_beyond_range", P_STOP, 1}, {"rays", P_RAYS, 1}};
  int place = P_FIRST;
  size_t k;
  char *p;
  if (!numbers(r, "pysprings_soildyn", P + P_VERSION, 1)) return 0;
  if (P[P_VERSION] != VERSION) return refuse(r, "this library reads version 7 of the spring file");
  for (k = 0; k < sizeof heads / sizeof heads[0]; k++)
    if (!numbers(r, heads[k].word, P + heads[k].at, heads[k].n)) return 0;
  if (!(P[P_LENGTH] > 0.0) || !(P[P_VERTICAL] > 0.0)) return refuse(r, "length and vertical stiffness are positive");
  if (!read_rays(r, P, &place)) return 0;
  if (!read_branch(r, "down", P, &place, P_DOWN) || !read_branch(r, "up", P, &place, P_UP)) return 0;
  if (!read_elements(r, P, &place)) return 0;
  p = next_line(r);
  if (!p || strncmp(p, "end", 3)) return refuse(r, "the file ends early, without its last line 'end'");
  P[P_END] = (double)place;
  P[P_MAGIC] = MAGIC;
  return 1;
}

