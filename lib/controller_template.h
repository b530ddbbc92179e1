/* controller_template.h: the controller's equations, written once for every scalar (fixed_scalar_*.h and
 * curve_template.h, included before). In floating point MUL is a product and SAT nothing.
 *
 * In fixed point (formats: talus/fixed.h and talus/controller.h) MUL(a, b, drop) brings Qm times Qn to
 * Q(m + n - drop), rounded, in 64 bits; DROP does so for a sum of products RAW of one format. |a b| <= 2^62; a model's
 * numbers are within 2^29 (tl_controller_to_q31 refuses others), so that their products are within 2^60, and no sum has
 * more than 4 of them, or 2 of sines or of slip and level, below (2^31 - 1)^2 + 2^61 each. SAT brings a sum back to
 * 32 bits, held and flagged; HOLD without a flag. So nothing overflows for any frame and any state, and where
 * tl_controller_to_q31 let the model pass, no sum reaches the end of its range within the limits.
 */
typedef NAMED(tl_controller) NAMED(controller);
typedef NAMED(tl_controller_joint) NAMED(joint);
typedef NAMED(tl_controller_frame) NAMED(frame);
typedef NAMED(tl_controller_parts) NAMED(parts);
typedef NAMED(tl_controller_state) NAMED(state);
typedef NAMED(tl_controller_input) NAMED(input);
typedef NAMED(tl_controller_output) NAMED(output);

/* SAT names it in fixed point; floating point has no use of it */
#define UNUSED(x) (void)(x)
#define SIZE(x, saturated) NAMED(size)((x), (saturated))

static inline REAL NAMED(size)(REAL x, uint32_t *saturated) {
  UNUSED(saturated);
  return MAGNITUDE(x);
}

static inline REAL NAMED(between)(REAL x, REAL low, REAL high) {
  REAL above = x > low ? x : low;

  return above < high ? above : high;
}

/* ---- the law ------------------------------------------------------------------- */

/* Inertia and gravity of both joints, docs/equations.md (12); the rotor's part comes later.
 * cosine * (2 a0 + a1) and the like: Q31 times Q19 to Q19; speed^2: Q25 times Q25 to Q19; inertia Q27 times Q19 to Q21;
 * gravity Q21 times Q31 to Q21. */
static inline void NAMED(rigid_leg)(const NAMED(controller) * c, const NAMED(frame) * at,
                                    NAMED(parts) * parts, uint32_t *saturated) {
  const REAL *v = at->speed_rad_s, *a = at->acceleration;
  REAL sin_s, cos_s, sin_a, cos_a, sin_f, cos_f, foot, knee, ankle, both;

  UNUSED(saturated);
  SINCOS(at->angle_rad[0], &sin_s, &cos_s);
  SINCOS(at->angle_rad[1], &sin_a, &cos_a);
  sin_f = SAT(DROP(RAW(sin_s, cos_a) + RAW(cos_s, sin_a), 31));

  /* theta_f'', and what multiplies H = mf df ls in rows s + f and f */
  foot = SAT((WIDE)a[0] + a[1]);
  both = SAT((WIDE)a[0] + foot);
  knee = SAT(2 * MUL(v[0], v[1], 31) + MUL(v[1], v[1], 31));
  knee = SAT(DROP(RAW(cos_a, both) - RAW(sin_a, knee), 31));
  ankle = SAT(MUL(v[0], v[0], 31));
  ankle = SAT(DROP(RAW(cos_a, a[0]) + RAW(sin_a, ankle), 31));

  parts->inertia_Nm[0] =
      SAT(DROP(RAW(c->shank_inertia, a[0]) + RAW(c->foot_inertia, foot) + RAW(c->coupling, knee), 25));
  parts->inertia_Nm[1] = SAT(DROP(RAW(c->foot_inertia, foot) + RAW(c->coupling, ankle), 25));
  parts->gravity_Nm[0] = SAT(DROP(RAW(c->gravity_shank, sin_s) + RAW(c->gravity_foot, sin_f), 31));
  parts->gravity_Nm[1] = SAT(MUL(c->gravity_foot, sin_f, 31));
  parts->effects_Nm[0] = parts->effects_Nm[1] = 0;
  if (c->tilted) {
    cos_f = SAT(DROP(RAW(cos_s, cos_a) - RAW(sin_s, sin_a), 31));
    parts->effects_Nm[0] = SAT(DROP(RAW(c->tilt_shank, cos_s) + RAW(c->tilt_foot, cos_f), 31));
    parts->effects_Nm[1] = SAT(MUL(c->tilt_foot, cos_f, 31));
  }
}

