/* SPDX-License-Identifier: MIT
 *
 * Springs of a caisson as numbers in Props of SoilDyn, what is read from them, and the parts of the library.
 */
#ifndef PYSPRINGS_SOILDYN_H
#define PYSPRINGS_SOILDYN_H

#include <stdio.h>

#define NAME 45          /* characters of a file name */
#define PROPS 20000      /* numbers in Props */
#define LINE 512         /* characters of a line of the spring file */
#define MAGIC 20611.0    /* Props were filled by this library */
#define STATES 1200      /* numbers in StVar */
#define VERSION 7        /* of the spring file */
#define SLACK 1e-6       /* share by which a range may be exceeded (rounding) */
#define PI 3.14159265358979323846

/* Props: scalars at these places, then rays, the vertical curves, and elements with a memory (P_COUNT of them, or none). */
enum {
  P_MAGIC, P_VERSION, P_LENGTH, P_TORSION, P_REST_W, P_REST_V, P_OFFSET, P_VERTICAL, P_SETTLED, P_LOW, P_HIGH, P_STOP,
  P_RAYS, P_DOWN, P_UP, P_COUNT, P_LARGEST, P_RADIUS, P_TWIST, P_WAY, P_LIMIT, P_HEAVE, P_CARRIED, P_ELEMENTS, P_END, P_FIRST
};
/* A ray: angle, number of knots, 1 if its path failed; then COLUMNS numbers by knot: rho, and each value with its slope.
 * A vertical curve: number of knots, 1 if its path failed; then BRANCH numbers by knot: |w - w0|, V, slope. */
/* An element: kind, G (3), B (3), d, a, h, its direction (3; 0: both planes), and its factors of w and V (of the way, of the
 * stored part): see memory.c. */
enum { RAY_HEAD = 3, LOAD_H = 1, LOAD_M = 3, HEAVE = 5, LOAD_V = 7, COLUMNS = 9, BRANCH_HEAD = 2, BRANCH = 3 };
enum { TOWARDS = 10, SETTLING = 13, ELEMENT = 17, MOTIONS = 5 };
/* StVar: marks of the last state, the way and the motion of the elements, then their own numbers. */
enum { S_USED, S_USED_VERTICAL, S_WARNED, S_OFF_LOAD, S_OFF_PATH, S_WAY, S_MOTION, S_FIRST = S_MOTION + MOTIONS };

/* Forces on the soil; shares of the calibrated ranges; whether V is not covered by the lateral springs, and whether the motion
 * is between rays too far apart; what the springs have no answer for (NULL: nothing). */
typedef struct { double force[6], used, used_vertical, V, own_V; int off_load, off_path; const char *beyond; } Answer;

/* A spring file that is read: its name, the present line, and why it was refused. */
typedef struct { FILE *file; char name[NAME + 1], text[LINE]; int line; const char *why; } Reader;

const double *pysprings_ray(const double *P, int k);
int pysprings_states(const double *P);
void pysprings_elements(const double *P, double *state, const double *q, double *F, double *w, double *V);
double pysprings_rest(const double *P, double K[2][2]);
void pysprings_forces(const double *P, double *state, const double d[6], Answer *out);
void pysprings_stiffness(const double *P, const double *state, const double d[6], double *D);
int pysprings_read(Reader *r, double *P);

#endif
