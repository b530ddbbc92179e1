/* twin_read.c: the job: lines `name value` or `name[i] value`; knee.NAME and ankle.NAME for a joint */
#include "twin.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  const char *name;
  size_t at, count;
} field;

#define ONE(type, name)                                                                                      \
  { #name, offsetof(type, name), 1 }
#define MANY(type, name, n)                                                                                  \
  { #name, offsetof(type, name), n }
#define B(name) ONE(twin_bench, name)
#define J(name) ONE(twin_joint, name)

static const field of_bench[] = {B(gravity),
                                 B(ms),
                                 B(ds),
                                 B(i1),
                                 B(mf),
                                 B(df),
                                 B(i_f),
                                 B(mm),
                                 B(dma),
                                 B(ls),
                                 B(ima),
                                 B(ratio),
                                 B(lead),
                                 B(ab),
                                 B(bo),
                                 B(ac),
                                 B(bof),
                                 B(n_ab),
                                 B(n_bo),
                                 B(n_ac),
                                 B(wave_a),
                                 B(wave_w),
                                 B(wave_p),
                                 B(tilt),
                                 B(tilt_foot),
                                 B(x_mass),
                                 B(x_k),
                                 B(x_c),
                                 B(z_mass),
                                 B(z_k),
                                 B(z_c),
                                 B(phi_inertia),
                                 B(phi_k),
                                 B(phi_c),
                                 B(phi_lever),
                                 B(cable),
                                 B(cable_2),
                                 B(jump_s),
                                 B(jump_mass),
                                 B(jump_r),
                                 B(jump_length),
                                 B(fan_a),
                                 B(fan_w),
                                 B(fan_p),
                                 B(fan_on),
                                 B(drag),
                                 B(drag_power),
                                 B(toe_r),
                                 B(temp_rise),
                                 B(temp_tau),
                                 B(alone),
                                 B(range),
                                 B(step_s),
                                 B(session_s),
                                 B(settle_s),
                                 B(seed),
                                 B(ref_filter),
                                 B(base_hz),
                                 B(harmonics),
                                 B(smooth),
                                 B(points),
                                 MANY(twin_bench, bus_a, MAX_WAVES),
                                 MANY(twin_bench, bus_w, MAX_WAVES),
                                 MANY(twin_bench, bus_p, MAX_WAVES),
                                 MANY(twin_bench, knee_a, HARMONICS),
                                 MANY(twin_bench, knee_p, HARMONICS),
                                 MANY(twin_bench, ankle_a, HARMONICS),
                                 MANY(twin_bench, ankle_p, HARMONICS),
                                 MANY(twin_bench, point_s, MAX_POINTS),
                                 MANY(twin_bench, point_knee, MAX_POINTS),
                                 MANY(twin_bench, point_ankle, MAX_POINTS),
                                 {NULL, 0, 0}};

static const field of_joint[] = {J(coulomb),
                                 J(viscous),
                                 J(stribeck_form),
                                 J(stribeck_extra),
                                 J(stribeck_speed),
                                 J(stribeck_power),
                                 J(load_form),
                                 J(load_coef),
                                 J(load_ref),
                                 J(load_rotor),
                                 J(eff_form),
                                 J(eff_driving),
                                 J(eff_back),
                                 J(eff_smooth),
                                 J(asym_coulomb),
                                 J(asym_viscous),
                                 J(nlv_form),
                                 J(nlv_size),
                                 J(nlv_speed),
                                 J(nlv_power),
                                 J(pos_form),
                                 J(pos_size),
                                 J(pos_centre),
                                 J(pos_width),
                                 J(pos_phase),
                                 J(pre_form),
                                 J(pre_share),
                                 J(pre_travel),
                                 J(pre_power),
                                 J(pre_rise),
                                 J(pre_speed),
                                 J(drift_form),
                                 J(drift_size),
                                 J(drift_tau),
                                 J(drift_session),
                                 J(drift_on),
                                 J(walk_size),
                                 J(walk_tau),
                                 J(cross_size),
                                 J(cross_width),
                                 J(cross_phase),
                                 J(elastic_form),
                                 J(stiffness),
                                 J(hardening),
                                 J(soft_share),
                                 J(soft_zone),
                                 J(damping),
                                 J(gap_half),
                                 J(gap_coulomb),
                                 J(link_share),
                                 J(viscous_share),
                                 J(rotor_share),
                                 J(ripple_load),
                                 J(sat_form),
                                 J(sat_droop),
                                 J(sat_ref),
                                 J(sat_width),
                                 J(dead_zone),
                                 J(delay),
                                 J(lag),
                                 J(enc_n),
                                 J(enc_a),
                                 J(enc_p),
                                 J(spring_form),
                                 J(spring_k),
                                 J(spring_k3),
                                 J(spring_zero),
                                 J(hose_torque),
                                 J(hose_travel),
                                 J(product),
                                 J(offset),
                                 J(torque_constant),
                                 J(current_limit),
                                 J(bandwidth),
                                 J(zeta),
                                 J(control_inertia),
                                 MANY(twin_joint, ripple_n, MAX_WAVES),
                                 MANY(twin_joint, ripple_a, MAX_WAVES),
                                 MANY(twin_joint, ripple_p, MAX_WAVES),
                                 MANY(twin_joint, angle_n, MAX_WAVES),
                                 MANY(twin_joint, angle_a, MAX_WAVES),
                                 MANY(twin_joint, angle_p, MAX_WAVES),
                                 MANY(twin_joint, cog_n, MAX_WAVES),
                                 MANY(twin_joint, cog_a, MAX_WAVES),
                                 MANY(twin_joint, cog_p, MAX_WAVES),
                                 MANY(twin_joint, wander_a, MAX_WAVES),
                                 MANY(twin_joint, wander_w, MAX_WAVES),
                                 MANY(twin_joint, wander_p, MAX_WAVES),
                                 {NULL, 0, 0}};

/* The place that `name[i]` means, or NULL. */
static double *find(void *base, const field *fields, const char *name) {
  size_t length = strcspn(name, "["), index = name[length] ? strtoul(name + length + 1, NULL, 10) : 0;

  for (; fields->name; fields++) {
    if (strlen(fields->name) != length || strncmp(fields->name, name, length) != 0) continue;
    if (index >= fields->count) return NULL;
    return (double *)((char *)base + fields->at) + index;
  }
  return NULL;
}

int twin_read(twin_bench *bench, const char *path) {
  char name[64], number[64], *end;
  double *place;
  FILE *file = fopen(path, "r");

  if (!file) return -1;
  memset(bench, 0, sizeof *bench);
  while (fscanf(file, "%63s %63s", name, number) == 2) {
    if (strncmp(name, "knee.", 5) == 0)
      place = find(&bench->joint[KNEE], of_joint, name + 5);
    else if (strncmp(name, "ankle.", 6) == 0)
      place = find(&bench->joint[ANKLE], of_joint, name + 6);
    else
      place = find(bench, of_bench, name);
    end = number;
    if (place) *place = strtod(number, &end);
    if (!place || *end) {
      fprintf(stderr, place ? "bench_twin: %s: '%s' has no number\n" : "bench_twin: %s: unknown name '%s'\n",
              path, name);
      (void)fclose(file);
      return -1;
    }
  }
  (void)fclose(file);
  twin_zero(bench);
  return 0;
}
