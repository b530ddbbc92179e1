/* kinematics.c: see talus/kinematics.h. */
#include "talus/kinematics.h"

#include <math.h>
#include <string.h>

#include "kinematics_stops.h"
#include "talus/transmission.h"

static tl_channel if_recorded(uint32_t recorded, tl_channel c) {
  return c != TL_NO_CHANNEL && (recorded & TL_CHANNEL_BIT(c)) ? c : TL_NO_CHANNEL;
}

/* a recorded torque is nearer to the joint than a current and is preferred */
static void layout_joint(tl_layout *layout, const tl_model *m, uint32_t recorded, int joint) {
  const tl_sensors *s = &tl_plant_facts(m->plant)->sensors;

  layout->position[joint] = if_recorded(recorded, s->position[joint]);
  layout->velocity[joint] = if_recorded(recorded, s->velocity[joint]);
  layout->effort[joint] = if_recorded(recorded, s->torque[joint]);
  layout->effort_scale[joint] = 1.0;
  if (layout->effort[joint] != TL_NO_CHANNEL) return;
  layout->effort[joint] = if_recorded(recorded, s->current[joint]);
  layout->effort_scale[joint] = tl_torque_per_current(m, joint, 0.0);
}

tl_status tl_layout_init(tl_layout *layout, const tl_model *m, uint32_t recorded) {
  tl_channel_set set;
  int j;

  if (!layout || !m || tl_channel_set_of(m->plant, &set) != TL_OK) return TL_ERR_ARGUMENT;
  if ((recorded & set.required) != set.required) return TL_ERR_UNSUPPORTED;
  for (j = 0; j < 2; j++)
    if (set.any_of[j] && !(recorded & set.any_of[j])) return TL_ERR_UNSUPPORTED;
  for (j = 0; j < TL_MAX_JOINTS; j++) {
    layout->position[j] = layout->velocity[j] = layout->effort[j] = TL_NO_CHANNEL;
    layout->effort_scale[j] = 1.0;
  }
  layout->load = if_recorded(recorded, tl_plant_facts(m->plant)->sensors.load);
  for (j = 0; j < tl_joint_count(m); j++) layout_joint(layout, m, recorded, j);
  return TL_OK;
}

/* ---- motion -------------------------------------------------------------- */

size_t tl_track_memory(int joints, size_t capacity) {
  return (size_t)joints * 5 * capacity;
}

void tl_track_init(tl_track *track, int joints, size_t capacity, double *memory, tl_stop *stops) {
  int j;

  memset(track, 0, sizeof *track);
  track->capacity = capacity;
  for (j = 0; j < joints; j++) {
    double *at = memory + (size_t)j * 5 * capacity;
    track->q[j] = at;
    track->v[j] = at + capacity;
    track->a[j] = at + 2 * capacity;
    track->slip[j] = at + 3 * capacity;
    track->speed[j] = at + 4 * capacity;
    track->stop[j] = stops + (size_t)j * capacity;
  }
}

/* what one joint's reconstruction needs */
typedef struct joint_work {
  const tl_transmission *transmission; /* NULL: the recorded angle is the joint's */
  const tl_sensing *sensing;
  const double *t_s, *x;
  size_t n;
  double *q, *v, *a, *quick;
  double *work;
  size_t work_n;
} joint_work;

/* rows [begin, end) between two stops */
static tl_status reconstruct_slip_phase(const joint_work *w, size_t begin, size_t end, int edges) {
  return tl_reconstruct_slip_phase(&w->sensing->window, w->t_s + begin, w->x + begin, end - begin, edges,
                                   w->q + begin, w->v + begin, w->a + begin, w->work, w->work_n);
}

/* every slip phase, the motion between two stops, by its own windows; inside a stop the quick window's
 * estimate stands (it was written before) */
static tl_status reconstruct_slip_phases(const joint_work *w, const tl_stop *stop, size_t stops) {
  size_t begin = 0, k;

  if (w->sensing->across) return reconstruct_slip_phase(w, 0, w->n, 0);
  for (k = 0; k <= stops; k++) {
    size_t end = k == stops ? w->n : stop[k].before == TL_NO_ROW ? begin : stop[k].before + 1;

    if (end > begin + 3) {
      int edges = tl_slip_phase_edges(k ? &stop[k - 1] : NULL, k < stops ? &stop[k] : NULL, w->t_s);
      tl_status status = reconstruct_slip_phase(w, begin, end, edges);
      if (status != TL_OK) return status;
    }
    if (k == stops || stop[k].after == TL_NO_ROW) break;
    begin = stop[k].after;
  }
  return TL_OK;
}

