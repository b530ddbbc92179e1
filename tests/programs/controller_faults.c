/* Random fault sequences through the whole tick, in double, float and fixed point at once.
 *
 *     controller_faults MODEL.yaml SEQUENCES SEED CURRENT_A
 *
 * A sequence is a motion that the joints can make, whose frames are dropped, late, repeated, swapped, not numbers, jumping
 * or frozen, with the bus down and emergency stops between, and stops approached at speed. After every tick: torque, rate, power and
 * current limits, what float and fixed point tell beside double, and zero torque 20 ms after the last good frame. Prints how
 * often each fault was played and each bit of the status seen, and the first broken rule; exit status 1 then. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "controller_pair.h"
#include "talus/random.h"

#define TICKS 400
#define SLACK 1e-6 /* of a limit, for float; and a unit of Q26 */

enum fault {
  NONE,
  DROPPED,
  LATE,
  REPEATED,
  SWAPPED,
  NOT_A_NUMBER,
  JUMPING,
  FROZEN,
  BUS_DOWN,
  STOP,
  HUGE_NUMBER,
  SHAKING,
  FAULTS
};
static const char *const fault_name[FAULTS] = {"none",     "dropped", "late",    "repeated",
                                               "swapped",  "nan",     "jumping", "frozen",
                                               "bus_down", "stop",    "huge",    "shaking"};

struct sequence {
  uint64_t seed, number;
  uint32_t drawn;
  enum fault fault;
  int left;         /* ticks of the fault */
  int desired_only; /* it strikes the desired frames alone, or both */
  double amplitude[2], omega[2], phase[2], middle[2];
  int since_good; /* ticks since frames of both kinds arrived that are new and numbers */
  int stopped;    /* ticks of an emergency stop so far */
  tl_controller_input_f64 before;
};

struct run {
  struct trio t;
  struct sequence s;
  tl_controller_state_f64 f64;
  tl_controller_state_f32 f32;
  tl_controller_state_q31 q31;
  unsigned long played[FAULTS], driven; /* ticks whose torque is not zero */
  uint32_t seen;                        /* bits of the status */
  double ratio[2];                      /* the largest, by a search of its own */
};

static double draw(struct sequence *s, double low, double high) {
  double u[2];

  tl_random_uniform2(s->seed, s->number, s->drawn++, u);
  return low + (high - low) * u[0];
}

/* a sine that stays within speed and acceleration limits; its angle may pass the stops */
static void begin(struct run *r, uint64_t seed, uint64_t number) {
  struct sequence *s = &r->s;
  int j;

  *s = (struct sequence){.seed = seed, .number = number};
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    const tl_controller_joint_f64 *to = &r->t.f64.joint[j];
    double speed = to->speed_limit_rad_s * draw(s, 0.05, 0.95), most = 0.9 * to->acceleration_limit / speed;

    s->omega[j] = draw(s, 0.5, most < 60.0 ? most : 60.0);
    s->amplitude[j] = speed / s->omega[j];
    s->phase[j] = draw(s, 0.0, 6.28);
    s->middle[j] = draw(s, to->low_rad, to->high_rad);
  }
  tl_controller_start_f64(&r->f64);
  tl_controller_start_f32(&r->f32);
  tl_controller_start_q31(&r->q31);
}

static void true_frame(const struct sequence *s, int tick, double tick_s, tl_controller_frame_f64 *f) {
  int j;

  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    double at = s->phase[j] + s->omega[j] * tick_s * tick;

    f->angle_rad[j] = s->middle[j] + s->amplitude[j] * sin(at);
    f->speed_rad_s[j] = s->amplitude[j] * s->omega[j] * cos(at);
    f->acceleration[j] = -s->amplitude[j] * s->omega[j] * s->omega[j] * sin(at);
  }
  f->count = (uint32_t)tick - 5U; /* passes through 2^32 */
}

static void next_fault(struct run *r) {
  struct sequence *s = &r->s;

  if (s->left-- > 0) return;
  s->fault = draw(s, 0.0, 1.0) < 0.5 ? NONE : (enum fault)(1 + (int)draw(s, 0.0, FAULTS - 1));
  s->left = (int)(draw(s, 0.0, 1.0) < 0.5 ? draw(s, 1.0, 8.0) : draw(s, 8.0, 120.0));
  s->desired_only = draw(s, 0.0, 1.0) < 0.3;
  r->played[s->fault]++;
}

