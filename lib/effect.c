/* effect.c: the table of effects and what all of them share; see talus/experimental/effect.h. */
#include "talus/experimental/effect.h"

#include <math.h>
#include <string.h>

#include "effect_columns.h"
#include "talus/math.h"
#include "talus/transmission.h"

/* The kinds by their order: effect_table.h is made from the folder lib/effects/ (Makefile), a line a file. */
#define TL_EFFECT_KIND(name) extern const tl_effect_kind tl_effect_##name;
#include "effect_table.h"
#undef TL_EFFECT_KIND

static const tl_effect_kind *const table[] = {
#define TL_EFFECT_KIND(name) &tl_effect_##name,
#include "effect_table.h"
};

const tl_effect_kind *const *tl_effect_table(int *n) {
  *n = (int)(sizeof table / sizeof table[0]);
  return table;
}

static int same_text(const char *a, const char *b) {
  while (*a && *a == *b) {
    a++;
    b++;
  }
  return *a == *b;
}

const tl_effect_kind *tl_effect_find(const char *name) {
  size_t i;

  for (i = 0; i < sizeof table / sizeof table[0]; i++)
    if (same_text(table[i]->name, name)) return table[i];
  return NULL;
}

int tl_effect_applies(const tl_effect_kind *kind, const tl_model *m, int joint) {
  if (!kind || !m || joint < 0 || joint > TL_MAX_JOINTS) return 0;
  return (kind->places & tl_plant_facts(m->plant)->place[joint]) != 0;
}

tl_effect tl_effect_typical(const tl_effect_kind *kind, int joint) {
  tl_effect e;
  int i;

  memset(&e, 0, sizeof e);
  e.kind = kind;
  e.joint = joint;
  for (i = 0; i < kind->strengths + kind->shapes; i++) e.value[i] = kind->parameter[i].typical;
  return e;
}

int tl_effect_says(const tl_effect *e, int parameter) {
  const tl_effect_parameter *p = &e->kind->parameter[parameter];

  return !(p->flags & TL_PARAMETER_OPTIONAL) || e->value[parameter] != p->default_value;
}

int tl_effect_fit_only(const tl_effect *e) {
  int i;

  for (i = 0; i < e->kind->strengths + e->kind->shapes; i++)
    if ((e->kind->parameter[i].flags & TL_PARAMETER_FIT_ONLY) && tl_effect_says(e, i)) return i;
  return -1;
}

int tl_effect_needs_temperature(const tl_effect *e) {
  int i;

  for (i = 0; i < e->kind->strengths; i++)
    if ((e->kind->parameter[i].flags & TL_PARAMETER_NEEDS_TEMPERATURE) && e->value[i] != 0.0) return 1;
  return 0;
}

tl_status tl_effect_check(const tl_effect *e, const tl_model *m) {
  tl_effect_change change;
  tl_transmission changed;
  int i;

  if (!e || !m || !e->kind) return TL_ERR_ARGUMENT;
  if (!tl_effect_applies(e->kind, m, e->joint)) return TL_ERR_UNSUPPORTED;
  for (i = 0; i < e->kind->strengths + e->kind->shapes; i++)
    if (!(e->value[i] >= e->kind->parameter[i].low && e->value[i] <= e->kind->parameter[i].high))
      return TL_ERR_RANGE;
  if (!e->kind->change || e->joint == TL_MAX_JOINTS) return TL_OK;
  change = tl_effects_change(e, 1, e->joint);
  return tl_effect_change_linkage(&change, &m->drive[e->joint].transmission, &changed);
}

int tl_effect_repeats(const tl_effect *effect, int k) {
  int i;

  for (i = 0; i < k && effect[k].kind->once; i++)
    if (effect[i].kind == effect[k].kind && effect[i].joint == effect[k].joint) return 1;
  return 0;
}

