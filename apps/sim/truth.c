/* truth.c: see truth.h. */
#include "truth.h"

#include <stdio.h>

#include "common/json_file.h"

#define MOTION_COLUMNS 6 /* a joint */

/* the header of the file of true motion */
void truth_motion_header(struct output *out, const tl_model *m) {
  static const struct {
    const char *quantity, *per_time;
  } column[MOTION_COLUMNS - 2] = {
      {"reference", ""}, {"position", ""}, {"velocity", "_s"}, {"acceleration", "_s2"}};
  const tl_facts *f = tl_plant_facts(m->plant);

  output_text(out, "time_s");
  for (int j = 0; j < f->joints; j++) {
    for (int k = 0; k < MOTION_COLUMNS - 2; k++)
      output_printf(out, ",%s_%s_%s%s", f->joint[j], column[k].quantity, f->coordinate_unit,
                    column[k].per_time);
    output_printf(out, ",%s_torque_%s,%s_slip", f->joint[j], f->torque_unit, f->joint[j]);
  }
  output_text(out, "\n");
}

void truth_motion_row(struct output *out, const tl_twin *b, double t_s) {
  double value[TL_MAX_JOINTS * MOTION_COLUMNS];
  int joints = tl_joint_count(b->model);
  tl_motion reference, joint;
  const tl_motion *now = &joint;

  tl_simulation_joints(b->model, &b->simulation, &joint);
  tl_twin_reference(b, &reference);
  for (int j = 0; j < joints; j++) {
    double *of = value + j * MOTION_COLUMNS;
    of[0] = reference.q[j];
    of[1] = now->q[j];
    of[2] = now->v[j];
    of[3] = now->a[j];
    of[4] = b->torque[j];
    of[5] = now->slip[j];
  }
  output_row(out, t_s, value, (size_t)joints * MOTION_COLUMNS);
}

static json_t *truth_of_excitation(const struct twin *t) {
  static const char *const name[] = {"multisine", "paper", "ramps", "bus", "reference"};
  const tl_excitation *e = &t->excitation;
  size_t joints = (size_t)tl_joint_count(&t->model), harmonics = (size_t)e->harmonics;
  json_t *o = json_object();

  json_set_text(o, "kind", name[t->asked->excitation]);
  if (t->asked->reference) {
    json_set_text(o, "file", t->asked->reference);
    json_set_number(o, "length_s", trajectory_length_s(&t->trajectory));
    return o;
  }
  json_object_set_new(o, "scaled_amplitude", json_numbers(t->scaling.amplitude, joints));
  json_set_number(o, "scaled_speed", t->scaling.speed);
  json_set_number(o, "length_s", tl_excitation_length_s(e));
  json_set_number(o, "fade_s", e->fade_s);
  json_set_number(o, "settle_s", t->bench.settle_s);
  json_object_set_new(o, "offset", json_numbers(e->offset, joints));
  if (e->kind == TL_EXCITATION_RAMPS) return o;
  json_set_number(o, "base_hz", e->base_hz);
  for (size_t j = 0; j < joints; j++) {
    json_t *of = json_object();
    json_object_set_new(of, "sine", json_numbers(e->sine[j], harmonics));
    json_object_set_new(of, "cosine", json_numbers(e->cosine[j], harmonics));
    json_object_set_new(o, tl_joint_name(&t->model, (int)j), of);
  }
  return o;
}

static json_t *truth_of_sensors(const struct twin *t) {
  const tl_twin_settings *s = &t->bench;
  const tl_facts *f = tl_plant_facts(t->model.plant);
  size_t joints = (size_t)f->joints;
  json_t *o = json_object();
  char key[64];

  json_set_number(o, "sample_hz", s->sample_hz);
  json_set_number(o, "jitter_s", s->jitter_s);
  snprintf(key, sizeof key, "%s_noise_%s", f->torque_name, f->torque_unit);
  json_object_set_new(o, f->motor ? "current_noise_A" : key, json_numbers(s->current_noise_A, joints));
  snprintf(key, sizeof key, "%s_step_%s", f->motor ? "encoder" : "position", f->coordinate_unit);
  json_object_set_new(o, key, json_numbers(s->drive_step_rad, joints));
  for (int j = 0; j < f->joints; j++) {
    if (f->sensors.encoder[j] == TL_NO_CHANNEL) continue;
    snprintf(key, sizeof key, "%s_joint_step_rad", f->joint[j]);
    json_set_number(o, key, s->ankle_step_rad);
  }
  if (t->asked->camera) json_set_number(o, "camera_noise_rad", s->camera_noise_rad);
  return o;
}