static void spoil(struct sequence *s, tl_controller_frame_f64 *f, const tl_controller_frame_f64 *before,
                  int tick, double tick_s) {
  int j = draw(s, 0.0, 1.0) < 0.5;

  switch (s->fault) {
  case DROPPED:
  case BUS_DOWN:
  case REPEATED: *f = *before; break;
  case LATE: true_frame(s, tick - 1 - tick % 4, tick_s, f); break;
  case SWAPPED: true_frame(s, tick % 2 ? tick - 3 : tick, tick_s, f); break;
  case NOT_A_NUMBER: *(draw(s, 0.0, 1.0) < 0.5 ? &f->angle_rad[j] : &f->speed_rad_s[j]) = NAN; break;
  case JUMPING: f->angle_rad[j] += draw(s, -1.0, 1.0); break;
  case FROZEN:
    f->angle_rad[j] = before->angle_rad[j];
    f->speed_rad_s[j] = before->speed_rad_s[j];
    break;
  case HUGE_NUMBER:
    *(draw(s, 0.0, 1.0) < 0.5 ? &f->acceleration[j] : &f->speed_rad_s[j]) = draw(s, -1.0, 1.0) * 1e30;
    break;
  case SHAKING: f->acceleration[j] = draw(s, -150.0, 150.0); break; /* possible, and no fault */
  case NONE:
  case STOP:
  case FAULTS: break;
  }
}

/* the frames of a tick, and whether torque may stay: a count that does not rise, or NaN, is never a good frame */
static void play(struct run *r, int tick, tl_controller_input_f64 *in) {
  struct sequence *s = &r->s;
  double tick_s = r->t.settings.tick_s;

  next_fault(r);
  true_frame(s, tick, tick_s, &in->desired);
  true_frame(s, tick, tick_s, &in->measured);
  in->enable = s->fault != STOP;
  spoil(s, &in->desired, &s->before.desired, tick, tick_s);
  if (!s->desired_only) spoil(s, &in->measured, &s->before.measured, tick, tick_s);
  s->since_good++;
  if (s->fault != DROPPED && s->fault != BUS_DOWN && s->fault != REPEATED && s->fault != NOT_A_NUMBER &&
      s->fault != HUGE_NUMBER)
    s->since_good = 0;
  s->stopped = in->enable ? 0 : s->stopped + 1;
  s->before = *in;
}

/* ---- rules -------------------------------------------------------------------------- */

static int broken(const struct sequence *s, int tick, const char *scalar, int joint, const char *rule,
                  double value, double limit) {
  printf("sequence %llu, tick %d, %s, joint %d: %s %.9g beyond %.9g\n", (unsigned long long)s->number, tick,
         scalar, joint, rule, value, limit);
  return 1;
}

/* one joint's torque and current after a tick, in SI, against every limit */
static int check(const struct run *r, int tick, const char *scalar, int joint, const double now[2],
                 double before, double speed) {
  const tl_controller_joint_settings *limit = &r->t.settings.joint[joint];
  const tl_controller_joint_f64 *c = &r->t.f64.joint[joint];
  double power, most;

  power = fabs(now[0] * speed) * r->ratio[joint];
  most = c->torque_limit_Nm;
  if (!(fabs(now[0]) <= most * (1.0 + SLACK)))
    return broken(&r->s, tick, scalar, joint, "torque", now[0], most);
  most = limit->rate_Nm_s * r->t.settings.tick_s;
  if (!(fabs(now[0] - before) <= most * (1.0 + SLACK) + 3e-7))
    return broken(&r->s, tick, scalar, joint, "rate", now[0] - before, most);
  if (!(power <= limit->power_limit_W * (1.0 + SLACK)))
    return broken(&r->s, tick, scalar, joint, "power", power, limit->power_limit_W);
  if (!(fabs(now[1]) <= limit->current_limit_A * (1.0 + SLACK)))
    return broken(&r->s, tick, scalar, joint, "current", now[1], limit->current_limit_A);
  most = r->t.settings.tick_s * (r->s.since_good > r->s.stopped ? r->s.since_good : r->s.stopped);
  if (most >= TL_CONTROLLER_DECAY_S && now[0] != 0.0)
    return broken(&r->s, tick, scalar, joint, "torque without a good frame", now[0], 0.0);
  return 0;
}