tl_status tl_effects_check(const tl_effect *effect, int n, const tl_model *m) {
  int i;

  if (n < 0 || (n > 0 && !effect)) return TL_ERR_ARGUMENT;
  for (i = 0; i < n; i++) {
    tl_status status = tl_effect_check(&effect[i], m);
    if (status != TL_OK) return status;
    if (tl_effect_repeats(effect, i)) return TL_ERR_UNSUPPORTED;
  }
  return TL_OK;
}

double tl_effect_tilt_of(const tl_model *m, const tl_motion *motion, int joint) {
  double joint_torque[TL_MAX_JOINTS];

  tl_gravity_tilt(m, motion->q, joint_torque);
  return joint_torque[joint];
}

void tl_effect_place_of(const tl_model *m, const tl_motion *motion, int joint, double t_s,
                        tl_effect_instant *now) {
  memset(now, 0, sizeof *now);
  now->q = motion->q[joint];
  now->v = motion->v[joint];
  now->slip = motion->slip[joint];
  now->t_s = t_s;
  now->offset_Nm = tl_joint_offset(m, joint);
  now->motor_rad = tl_motor_angle(m, joint, now->q);
  now->ratio = tl_motor_ratio(m, joint, now->q);
}

void tl_effect_instant_of(const tl_model *m, const tl_motion *motion, int joint, double t_s,
                          const double *effort_Nm, tl_effect_instant *now) {
  const tl_drive *d = &m->drive[joint];
  double torque[TL_MAX_JOINTS];

  tl_effect_place_of(m, motion, joint, t_s, now);
  tl_inverse(m, motion, torque);
  now->friction_Nm = d->coulomb_Nm * now->slip + d->viscous_Nms_rad * now->v;
  now->rotor_Nm = tl_rotor_torque(m, motion, joint);
  now->load_Nm = torque[joint] * tl_torque_ratio(m, joint, now->q) - now->friction_Nm;
  now->load_Nm -= now->offset_Nm;
  now->motor_Nm = tl_motor_torque(m, torque[joint], now->ratio);
  now->gravity_tilt_Nm = tl_effect_tilt_of(m, motion, joint);
  if (!effort_Nm) return;
  /* with a sensor at the output the drive's torque is known, and is what the gear carries */
  now->effort_Nm = now->load_Nm = *effort_Nm;
  now->rotor_Nm = now->friction_Nm = now->offset_Nm = 0.0;
  now->motor_Nm = *effort_Nm / now->ratio;
}

void tl_effect_law(const tl_effect *e, const tl_effect_instant *now, double *torque, double *friction) {
  double t[TL_EFFECT_MAX_STRENGTHS], f[TL_EFFECT_MAX_STRENGTHS];
  int k;

  *torque = *friction = 0.0;
  if (!e->kind->law) return;
  e->kind->law(now, e->value + e->kind->strengths, t, f);
  for (k = 0; k < e->kind->strengths; k++) {
    *torque += e->value[k] * t[k];
    *friction += e->value[k] * f[k];
  }
}

void tl_effect_columns(const tl_effect_kind *kind, const double *shape, const tl_effect_instant *now,
                       double *column) {
  double f[TL_EFFECT_MAX_STRENGTHS];
  int k;

  for (k = 0; k < kind->strengths; k++) column[k] = 0.0;
  if (!kind->law) return;
  kind->law(now, shape, column, f);
  for (k = 0; k < kind->strengths; k++) column[k] += f[k] * now->slip;
}

void tl_effect_columns_at(const tl_effect_kind *kind, const double *shape, const tl_effect_instant *now,
                          size_t n, double *column) {
  double at_once[TL_EFFECT_MAX_STRENGTHS];
  size_t i;
  int k;

  for (i = 0; i < n; i++) {
    tl_effect_columns(kind, shape, &now[i], at_once);
    for (k = 0; k < kind->strengths; k++) column[(size_t)k * n + i] = at_once[k];
  }
}

int tl_effect_at(const tl_effect *e, int joint) {
  return e->joint == joint || e->joint == TL_MAX_JOINTS;
}