/* Ratio, its slope a step and 1 / ratio at an angle, as curves: their knots lie at the same angles, which are looked up once. */
static inline REAL NAMED(ratio)(const NAMED(joint) * j, REAL q, REAL *slope, REAL *inverse,
                                uint32_t *saturated) {
  REAL u, unused, ratio = UNIT_Q31;
  int32_t i;

  *slope = 0;
  *inverse = UNIT_Q31;
  if (j->ratio.n) {
    TL_CURVE_LOCATE(&j->ratio, q, i, u);
    ratio = NAMED(curve_cubic)(j->ratio.knot + i, u, slope, saturated);
    if (j->inverse.n == j->ratio.n) *inverse = NAMED(curve_cubic)(j->inverse.knot + i, u, &unused, saturated);
  }
  return ratio;
}

/* The ankle's rotor in the joint's coordinate: Ima ka (ka q'' + ka' q'^2), the ratio as curve times scale;
 * c->rotor holds the square of the scale. slope: Q31 a step times Q24 steps a rad to Q27; Q27 times Q19 to Q19. */
static inline REAL NAMED(rotor)(const NAMED(controller) * c, const NAMED(joint) * j, REAL ratio, REAL slope,
                                REAL v, REAL a, uint32_t *saturated) {
  REAL turned;

  UNUSED(saturated);
  slope = SAT(MUL(slope, j->slope_per_rad, 28));
  turned = SAT(MUL(v, v, 31));
  turned = SAT(MUL(ratio, a, 31) + MUL(slope, turned, 27));
  return SAT(MUL(c->rotor, SAT(MUL(ratio, turned, 31)), 25));
}

/* The level of friction beside Coulomb's at this speed and angle: what the curves say, Q21. */
static inline WIDE NAMED(friction_level)(const NAMED(joint) * j, REAL q, REAL speed, uint32_t *saturated) {
  WIDE level = 0;
  REAL slope;

  UNUSED(saturated);
  if (j->slow.n) {
    const NAMED(tl_curve) *curve = speed < j->slow_rad_s ? &j->slow : &j->fast;
    level += MUL(NAMED(curve_at)(curve, speed, &slope, saturated), j->speed_scale, 31);
  }
  if (j->position.n) level += MUL(NAMED(curve_at)(&j->position, q, &slope, saturated), j->position_scale, 31);
  return level;
}

/* Friction that the desired motion meets. slip: Q25 times Q20 to Q30, held in [-1, 1]: it fades around standstill.
 * A load that the motor drives and one that drives it differ by the odd part: |load| slip and load |slip|. */
static inline REAL NAMED(friction)(const NAMED(joint) * j, REAL q, REAL v, REAL load, uint32_t *saturated) {
  REAL slip = NAMED(between)(HOLD(MUL(v, j->friction_gain, 15)), -UNIT_Q30, UNIT_Q30);
  REAL speed = SIZE(v, saturated), level, bias;
  WIDE dry = j->dry_Nm, sliding, viscous = RAW(j->viscous, v);

  UNUSED(saturated);
  dry += NAMED(friction_level)(j, q, speed, saturated);
  if (j->uses & TL_CONTROLLER_USES_LOAD) dry += MUL(j->load_even, SIZE(load, saturated), 30);
  level = SAT(dry);
  sliding = RAW(slip, level);
  if (j->uses & (TL_CONTROLLER_USES_LOAD | TL_CONTROLLER_USES_ASYMMETRY)) {
    bias = SAT(j->asymmetry_Nm + MUL(j->load_odd, load, 30));
    sliding += RAW(SIZE(slip, saturated), bias);
    viscous += RAW(j->viscous_asymmetry, speed);
  }
  return SAT(DROP(sliding, 30) + DROP(viscous, 27));
}

