/* SPDX-License-Identifier: MIT
 *
 * A suction caisson for SoilDyn (OpenFAST, CalcOption 3): the macro-model of pysprings, a fan or springs with memory.
 *
 *   cc -O2 -shared -fPIC *.c -o libpysprings_soildyn.so -lm          Linux (proven)
 *   cc -O2 -dynamiclib *.c -o libpysprings_soildyn.dylib             macOS (not tried)
 *   cl /O2 /LD *.c /Fe:pysprings_soildyn.dll                         Windows (not tried)
 *
 * SoilDyn calls INTERFACEFOUNDATION with IDTask 1 (initialise: read the spring file PROPSFILE), 2 (force at a
 * displacement), 3 (force and stiffness at a displacement). The library has no variables: the springs are kept in Props
 * and the state in StVar, both of them arrays of the caller, a set for each point. A call goes on from the state that it is
 * given: a step that is rejected and repeated from the earlier state leaves no trace. Without elements with a memory in the
 * file the springs are nonlinear elastic.
 */
#include <math.h>
#include <string.h>

#include "springs.h"

#ifdef _WIN32
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

enum { INITIALISE = 1, FORCE = 2, STIFFNESS = 3 };
/* Above 6, the largest code of SoilDyn's own texts: OpenFAST stops, and the text of this library stands before. */
enum { NO_FILE = 101, BAD_FILE = 102, NO_STATE = 103, BEYOND = 104, BAD_TASK = 105, BAD_MOTION = 106 };
enum { WARNED_RANGE = 1, WARNED_WAY = 2, WARNED_LOAD = 4, WARNED_PATH = 8 };  /* in S_WARNED */

static void say(const char *kind, const char *name, int line, const char *text) {
  if (line) printf("\npysprings SoilDyn library: %s: %s, line %d: %s\n", kind, name, line, text);
  else printf("\npysprings SoilDyn library: %s: %s: %s\n", kind, name, text);
  fflush(stdout);
}

/* Fill Props from the spring file whose name has blanks behind it. Returns 0 or an error code. */
static int initialise(const char *props_file, double *P, double *state) {
  Reader r;
  int n = NAME;
  memset(&r, 0, sizeof r);
  memset(P, 0, PROPS * sizeof(double));
  memset(state, 0, STATES * sizeof(double));
  while (n > 0 && (props_file[n - 1] == ' ' || props_file[n - 1] == '\0')) n--;
  memcpy(r.name, props_file, (size_t)n);
  r.file = fopen(r.name, "r");
  if (!r.file) {
    say("fatal", r.name, 0, "the spring file cannot be opened (write it with: pysprings export RESULT --to openfast)");
    return NO_FILE;
  }
  n = pysprings_read(&r, P);
  fclose(r.file);
  if (n) return 0;
  P[P_MAGIC] = 0.0;
  say("fatal", r.name, r.line, r.why);
  return BAD_FILE;
}

/* Whether a warning is due; each comes once. */
static int is_new(double *state, int which) {
  int told = (int)state[S_WARNED];
  state[S_WARNED] = (double)(told | which);
  return !(told & which);
}

/* Force, and stiffness for IDTask 3, with marks in the state; returns 0 or an error code. */
static int evaluate(int task, const double *P, double *state, const double *d, double *force, double *D) {
  Answer answer;
  char text[160];
  int i;
  for (i = 0; i < 6; i++)
    if (!(fabs(d[i]) <= 1e30)) {
      say("fatal", "displacement", 0, "a component is not finite");
      return BAD_MOTION;
    }
  if (task == STIFFNESS) pysprings_stiffness(P, state, d, D);
  pysprings_forces(P, state, d, &answer);
  memcpy(force, answer.force, sizeof answer.force);
  state[S_USED] = answer.used;
  state[S_USED_VERTICAL] = answer.used_vertical;
  state[S_OFF_LOAD] = (double)answer.off_load;
  state[S_OFF_PATH] = (double)answer.off_path;
  if (answer.beyond) {
    say("fatal", "springs", 0, answer.beyond);
    return BEYOND;
  }
  if ((answer.used > 1.0 + SLACK || answer.used_vertical > 1.0 + SLACK) && is_new(state, WARNED_RANGE)) {
    sprintf(text, "beyond the calibrated range (%.3g laterally, %.3g vertically, limit 1): reactions are extrapolated",
            answer.used, answer.used_vertical);
    say("warning", "springs", 0, text);
  }
  if (P[P_WAY] > 0.0 && state[S_WAY] > P[P_WAY] * (1.0 + SLACK) && is_new(state, WARNED_WAY))
    say("warning", "springs", 0,
        "motions add up to more than the paths of the calibration: settlement is extrapolated from here on");
  if (answer.off_load && is_new(state, WARNED_LOAD)) {
    sprintf(text, "the vertical load, %.4g kN, is not that of the lateral springs, %.4g kN, or near its capacity: "
                  "H and M are those at theirs", 1e-3 * answer.V, 1e-3 * answer.own_V);
    say("warning", "springs", 0, text);
  }
  if (answer.off_path && is_new(state, WARNED_PATH))
    say("warning", "springs", 0,
        "the motion is between load paths more than 60 degrees apart in (u, rotation L): reactions there are not calibrated");
  return 0;
}

/* Entry of SoilDyn; all arguments by reference, arrays column-major, names of 45 characters. */
EXPORTED void INTERFACEFOUNDATION(const char *props_file, const char *ldisp_file, const int *task, int *errors, int *code,
                                  double *props, double *state, int *state_print, const double *displacement,
                                  double *force, double *D) {
  int failed;
  (void)ldisp_file;
  (void)state_print;
  if (*task == INITIALISE) failed = initialise(props_file, props, state);
  else if (*task != FORCE && *task != STIFFNESS) failed = BAD_TASK;
  else if (props[P_MAGIC] != MAGIC) failed = NO_STATE;
  else failed = evaluate(*task, props, state, displacement, force, D);
  if (failed == NO_STATE) say("fatal", "springs", 0, "Props hold no springs: the point was not initialised");
  if (failed == BAD_TASK) say("fatal", "IDTask", 0, "is not 1, 2 or 3");
  *errors = failed != 0;
  code[0] = failed;
}
