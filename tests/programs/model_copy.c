/* model_copy.c: reads a model and writes it again, for tests/test_model_file.py.
 *
 *   model_copy IN [OUT [PARAMETER VALUE]]
 *
 * Prints every number that was read, "name value" with 17 digits. PARAMETER, by its name in
 * tl_parameters, gets VALUE before the model is written.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model/model_file.h"

#define SHOW(member) printf("%s %.17g\n", #member, m->member)

static void show_transmission(const char *joint, const tl_transmission *t) {
  printf("%s.kind %d\n", joint, (int)t->kind);
  printf("%s.ratio %.17g\n", joint, t->ratio);
  printf("%s.lead_m %.17g\n%s.AB_m %.17g\n%s.BO_m %.17g\n", joint, t->linkage.lead_m, joint, t->linkage.AB_m,
         joint, t->linkage.BO_m);
  printf("%s.AC_m %.17g\n%s.BOF_deg %.17g\n", joint, t->linkage.AC_m, joint, t->linkage.BOF_deg);
  printf("%s.omega %.17g\n", joint, t->fourier.omega);
  for (int i = 0; i <= TL_FOURIER_ORDER; i++) printf("%s.a%d %.17g\n", joint, i, t->fourier.a[i]);
  for (int i = 0; i < TL_FOURIER_ORDER; i++) printf("%s.b%d %.17g\n", joint, i, t->fourier.b[i]);
}

static void show_drive(const tl_model *m, int j) {
  const char *joint = tl_joint_name(m, j);
  show_transmission(joint, &m->drive[j].transmission);
  printf("%s.torque_constant %.17g\n", joint, m->drive[j].torque_constant_Nm_A);
  printf("%s.rotor_inertia %.17g\n", joint, m->drive[j].rotor_inertia_kg_m2);
  printf("%s.coulomb %.17g\n", joint, m->drive[j].coulomb_Nm);
  printf("%s.viscous %.17g\n", joint, m->drive[j].viscous_Nms_rad);
}

static void show_model(const tl_model *m) {
  printf("plant %s\nform %d\n", tl_plant_facts(m->plant)->name, (int)m->form);
  SHOW(gravity_m_s2);
  SHOW(shank_length_m), SHOW(shank_mass_kg), SHOW(shank_com_m), SHOW(shank_inertia_kg_m2);
  SHOW(foot_mass_kg), SHOW(foot_com_m), SHOW(foot_inertia_kg_m2);
  SHOW(ankle_motor_mass_kg), SHOW(ankle_motor_com_m);
  SHOW(inertia_kg_m2), SHOW(gravity_moment_kg_m), SHOW(gravity_zero_rad), SHOW(torque_offset_Nm);
  SHOW(mass_kg), SHOW(force_offset_N);
  for (int j = 0; j < tl_joint_count(m); j++) show_drive(m, j);
}

static void show_settings(const struct model_file *f) {
  printf("has_score %d\nlowpass_hz %.17g\norder %d\n", f->has_score, f->score.lowpass_hz, f->score.order);
  printf("standstill %.17g\nguard_s %.17g\ntrim_s %.17g\n", f->score.standstill, f->score.guard_s,
         f->score.trim_s);
  printf("has_window %d\n", f->has_window);
  if (f->has_window) printf("window_order %d\nwindow_s %.17g\n", f->window.order, f->window.length_s);
  int n;
  const tl_parameter *parameter = tl_parameters(&f->model, &n);
  for (int i = 0; i < n; i++)
    if (f->bounded[i]) printf("bound.%s %.17g %.17g\n", parameter[i].name, f->lower[i], f->upper[i]);
}

static void change(tl_model *m, const char *name, double value) {
  int n;
  double p[TL_MAX_PARAMETERS];
  const tl_parameter *parameter = tl_parameters(m, &n);
  tl_parameters_get(m, p);
  for (int i = 0; i < n; i++)
    if (strcmp(parameter[i].name, name) == 0) p[i] = value;
  tl_parameters_set(m, p);
}

int main(int argc, char **argv) {
  struct app_error error;
  struct model_file file;
  app_set_name("model_copy");
  if (argc < 2) return APP_BAD_INPUT;
  if (model_file_read(argv[1], &file, &error) != 0) return app_exit(&error);
  show_model(&file.model);
  show_settings(&file);
  if (argc > 4) change(&file.model, argv[3], strtod(argv[4], NULL));
  if (argc > 2 && model_file_write(argv[2], &file, "first line\nsecond line", &error) != 0)
    return app_exit(&error);
  return APP_OK;
}