/* Motor torque of one joint. Sum over the ratio: Q21 times Q31 to Q21, then times Q31 to Q26. */
static inline REAL NAMED(motor_torque)(const NAMED(controller) * c, const NAMED(frame) * at, int joint,
                                       NAMED(parts) * parts, uint32_t *saturated) {
  const NAMED(joint) *j = &c->joint[joint];
  REAL q = at->angle_rad[joint], v = at->speed_rad_s[joint], slope, inverse, load, sum;
  REAL ratio = NAMED(ratio)(j, q, &slope, &inverse, saturated);

  if (joint == 1)
    parts->inertia_Nm[1] = SAT((WIDE)parts->inertia_Nm[1] +
                               NAMED(rotor)(c, j, ratio, slope, v, at->acceleration[joint], saturated));
  if (j->spring.n)
    parts->effects_Nm[joint] =
        SAT(parts->effects_Nm[joint] +
            MUL(NAMED(curve_at)(&j->spring, q, &slope, saturated), j->spring_scale, 31));
  load = SAT((WIDE)parts->inertia_Nm[joint] + parts->gravity_Nm[joint]);
  parts->friction_Nm[joint] = NAMED(friction)(j, q, v, load, saturated);
  sum = SAT((WIDE)load + parts->friction_Nm[joint] + parts->effects_Nm[joint]);
  return SAT(MUL(SAT(MUL(sum, inverse, 31)), j->inverse_scale, 26));
}

static inline void NAMED(law)(const NAMED(controller) * c, const NAMED(frame) * at, REAL torque[2],
                              NAMED(parts) * parts, uint32_t *saturated) {
  int joint;

  NAMED(rigid_leg)(c, at, parts, saturated);
  for (joint = 0; joint < TL_CONTROLLER_JOINTS; joint++)
    torque[joint] = NAMED(motor_torque)(c, at, joint, parts, saturated);
}

/* ---- frames --------------------------------------------------------------------- */

/* 1 where a number is beyond what the joint can have. Bits instead of && so that every frame takes the same time. */
static inline uint32_t NAMED(is_impossible)(const NAMED(controller) * c, const NAMED(frame) * f) {
  uint32_t excess = 0;
  int joint;

  for (joint = 0; joint < TL_CONTROLLER_JOINTS; joint++) {
    const NAMED(joint) *j = &c->joint[joint];

    excess |= EXCESS_APART(f->angle_rad[joint], j->middle_rad, j->reach_rad);
    excess |= EXCESS(f->speed_rad_s[joint], j->speed_limit_rad_s);
    excess |= EXCESS(f->acceleration[joint], j->acceleration_limit);
  }
  return excess >> 31;
}

/* 1 where the joint cannot have got there since the last frame, `ticks` ago: at most stale_ticks + 1, for which
 * tl_controller_to_q31 has seen that the sums fit. */
static inline uint32_t NAMED(is_far)(const NAMED(controller) * c, const NAMED(frame) * f,
                                     const NAMED(frame) * last, int32_t ticks) {
  uint32_t excess = 0;
  int joint;

  for (joint = 0; joint < TL_CONTROLLER_JOINTS; joint++) {
    const NAMED(joint) *j = &c->joint[joint];

    excess |= EXCESS_APART(f->angle_rad[joint], last->angle_rad[joint],
                           TIMES_TICKS(j->angle_step_rad, ticks, j->angle_slack_rad));
    excess |= EXCESS_APART(f->speed_rad_s[joint], last->speed_rad_s[joint],
                           TIMES_TICKS(j->speed_step_rad_s, ticks, 0));
  }
  return excess >> 31;
}

/* Takes a frame where it is good. Returns 1 then; 2 where it is good only because nothing is driven that could jump. */
static inline int32_t NAMED(take)(const NAMED(controller) * c, const NAMED(frame) * f, NAMED(frame) * last,
                                  int32_t *age, uint32_t idle, uint32_t begun, uint32_t *status) {
  int32_t older = (*age < c->stale_ticks ? *age : c->stale_ticks) + 1;
  uint32_t fresh = (uint32_t)((int32_t)(f->count - last->count) > 0) | (begun ^ 1U);
  uint32_t wrong = NAMED(is_impossible)(c, f), far = NAMED(is_far)(c, f, last, older);
  uint32_t possible = fresh & (wrong ^ 1U), jumps = far & (idle ^ 1U), good = possible & (jumps ^ 1U);
  const NAMED(frame) *from = good ? f : last;
  uint32_t count = fresh ? f->count : last->count;

  *status |= (fresh & wrong) * TL_CONTROLLER_IMPOSSIBLE | (possible & jumps) * TL_CONTROLLER_JUMP;
  /* copied in either case: the same time for both */
  *last = *from;
  last->count = count;
  *age = good ? 0 : older;
  return (int32_t)(good << far);
}