/* what the effects of one sort of action add at the joint */
static double sum_of(const tl_effect *effect, int n, int joint, int acts, const tl_effect_instant *now) {
  double sum = 0.0, torque, friction;
  int i;

  for (i = 0; i < n; i++) {
    if (effect[i].kind->acts != acts || !tl_effect_at(&effect[i], joint)) continue;
    tl_effect_law(&effect[i], now, &torque, &friction);
    sum += torque + friction * now->slip;
  }
  return sum;
}

double tl_effects_torque(const tl_effect *effect, int n, const tl_model *m, const tl_motion *motion,
                         int joint, double t_s, double temp_C, const double *effort_Nm) {
  tl_effect_instant now;
  double sum;
  int i, any = 0;

  for (i = 0; i < n; i++) any |= tl_effect_at(&effect[i], joint);
  if (!any) return 0.0;
  tl_effect_instant_of(m, motion, joint, t_s, effort_Nm, &now);
  now.temp_C = temp_C;
  sum = sum_of(effect, n, joint, TL_EFFECT_MECHANICAL, &now);
  /* the motor bears the mechanical ones, and its current shows what it bears */
  if (!effort_Nm) now.motor_Nm += sum / now.ratio;
  sum += sum_of(effect, n, joint, TL_EFFECT_MEASURED, &now);
  return sum / tl_torque_ratio(m, joint, now.q);
}

/* ---- over a segment -------------------------------------------------------------- */

void tl_effect_instants(const tl_effect_segment *s, int joint, tl_effect_instant *now) {
  tl_motion motion;
  size_t i;

  for (i = 0; i < s->n; i++) {
    tl_columns_motion(s, i, &motion);
    tl_effect_instant_of(s->model, &motion, joint, s->t_s[i], s->effort_Nm ? &s->effort_Nm[i] : NULL,
                         &now[i]);
  }
}

/* one shape's columns: where they go, all 0 before */
static tl_effect_wanted cleared(const tl_effect_wanted *wanted, size_t columns, size_t from, size_t n) {
  tl_effect_wanted own = *wanted;
  size_t k;
  int c;

  for (c = 0; c < TL_EFFECT_CHANNELS; c++) {
    if (!own.shown[c]) continue;
    own.shown[c] += from;
    for (k = 0; k < columns; k++)
      if (own.strengths >> k & 1u) tl_columns_nothing(own.shown[c] + k * n, n);
  }
  return own;
}

/* links that wait until so many of them are stepped at once */
typedef struct {
  tl_columns_link link[TL_TWO_MASS_LANES];
  int links, lanes;
  double *work;
  size_t work_each;
} link_queue;

static link_queue queue_of(tl_effect_prepared *const *p, size_t segments, double *work, int lanes) {
  link_queue queue;
  size_t i, n = 0;

  memset(&queue, 0, sizeof queue);
  for (i = 0; i < segments; i++)
    if (p[i]->segment->n > n) n = p[i]->segment->n;
  queue.lanes = lanes < TL_TWO_MASS_LANES ? lanes : TL_TWO_MASS_LANES;
  queue.work = work;
  queue.work_each = tl_effect_link_memory(n);
  return queue;
}

static void step_queue(link_queue *queue, int joint) {
  tl_columns_links(queue->link, queue->links, joint);
  queue->links = 0;
}

/* one shape's columns over one segment, a link's when as many wait as there is room for */
static void add_columns(const tl_effect_kind *kind, int joint, const double *shape, tl_effect_prepared *p,
                        tl_effect_wanted own, link_queue *queue) {
  if (kind->link && (own.strengths & 1u)) {
    tl_columns_link *link = &queue->link[queue->links];
    link->p = p;
    memset(&link->joint, 0, sizeof link->joint);
    kind->link(shape, &link->joint);
    link->wanted = own;
    link->work = queue->work + (size_t)queue->links * queue->work_each;
    if (++queue->links >= queue->lanes) step_queue(queue, joint);
  }
  if (kind->columns) kind->columns(p, joint, shape, &own);
}