/* from the motor's motion to the joint's, in place */
static void to_joint(const joint_work *w) {
  size_t i;

  if (!w->transmission) return;
  for (i = 0; i < w->n; i++) {
    double motor[3] = {w->q[i], w->v[i], w->a[i]}, joint[3];
    tl_transmission_joint_motion(w->transmission, motor, joint);
    w->q[i] = joint[0];
    w->v[i] = joint[1];
    w->a[i] = joint[2];
  }
}

/* quick velocity of the joint at every row: speed[], and q, v, a to begin with */
static tl_status quick_motion(const joint_work *w) {
  tl_status status =
      tl_reconstruct(&w->sensing->quick, w->t_s, w->x, w->n, w->q, w->v, w->a, w->work, w->work_n);
  size_t i;

  if (status != TL_OK) return status;
  for (i = 0; i < w->n; i++) {
    double ratio = 1.0, slope;
    if (w->transmission)
      tl_transmission_ratio(w->transmission, tl_transmission_joint_angle(w->transmission, w->q[i]), &ratio,
                            &slope);
    w->quick[i] = w->v[i] / ratio;
  }
  return TL_OK;
}

/* a joint whose angle was recorded */
static tl_status position_motion(const joint_work *w, tl_track *track, int j) {
  tl_status status = quick_motion(w);

  if (status != TL_OK) return status;
  track->stops[j] = tl_find_stops(w->t_s, w->x, w->quick, w->n, w->sensing->standstill, track->stop[j]);
  status = reconstruct_slip_phases(w, track->stop[j], track->stops[j]);
  if (status == TL_OK) to_joint(w);
  return status;
}

/* a joint whose velocity alone was recorded: velocity is continuous through a stop, so
 * nothing is cut, and the angle stays unknown (0) */
static tl_status velocity_motion(const joint_work *w, tl_track *track, int j) {
  tl_status status =
      tl_reconstruct(&w->sensing->window, w->t_s, w->x, w->n, w->v, w->a, NULL, w->work, w->work_n);

  if (status != TL_OK) return status;
  memset(w->q, 0, w->n * sizeof *w->q);
  memcpy(w->quick, w->x, w->n * sizeof *w->quick);
  track->stops[j] = tl_find_stops(w->t_s, NULL, w->v, w->n, w->sensing->standstill, track->stop[j]);
  return TL_OK;
}

static const tl_transmission *motor_side(const tl_model *m, int joint) {
  return tl_plant_facts(m->plant)->sensors.at_motor ? &m->drive[joint].transmission : NULL;
}

size_t tl_kinematics_workspace(size_t capacity) {
  return tl_reconstruct_workspace(capacity);
}

tl_status tl_kinematics(const tl_model *m, const tl_layout *layout, const tl_sensing *sensing,
                        const tl_block *block, double *work, size_t work_n, tl_track *track) {
  int j;
  size_t i;

  if (!m || !layout || !sensing || !block || !work || !track) return TL_ERR_ARGUMENT;
  if (block->n < TL_SEGMENT_MIN_ROWS) return TL_ERR_TOO_SHORT;
  if (block->n > track->capacity) return TL_ERR_WORKSPACE;
  for (j = 0; j < tl_joint_count(m); j++) {
    int angle = layout->position[j] != TL_CHANNEL_COUNT;
    joint_work w = {motor_side(m, j), &sensing[j], block->t_s,      NULL, block->n, track->q[j],
                    track->v[j],      track->a[j], track->speed[j], work, work_n};
    tl_status status;

    w.x = block->channel[angle ? layout->position[j] : layout->velocity[j]];
    if (!w.x) return TL_ERR_ARGUMENT;
    status = angle ? position_motion(&w, track, j) : velocity_motion(&w, track, j);
    if (status != TL_OK) return status;
    tl_slip_through_stops(block->t_s, angle ? w.quick : w.v, block->n, track->stop[j], track->stops[j],
                          track->slip[j]);
    for (i = 0; i < block->n; i++) track->speed[j][i] = fabs(w.quick[i]);
  }
  return TL_OK;
}