/* a motor that turns moves its angle: the frames in which it did not, while the speed is not small */
static inline int32_t NAMED(count_still)(const NAMED(joint) * j, int32_t still, REAL before, REAL angle,
                                         REAL speed, int32_t good, int32_t most) {
  int32_t stands = (before == angle) & (int32_t)(EXCESS(speed, j->frozen_rad_s) >> 31);
  int32_t more = still < most ? still + 1 : still;

  return good ? (stands ? more : 0) : still;
}

/* Both frames: 1 where both were good and near, 0 where one is still to come, -1 where one was refused or has jumped.
 * Sender and receiver have clocks of their own: a tick without a new frame is no fault until it is stale. */
static inline int32_t NAMED(receive)(const NAMED(controller) * c, NAMED(state) * s, const NAMED(input) * in,
                                     uint32_t *status) {
  int32_t desired, measured, joint, most = c->stale_ticks + 1;
  REAL before[TL_CONTROLLER_JOINTS];
  uint32_t idle = s->level == 0, begun = (uint32_t)s->begun, wrong;

  for (joint = 0; joint < TL_CONTROLLER_JOINTS; joint++) before[joint] = s->measured.angle_rad[joint];
  desired = NAMED(take)(c, &in->desired, &s->desired, &s->desired_age, idle, begun & 1U, status);
  measured = NAMED(take)(c, &in->measured, &s->measured, &s->measured_age, idle, begun >> 1, status);
  for (joint = 0; joint < TL_CONTROLLER_JOINTS; joint++)
    s->still[joint] =
        NAMED(count_still)(&c->joint[joint], s->still[joint], before[joint], s->measured.angle_rad[joint],
                           s->measured.speed_rad_s[joint], measured != 0, most);
  s->begun |= (desired != 0) | (measured != 0) << 1;
  wrong = (*status & (TL_CONTROLLER_IMPOSSIBLE | TL_CONTROLLER_JUMP)) | ((uint32_t)(desired | measured) & 2U);
  return wrong ? -1 : desired & measured;
}

/* How much of the torque is let through: it falls by one of decay_ticks each tick while anything is wrong, and rises
 * again after recover_ticks good frames. */
static inline REAL NAMED(level)(const NAMED(controller) * c, NAMED(state) * s, int32_t enable, int32_t good,
                                uint32_t *status) {
  int32_t more = s->good < c->recover_ticks ? s->good + 1 : s->good, change = 0;
  uint32_t bad = 0;

  if (s->desired_age > c->stale_ticks) bad |= TL_CONTROLLER_STALE_DESIRED;
  if (s->measured_age > c->stale_ticks) bad |= TL_CONTROLLER_STALE_MEASURED;
  if ((s->still[0] > c->stale_ticks) | (s->still[1] > c->stale_ticks)) bad |= TL_CONTROLLER_FROZEN;
  if (!enable) bad |= TL_CONTROLLER_STOPPED;
  more = good ? more : s->good;
  s->good = ((bad != 0) | (good < 0)) ? 0 : more;
  if ((s->good >= c->recover_ticks) & (s->level < c->decay_ticks)) change = 1;
  if (bad) change = -(s->level > 0);
  s->level += change;
  if ((bad != 0) & (s->level > 0)) bad |= TL_CONTROLLER_DECAYING;
  if (s->level == 0) bad |= TL_CONTROLLER_ZERO;
  *status |= bad;
  return s->level < c->decay_ticks ? INSIDE((WIDE)s->level * c->per_level, 0, UNIT_Q30) : UNIT_Q30;
}

/* ---- limits --------------------------------------------------------------------- */

/* the most that the motor may do at this speed: the highest of the lines, not below 0. At low speed it lies above the torque
 * limit, which holds already. In fixed point at most 2 units of Q16 below the lines, never above. */
static inline REAL NAMED(power_limit)(const NAMED(joint) * j, REAL v, uint32_t *saturated) {
  REAL speed = SIZE(v, saturated), most = 0, line;
  int i;

  UNUSED(saturated);
  for (i = 0; i < TL_POWER_LINES; i++) {
    line = POWER_LINE(j->power_Nm[i], j->power_slope[i], speed);
    most = line > most ? line : most;
  }
  return POWER_OF_LINE(most, j->torque_limit_Nm);
}