void tl_effect_segments_columns(const tl_effect_kind *kind, int joint, const double *shape, size_t shapes,
                                tl_effect_prepared *const *p, const tl_effect_wanted *wanted, size_t segments,
                                double *work, int lanes) {
  link_queue queue = queue_of(p, segments, work, lanes);
  size_t columns = (size_t)kind->strengths, i, k;

  for (i = 0; i < shapes; i++)
    for (k = 0; k < segments; k++) {
      size_t n = p[k]->segment->n;
      tl_effect_wanted own = cleared(&wanted[k], columns, i * columns * n, n);
      if (n > 0) add_columns(kind, joint, shape + i * (size_t)kind->shapes, p[k], own, &queue);
    }
  step_queue(&queue, joint);
}

void tl_effect_segment_columns(const tl_effect_kind *kind, int joint, const double *shape, size_t shapes,
                               tl_effect_prepared *p, const tl_effect_wanted *wanted) {
  tl_effect_segments_columns(kind, joint, shape, shapes, &p, wanted, 1, p->work, 1);
}

void tl_effect_add_wave(tl_effect_waves *to, double per_turn, double sine_rad, double cosine_rad) {
  if (sine_rad == 0.0 && cosine_rad == 0.0) return;
  if (to->n < TL_EFFECT_WAVES) {
    to->per_turn[to->n] = per_turn;
    to->sine_rad[to->n] = sine_rad;
    to->cosine_rad[to->n] = cosine_rad;
  }
  to->n++;
}

void tl_effect_add_mount(tl_effect_change *to, tl_mount_mode mode, double compliance, double frequency_Hz,
                         double damping_ratio) {
  tl_effect_mount made = {mode, compliance, frequency_Hz, damping_ratio};

  if (!(compliance > 0.0)) return;
  if (to->mount_modes < TL_MOUNT_MODES) to->mount[to->mount_modes] = made;
  to->mount_modes++;
}

void tl_effect_waves_at(const tl_effect_waves *waves, double x, double wave[3]) {
  double sine, cosine, n;
  int k;

  wave[0] = wave[1] = wave[2] = 0.0;
  for (k = 0; k < waves->n && k < TL_EFFECT_WAVES; k++) {
    n = waves->per_turn[k];
    tl_sincos(n * x, &sine, &cosine);
    wave[0] += waves->sine_rad[k] * sine + waves->cosine_rad[k] * cosine;
    wave[1] += n * (waves->sine_rad[k] * cosine - waves->cosine_rad[k] * sine);
    wave[2] -= n * n * (waves->sine_rad[k] * sine + waves->cosine_rad[k] * cosine);
  }
}

tl_effect_change tl_effects_change(const tl_effect *effect, int n, int joint) {
  tl_effect_change sum;
  int i;

  memset(&sum, 0, sizeof sum);
  for (i = 0; i < n; i++)
    if (effect[i].joint == joint && effect[i].kind->change) effect[i].kind->change(effect[i].value, &sum);
  return sum;
}

void tl_effects_segment_torque(const tl_effect *effect, int n, tl_effect_prepared *p, int joint,
                               double *column, double *sum) {
  const tl_effect_segment *s = p->segment;
  tl_effect_wanted wanted;
  size_t i;
  int e, k;

  for (e = 0; e < n; e++) {
    const tl_effect_kind *kind = effect[e].kind;
    if (!(kind->columns || kind->link) || kind->exact) continue;
    memset(&wanted, 0, sizeof wanted);
    wanted.shown[joint] = column;
    for (k = 0; k < kind->strengths; k++)
      if (effect[e].value[k] != 0.0) wanted.strengths |= 1u << k;
    if (wanted.strengths == 0) continue;
    tl_effect_segment_columns(kind, effect[e].joint, effect[e].value + kind->strengths, 1, p, &wanted);
    for (k = 0; k < kind->strengths; k++)
      for (i = 0; i < s->n && (wanted.strengths >> k & 1u); i++)
        sum[i] += effect[e].value[k] * column[(size_t)k * s->n + i] /
                  tl_torque_ratio(s->model, joint, s->q[joint][i]);
  }
}