static void search_ratios(struct run *r) {
  double ratio, slope;
  int i, j;

  for (j = 0; j < TL_CONTROLLER_JOINTS; j++)
    for (i = 0; i <= 1000; i++) {
      const tl_controller_joint_settings *limit = &r->t.settings.joint[j];

      tl_transmission_ratio(&r->t.file.model.drive[j].transmission,
                            limit->low_rad + (limit->high_rad - limit->low_rad) * i / 1000.0, &ratio, &slope);
      r->ratio[j] = fmax(r->ratio[j], fabs(ratio));
    }
}

static int tick_all(struct run *r, int tick) {
  tl_controller_input_f64 in = {.enable = 1};
  tl_controller_input_f32 in_f32;
  tl_controller_input_q31 in_q31;
  tl_controller_output_f64 out;
  tl_controller_output_f32 out_f32;
  tl_controller_output_q31 out_q31;
  tl_controller_state_f64 f64 = r->f64;
  tl_controller_state_f32 f32 = r->f32;
  tl_controller_state_q31 q31 = r->q31;
  int j;

  play(r, tick, &in);
  frame_to_f32(&in.desired, &in_f32.desired);
  frame_to_f32(&in.measured, &in_f32.measured);
  frame_to_q31(&in.desired, &in_q31.desired);
  frame_to_q31(&in.measured, &in_q31.measured);
  in_f32.enable = in_q31.enable = in.enable;
  tl_controller_tick_f64(&r->t.f64, &r->f64, &in, &out);
  tl_controller_tick_f32(&r->t.f32, &r->f32, &in_f32, &out_f32);
  tl_controller_tick_q31(&r->t.q31, &r->q31, &in_q31, &out_q31);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    double a[2] = {out.torque_Nm[j], out.current_A[j]};
    double b[2] = {(double)out_f32.torque_Nm[j], (double)out_f32.current_A[j]};
    double c[2] = {tl_fixed_to_double(out_q31.torque_Nm[j], TL_Q_MOTOR_TORQUE),
                   tl_fixed_to_double(out_q31.current_A[j], TL_Q_CURRENT)};

    if (check(r, tick, "double", j, a, f64.torque_Nm[j], r->f64.measured.speed_rad_s[j])) return 1;
    if (check(r, tick, "float", j, b, (double)f32.torque_Nm[j], (double)r->f32.measured.speed_rad_s[j]))
      return 1;
    if (check(r, tick, "fixed", j, c, tl_fixed_to_double(q31.torque_Nm[j], TL_Q_MOTOR_TORQUE),
              tl_fixed_to_double(r->q31.measured.speed_rad_s[j], TL_Q_SPEED)))
      return 1;
  }
  r->driven += out.torque_Nm[0] != 0.0;
  r->seen |= out.status & out_f32.status & out_q31.status;
  if (out_q31.status & TL_CONTROLLER_SATURATED) return broken(&r->s, tick, "fixed", 0, "saturated", 1.0, 0.0);
  return 0;
}

int main(int argc, char **argv) {
  static struct run r;
  struct app_error error;
  uint64_t i, n, seed;
  int tick, f;

  if (argc != 5) return 2;
  if (trio_read(&r.t, argv[1], strtod(argv[4], NULL), &error) != 0) return app_exit(&error);
  search_ratios(&r);
  n = strtoull(argv[2], NULL, 10);
  seed = strtoull(argv[3], NULL, 10);
  for (i = 0; i < n; i++) {
    begin(&r, seed, i);
    for (tick = 0; tick < TICKS; tick++)
      if (tick_all(&r, tick)) return 1;
  }
  for (f = 0; f < FAULTS; f++) printf("%s %lu\n", fault_name[f], r.played[f]);
  printf("driven %lu\nseen %lu\n", r.driven, (unsigned long)r.seen);
  return 0;
}