/* 1 far from the limit that this torque pushes towards, 0 at it and beyond: Q29 times Q22 to Q30 */
static inline REAL NAMED(room)(const NAMED(joint) * j, REAL torque, REAL q) {
  int32_t up = (torque > 0) == (j->side > 0);
  WIDE way = up ? (WIDE)j->high_rad - q : (WIDE)q - j->low_rad;
  REAL left = INSIDE(way, 0, UNIT_Q30); /* 2 rad in Q29: no fade is longer */

  return NAMED(between)(HOLD(MUL(left, j->fade_gain, 21)), 0, UNIT_Q30);
}

/* The torque that goes out: torque limit, room, level, then rate and last power: what was sent a tick ago was within the
 * power of its speed, and power falls slower than the rate for any speed that a frame may bring (tl_controller_prepare
 * sees to that), so both hold. */
static inline REAL NAMED(limited)(const NAMED(joint) * j, REAL torque, REAL before, REAL q, REAL v,
                                  REAL level, uint32_t *status, uint32_t *saturated) {
  REAL held = NAMED(between)(torque, SAT(-(WIDE)j->torque_limit_Nm), j->torque_limit_Nm), fades, asked, rate,
       power, most;

  UNUSED(saturated);
  fades = NAMED(room)(j, held, q);
  /* fades and level are within 1: nothing to hold */
  asked = (REAL)MUL((REAL)MUL(held, fades, 30), level, 30);
  rate = NAMED(between)(asked, SAT((WIDE)before - j->rate_Nm), SAT((WIDE)before + j->rate_Nm));
  most = NAMED(power_limit)(j, v, saturated);
  power = NAMED(between)(rate, -most, most);
  if (held != torque) *status |= TL_CONTROLLER_TORQUE_LIMIT;
  if (fades < UNIT_Q30) *status |= TL_CONTROLLER_JOINT_LIMIT;
  if (rate != asked) *status |= TL_CONTROLLER_RATE_LIMIT;
  if (power != rate) *status |= TL_CONTROLLER_POWER_LIMIT;
  return power;
}

/* The current whose measurement goes with this torque: Q26 times Q20 to Q20. An offset of the measurement fades with the
 * level, so that zero is zero. */
static inline REAL NAMED(current)(const NAMED(joint) * j, REAL torque, REAL level, uint32_t *saturated) {
  WIDE shown = torque;
  REAL slope, hidden;

  UNUSED(saturated);
  if (j->uses & TL_CONTROLLER_USES_OFFSET) shown += MUL(j->offset_Nm, level, 30);
  if (j->droop.n) {
    hidden = NAMED(curve_at)(&j->droop, SIZE(torque, saturated), &slope, saturated);
    shown += MUL(torque < 0 ? SAT(-(WIDE)hidden) : hidden, j->droop_scale, 31);
  }
  return SAT(MUL(SAT(shown), j->amperes_per_Nm, 26));
}

/* ---- a tick --------------------------------------------------------------------- */

static inline void NAMED(tick)(const NAMED(controller) * c, NAMED(state) * s, const NAMED(input) * in,
                               NAMED(output) * out) {
  uint32_t status = 0, saturated = 0;
  int32_t good = NAMED(receive)(c, s, in, &status), joint;
  REAL level = NAMED(level)(c, s, in->enable, good, &status), torque[TL_CONTROLLER_JOINTS];

  NAMED(law)(c, &s->desired, torque, &out->parts, &saturated);
  for (joint = 0; joint < TL_CONTROLLER_JOINTS; joint++) {
    const NAMED(joint) *j = &c->joint[joint];

    s->torque_Nm[joint] = NAMED(limited)(j, torque[joint], s->torque_Nm[joint], s->measured.angle_rad[joint],
                                         s->measured.speed_rad_s[joint], level, &status, &saturated);
    out->torque_Nm[joint] = s->torque_Nm[joint];
    out->current_A[joint] = NAMED(current)(j, s->torque_Nm[joint], level, &saturated);
  }
  out->status = status | saturated * TL_CONTROLLER_SATURATED; /* 0 or 1 of it */
}

static inline void NAMED(start)(const NAMED(state) * zero, NAMED(state) * s) {
  /* stale until a frame comes; the age counts no further than stale_ticks + 1 */
  *s = *zero;
  s->desired_age = s->measured_age = TL_CONTROLLER_MOST_TICKS;
}