static json_t *truth_of_effects(const struct twin *t) {
  json_t *list = json_array();

  for (int i = 0; i < t->effects; i++) {
    const tl_effect *e = &t->effect[i];
    json_t *o = json_object(), *parameters = json_object();
    for (int k = 0; k < e->kind->strengths + e->kind->shapes; k++)
      if (tl_effect_says(e, k)) json_set_number(parameters, e->kind->parameter[k].name, e->value[k]);
    json_set_text(o, "effect", e->kind->name);
    json_set_text(o, "joint", model_effect_joint(&t->model, e->joint));
    json_object_set_new(o, "parameters", parameters);
    json_array_append_new(list, o);
  }
  return list;
}

static json_t *truth_of_bus(const struct twin *t) {
  const struct twin_live *live = &t->live;
  json_t *o = json_object();

  json_set_text(o, "interface", t->asked->can);
  json_object_set_new(o, "begin_real_ns", json_integer((json_int_t)live->begin_real_ns));
  json_object_set_new(o, "ticks", json_integer((json_int_t)live->ticks));
  json_object_set_new(o, "late_ticks", json_integer((json_int_t)live->late));
  json_set_number(o, "worst_lateness_s", live->worst_s);
  json_object_set_new(o, "frames_sent", json_integer((json_int_t)live->sent));
  json_object_set_new(o, "frames_refused", json_integer((json_int_t)live->refused));
  json_object_set_new(o, "setpoints", json_integer((json_int_t)live->setpoints));
  json_object_set_new(o, "ticks_without_setpoint", json_integer((json_int_t)live->missed));
  json_object_set_new(o, "motor_zero_count", json_numbers(live->zero_count, TL_MAX_JOINTS));
  return o;
}

int truth_write(const struct twin *t, const tl_twin *b, struct app_error *error) {
  double parameter[TL_MAX_PARAMETERS], base[TL_MAX_BASE];
  json_t *root = json_object(), *parameters = json_object(), *bases = json_object();
  int n, result;
  const tl_parameter *table = tl_parameters(&t->model, &n);

  tl_parameters_get(&t->model, parameter);
  tl_base_values(&t->model, base);
  for (int i = 0; i < n; i++) json_set_number(parameters, table[i].name, parameter[i]);
  for (int i = 0; i < tl_base_count(&t->model); i++)
    json_set_number(bases, tl_base_name(&t->model, i), base[i]);
  json_set_text(root, "schema", "talus-sim/1");
  json_set_text(root, "plant", tl_plant_facts(t->model.plant)->name);
  json_object_set_new(root, "seed", json_integer((json_int_t)t->asked->seed));
  json_object_set_new(root, "phase_seed", json_integer((json_int_t)t->asked->phase_seed));
  json_set_number(root, "duration_s", t->duration_s);
  json_object_set_new(root, "parameters", parameters);
  json_object_set_new(root, "base_parameters", bases);
  json_object_set_new(root, "effects", truth_of_effects(t));
  json_object_set_new(root, "sensors", truth_of_sensors(t));
  json_object_set_new(root, "excitation", truth_of_excitation(t));
  if (t->asked->can) json_object_set_new(root, "bus", truth_of_bus(t));
  json_object_set_new(root, "stick_slip_changes", json_integer((json_int_t)b->simulation.changes));
  result = json_file_write(t->asked->truth, root, error);
  json_decref(root);
  return result;
}
