/* simulate_windows.c: a model beside a recording, begun anew every so often; see talus/experimental/simulate.h. */
#include "talus/experimental/simulate.h"

/* the recorded torque between two instants: straight */
typedef struct recorded {
  const tl_windows *windows;
  size_t row;     /* at begin_s */
  double begin_s; /* of the step that is simulated now */
} recorded;

static void recorded_torque(const void *context, double t_s, const tl_motion *motion,
                            double torque[TL_MAX_JOINTS]) {
  const recorded *r = (const recorded *)context;
  double share = (t_s - r->begin_s) / r->windows->step_s;
  int j;

  (void)motion;
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    const double *x = r->windows->torque[j];
    torque[j] = x ? x[r->row] + share * (x[r->row + 1] - x[r->row]) : 0.0;
  }
}

/* from the recorded state at `first`; what the simulation is off by at each instant after it */
static tl_status window(const tl_windows *w, size_t first, size_t at) {
  double q[TL_MAX_JOINTS] = {0.0, 0.0}, v[TL_MAX_JOINTS] = {0.0, 0.0};
  int joints = tl_joint_count(w->model), j;
  recorded torque = {w, first, 0.0};
  tl_simulation s;
  tl_status status;
  size_t k;

  for (j = 0; j < joints; j++) {
    q[j] = w->q[j][first];
    v[j] = w->v[j][first];
  }
  status = tl_simulation_init(&s, w->model, q, v);
  s.effect = w->effect;
  s.effects = w->effects;
  s.effects_begin_s = -w->begin_s - (double)first * w->step_s;
  for (k = 1; k <= w->steps && status == TL_OK; k++) {
    torque.row = first + k - 1;
    torque.begin_s = (double)(k - 1) * w->step_s;
    status = tl_simulate(w->model, recorded_torque, &torque, w->longest_step_s, &s, (double)k * w->step_s);
    for (j = 0; j < joints; j++)
      w->deviation[((size_t)j * w->steps + k - 1) * w->count + at] = s.motion.q[j] - w->q[j][first + k];
  }
  return status;
}

tl_status tl_simulate_windows(const tl_windows *w) {
  tl_status status = TL_OK;
  size_t i;

  if (!w || !w->model || !(w->step_s > 0.0) || !(w->longest_step_s > 0.0)) return TL_ERR_ARGUMENT;
  for (i = 0; i < w->count && status == TL_OK; i++) status = window(w, w->first[i], i);
  return status;
}
