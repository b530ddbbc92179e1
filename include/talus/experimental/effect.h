/* effect.h: effects that the plain model does not know, one interface for all of them.
 *
 * An effect adds to the torque of a joint a sum over its strengths: column k times strength k. The
 * columns depend on the motion, and on a few shape parameters that do not enter linearly. One law
 * serves fitting (its columns), prediction (its sum) and simulation (its torque, and the level of
 * friction it adds, so that a joint can stick on it).
 *
 *     const tl_effect_kind *kind = tl_effect_find("stribeck");
 *     tl_effect e = tl_effect_typical(kind, 1);        // at the ankle
 *     tl_effect_instant instant;
 *     tl_effect_instant_of(&model, &motion, 1, t_s, NULL, &instant);
 *     double torque_Nm, friction_Nm;
 *     tl_effect_law(&e, &instant, &torque_Nm, &friction_Nm);
 *     double joint_Nm = torque_Nm + friction_Nm * instant.slip;
 *
 * The table of effects (tl_effect_table) is the only list of them: model files, reports,
 * simulation and documentation read it. docs/effects.md shows how one is added.
 */
#ifndef TALUS_EFFECT_H
#define TALUS_EFFECT_H

#include <stddef.h>

#include "talus/kinematics.h"
#include "talus/plant.h"
#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_EFFECT_MAX_STRENGTHS 6
#define TL_EFFECT_MAX_SHAPES 8
#define TL_EFFECT_MAX_PARAMETERS (TL_EFFECT_MAX_STRENGTHS + TL_EFFECT_MAX_SHAPES)

/* What a law may depend on: one joint at one instant. */
typedef struct tl_effect_instant {
  double q, v;            /* the joint's angle and speed [rad], [rad/s]; slider [m], [m/s] */
  double slip;            /* direction of friction, [-1, 1] */
  double load_Nm;         /* torque that the joint delivers to inertia and gravity, without friction */
  double rotor_Nm;        /* of it: what the rotor's inertia takes, or the joint's own that holds it */
  double friction_Nm;     /* the plain model's friction */
  double offset_Nm;       /* its constant torque */
  double motor_Nm;        /* motor torque: what the plain model asks for, and the mechanical effects */
  double motor_rad;       /* motor angle */
  double ratio;           /* d motor / d joint */
  double effort_Nm;       /* the drive's recorded torque where a sensor at the output was recorded, else 0 */
  double gravity_tilt_Nm; /* change of gravity's torque at this joint per rad of tilt of the base */
  double t_s;             /* time since the first recording's begin */
  double temp_C;          /* of the drive, smoothed; 0 where it was not recorded */
} tl_effect_instant;

/* A strength or a shape of an effect. */
typedef struct tl_effect_parameter {
  const char *name; /* with its unit: "speed_rad_s" */
  double low, high; /* physical range */
  double typical;
  int flags;            /* set of TL_PARAMETER_... */
  double default_value; /* of an optional parameter that a model file does not name */
} tl_effect_parameter;

enum {
  TL_PARAMETER_OPTIONAL = 1, /* a model file may leave it out */
  TL_PARAMETER_FIT_ONLY =
      2, /* shows in recordings; forward time knows no other value than the default, docs/effects.md says why */
  TL_PARAMETER_NEEDS_TEMPERATURE = 4 /* other than 0 it needs the drive's temperature */
};

/* Where an effect can stand. */
enum {
  TL_EFFECT_AT_KNEE = TL_PLACE_KNEE,
  TL_EFFECT_AT_ANKLE = TL_PLACE_ANKLE,
  TL_EFFECT_AT_SINGLE = TL_PLACE_SINGLE,
  TL_EFFECT_AT_BASE = TL_PLACE_BASE
};

/* How it acts. */
enum {
  TL_EFFECT_MECHANICAL = 0, /* on the joint: the motion feels it */
  TL_EFFECT_MEASURED = 1,   /* on what the current shows: the motion does not feel it */
  TL_EFFECT_CHANGE = 2 /* no law of the instant: it changes the plant or its sensors (tl_effect_change) */
};

#define TL_EFFECT_WAVES 4 /* of one sort at a joint */
#define TL_MOUNT_MODES 4

/* Waves in an angle: sum of sine_rad sin(per_turn x) + cosine_rad cos(per_turn x). */
typedef struct tl_effect_waves {
  int n; /* more than TL_EFFECT_WAVES: so many were asked for, and the last are left out */
  double per_turn[TL_EFFECT_WAVES], sine_rad[TL_EFFECT_WAVES], cosine_rad[TL_EFFECT_WAVES];
} tl_effect_waves;

/* How a mount gives way: it turns [rad/Nm], or sways to the front or rises [m/N]. */
typedef enum tl_mount_mode { TL_MOUNT_TURNS = 0, TL_MOUNT_SWAYS = 1, TL_MOUNT_RISES = 2 } tl_mount_mode;

/* One mode of the mount: its resonance with the leg at rest, and its damping ratio there. */
typedef struct tl_effect_mount {
  tl_mount_mode mode;
  double compliance, frequency_Hz, damping_ratio;
} tl_effect_mount;

/* What the effects of one joint change in its plant and sensors, for simulation. Zero: nothing. */
typedef struct tl_effect_change {
  double delay_s;                   /* the current is later than the angles */
  double telemetry_delay_s;         /* current and angles are later than a sensor at the output */
  double torque_constant_error;     /* the drive delivers 1 + this of what its constant says */
  tl_effect_waves motor_encoder;    /* added to the motor's encoder, by its angle */
  tl_effect_waves joint_encoder;    /* added to the joint's, by the joint's angle */
  tl_effect_waves ripple;           /* by which the joint runs ahead of its motor, by the motor's angle */
  double AB_m, BO_m, AC_m, BOF_rad; /* added to the linkage's dimensions */
  double memory_Nm, travel_rad, memory_power; /* friction that is a spring over a small travel */
  double compliance_rad_Nm, damping_s; /* between motor and joint; more than 0 where they are not rigid */
  double gap_rad, soft_rad, soft_loss, hardening_Nm_rad3; /* tl_spring's; 1 less its soft share */
  double motor_share;    /* where they are not rigid: of the joint's own inertia, what turns with the motor */
  double friction_share; /* of its dry friction, what stands on the link's side */
  double viscous_share;  /* of its viscous friction */
  double offset_share;   /* of its constant torque */
  double drag_Nm;        /* dry friction between motor and link */
  int mount_modes;       /* of the base; more than TL_MOUNT_MODES: the last are left out */
  tl_effect_mount mount[TL_MOUNT_MODES];
} tl_effect_change;

/* What a recording shows that an effect can change: the torque of joint 0 or 1, and where a second
 * sensor sees the same angle, that sensor less the motor's angle through the model's transmission. */
enum {
  TL_EFFECT_SHOWS_ENCODER = 2, /* the ankle's encoder less the motor's angle [rad] */
  TL_EFFECT_SHOWS_SHANK = 3,   /* the camera's shank angle less the knee motor's [rad] */
  TL_EFFECT_SHOWS_FOOT = 4     /* the camera's foot less shank angle, less the ankle motor's [rad] */
};
#define TL_EFFECT_CHANNELS 5

/* A segment of recorded motion, without a gap: arrays of n rows, as the motors' angles tell it. */
typedef struct tl_effect_segment {
  const tl_model *model;
  size_t n;
  const double *t_s; /* as its stops have it */
  const double *q[TL_MAX_JOINTS], *v[TL_MAX_JOINTS], *a[TL_MAX_JOINTS], *slip[TL_MAX_JOINTS];
  const double *effort_Nm; /* the drive's torque where a sensor at the output was recorded. Nullable. */
  const tl_stop *stop[TL_MAX_JOINTS]; /* of each joint, rows as here */
  size_t stops[TL_MAX_JOINTS];
  const tl_window *window[TL_MAX_JOINTS]; /* that v and a come from; NULL: no matter how. Nullable. */
  double link_inertia_kg_m2
      [TL_MAX_JOINTS]; /* at the joint, leg straight, that a link beyond its transmission swings
                                             * with; 0: the model's */
} tl_effect_segment;

/* What the columns of a segment share, whatever their shapes; each part is made when it is first asked for. */
typedef struct tl_effect_prepared {
  const tl_effect_segment *segment; /* must outlive this */
  tl_model bare;                    /* the segment's model without friction, rotors and transmissions */
  unsigned ready;                   /* which parts are made */
  double *load_Nm[TL_MAX_JOINTS];   /* bare inverse dynamics */
  double *motor_Nm[TL_MAX_JOINTS];  /* the plain model's torque as tl_inverse has it, through short stops */
  double *ratio[TL_MAX_JOINTS];     /* that torque's at the joint, over it */
  double *slope[TL_MAX_JOINTS][TL_MAX_JOINTS]
               [3]; /* of the bare torque of the first by q, v and a of the second */
  double *mount[6]; /* forces and lever arms on the base, of a leg */
  double *work;
} tl_effect_prepared;

/* Columns that are asked for, and where they go. */
typedef struct tl_effect_wanted {
  unsigned strengths;                /* set of 1 << k; columns of others are not written */
  double *shown[TL_EFFECT_CHANNELS]; /* by channel: column k at shown + k n. NULL: not asked for. */
} tl_effect_wanted;

/* The form in which a controller's tick takes an effect (controller_prepare.h): a curve that is sampled from its law, or
 * numbers that stand before what a tick has at hand. */
typedef enum tl_effect_fast {
  TL_FAST_NONE = 0, /* none: it has a memory, a delay, a temperature or a ripple of the motor's turn */
  TL_FAST_SPEED,    /* friction over |speed| */
  TL_FAST_SPRING,   /* torque over the angle */
  TL_FAST_POSITION, /* level of friction over the angle */
  TL_FAST_DROOP,    /* what the current shows more, over the motor's torque */
  TL_FAST_NUMBERS,  /* see tl_effect_numbers */
  TL_FAST_DRIVE     /* it changes the linkage, which is a table in any case */
} tl_effect_fast;

typedef struct tl_effect_numbers {
  double asymmetry_Nm, asymmetry_Nms_rad; /* half the difference of friction between the directions */
  double driving, back_driving;           /* shares of the load that are friction */
  double offset_Nm;                       /* of the motor's torque as the current shows it */
  double tilt_rad;                        /* of gravity */
} tl_effect_numbers;

struct tl_effect;
typedef struct tl_flexible_joint tl_flexible_joint; /* the library's own */

typedef struct tl_effect_kind {
  const char *name;    /* id of the catalogue */
  int order;           /* place in the table and in reports, counted from 1; 0: after all others, by name */
  const char *meaning; /* one line */
  int places;          /* set of TL_EFFECT_AT_... */
  int acts;
  int dry;         /* 1: adds friction that can hold a joint at rest */
  int once;        /* 1: a joint has one of it: two have no sum, as memory and bodies are the joint's own */
  int rotor_share; /* number of the parameter that says how much of the rotor's inertia is load; 0: none does */
  int needs_load_sensor; /* 1: only where a sensor at the output was recorded */
  int strengths, shapes;
  tl_effect_parameter parameter[TL_EFFECT_MAX_PARAMETERS]; /* strengths first, then shapes */
  /* Per unit of each strength: torque at the joint [N m], and friction in the direction of slip. */
  void (*law)(const tl_effect_instant *now, const double *shape, double *torque, double *friction);
  /* Kinds that change the plant or its sensors have these two in its place: what they change, and to
   * first order what a recording then shows per unit of each strength, of an effect at `joint`: the columns that
   * are wanted, which hold 0 before. A kind with both a law and `columns` has the strengths of one at 0 in
   * the other. */
  void (*change)(const double *value, tl_effect_change *to);
  void (*columns)(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted);
  /* Of a kind whose first strength is a link's behind a spring: that link; its `columns` then leaves this one out. */
  void (*link)(const double *shape, tl_flexible_joint *to);
  double memory_s; /* how far back its columns look */
  tl_effect_fast fast;
  int bends_below; /* of TL_FAST_SPEED: number of the parameter whose speed its law bends about; 0: none */
  /* Of TL_FAST_NUMBERS, into zeros. TL_ERR_UNSUPPORTED where its shapes have no such form. */
  tl_status (*numbers)(const struct tl_effect *e, tl_effect_numbers *to);
  int bridged; /* 1: its columns of torques have been taken through short stops already */
  int exact;   /* 1: prediction makes the change itself (time, linkage) instead of adding columns */
} tl_effect_kind;

/* One effect of a model: kind, joint (0 or 1; TL_MAX_JOINTS for the base) and parameters. */
typedef struct tl_effect {
  const tl_effect_kind *kind;
  int joint;
  double value[TL_EFFECT_MAX_PARAMETERS];
} tl_effect;

/* All kinds, n of them. */
const tl_effect_kind *const *tl_effect_table(int *n);
/* The kind of that id; NULL if there is none. */
const tl_effect_kind *tl_effect_find(const char *name);
/* Can this kind stand at this joint of this plant (joint TL_MAX_JOINTS: the base)? */
int tl_effect_applies(const tl_effect_kind *kind, const tl_model *m, int joint);
/* An effect with its typical parameters. */
tl_effect tl_effect_typical(const tl_effect_kind *kind, int joint);
/* Does the parameter say something? Not if it may be left out and has the value that it then has. */
int tl_effect_says(const tl_effect *e, int parameter);
/* Number of a parameter by which the effect cannot act in forward time; -1 where it can. */
int tl_effect_fit_only(const tl_effect *e);
/* Does it need the drive's temperature? */
int tl_effect_needs_temperature(const tl_effect *e);
/* TL_ERR_RANGE when a parameter leaves its range; TL_ERR_UNSUPPORTED where the kind cannot stand;
 * TL_ERR_RANGE or TL_ERR_UNSUPPORTED for a linkage error that the linkage does not take. */
TL_CHECK tl_status tl_effect_check(const tl_effect *e, const tl_model *m);

/* Does entry k repeat an earlier one at its joint though its kind stands there once? */
int tl_effect_repeats(const tl_effect *effect, int k);
/* n effects together: tl_effect_check of each; TL_ERR_UNSUPPORTED where tl_effect_repeats. */
TL_CHECK tl_status tl_effects_check(const tl_effect *effect, int n, const tl_model *m);

/* The part of an instant that needs no load: angle, speed, slip, motor side, time. The rest is 0. */
void tl_effect_place_of(const tl_model *m, const tl_motion *motion, int joint, double t_s,
                        tl_effect_instant *now);
/* Change of gravity's torque at a joint per rad of tilt of the base [N m/rad]. */
double tl_effect_tilt_of(const tl_model *m, const tl_motion *motion, int joint);
/* Does the effect act at this joint? Those at the base act at every joint. */
int tl_effect_at(const tl_effect *e, int joint);
/* The instant of one joint from the plain model: load, motor torque, tilt and the rest. effort_Nm is the
 * drive's recorded torque at the joint where a sensor at the output was recorded: it then is the
 * load the gear carries. Nullable: effort_Nm. */
void tl_effect_instant_of(const tl_model *m, const tl_motion *motion, int joint, double t_s,
                          const double *effort_Nm, tl_effect_instant *now);
/* The effect's torque at the joint, and the friction it adds in the direction of slip. */
void tl_effect_law(const tl_effect *e, const tl_effect_instant *now, double *torque, double *friction);
/* The effect's columns: torque at the joint per unit of each strength, column[kind->strengths]. */
void tl_effect_columns(const tl_effect_kind *kind, const double *shape, const tl_effect_instant *now,
                       double *column);
/* The same at n instants: column k at column + k n. */
void tl_effect_columns_at(const tl_effect_kind *kind, const double *shape, const tl_effect_instant *now,
                          size_t n, double *column);
/* The instants of a joint over a segment, now[s->n]: what its laws depend on. temp_C is 0. */
void tl_effect_instants(const tl_effect_segment *s, int joint, tl_effect_instant *now);

/* Doubles that the columns of a segment of n rows need. */
size_t tl_effect_prepared_memory(int joints, size_t n);
/* Ready for the segment's columns; *s and memory must outlive p. */
void tl_effect_prepare(tl_effect_prepared *p, const tl_effect_segment *s, double *memory);
/* Undamped frequency [rad/s] of a link on a spring beyond its transmission, where so much of the joint's own inertia turns
 * with its motor. */
double tl_effect_link_rad_s(const tl_effect_prepared *p, int joint, double motor_share,
                            double stiffness_Nm_rad);
/* Columns over a segment of `shapes` shapes of one kind without a law of the instant (a law's are tl_effect_columns_at's),
 * of an effect at `joint` (TL_MAX_JOINTS: the base): those of shape i from shape + i kind->shapes, i kind->strengths n
 * further on in each channel. Torques are those of the joint, as in tl_effect_columns, angles in rad; first order. */
void tl_effect_segment_columns(const tl_effect_kind *kind, int joint, const double *shape, size_t shapes,
                               tl_effect_prepared *p, const tl_effect_wanted *wanted);
/* The same over several segments, each to its own `wanted`. Links behind a spring are stepped several at once where there is
 * room: `lanes` times tl_effect_link_memory of the longest segment at `work`. */
size_t tl_effect_link_memory(size_t n);
void tl_effect_segments_columns(const tl_effect_kind *kind, int joint, const double *shape, size_t shapes,
                                tl_effect_prepared *const *p, const tl_effect_wanted *wanted, size_t segments,
                                double *work, int lanes);
/* Adds a wave or a mode, if its size is not 0; past the last place it is counted alone. */
void tl_effect_add_wave(tl_effect_waves *to, double per_turn, double sine_rad, double cosine_rad);
void tl_effect_add_mount(tl_effect_change *to, tl_mount_mode mode, double compliance, double frequency_Hz,
                         double damping_ratio);
/* The waves at an angle x: their sum, and its first and second derivative by x. */
void tl_effect_waves_at(const tl_effect_waves *waves, double x, double wave[3]);
/* The plain model without friction and offset, each torque that of its joint, and without the ankle's rotor: what hangs
 * beyond a transmission that is not rigid. */
tl_model tl_effect_bare_model(const tl_model *m);
/* A transmission with the change's linkage dimensions. TL_ERR_UNSUPPORTED where there is no linkage, but
 * for a change without any. Errors of tl_transmission_screw_linkage. */
TL_CHECK tl_status tl_effect_change_linkage(const tl_effect_change *c, const tl_transmission *t,
                                            tl_transmission *changed);
/* Everything that n effects change at a joint (TL_MAX_JOINTS: at the base). */
tl_effect_change tl_effects_change(const tl_effect *effect, int n, int joint);
/* What n effects add to the recorded torque of a joint (leg: motor torque, so over the ratio). Kinds
 * without a law of the instant are left out: they are tl_effects_segment_torque's. temp_C: of the drive, where a heated
 * effect needs it. Nullable: effort_Nm. */
double tl_effects_torque(const tl_effect *effect, int n, const tl_model *m, const tl_motion *motion,
                         int joint, double t_s, double temp_C, const double *effort_Nm);

/* What the others add to the recorded torque of a joint over a segment, added to sum[n]; `column` holds
 * TL_EFFECT_MAX_STRENGTHS n doubles. */
void tl_effects_segment_torque(const tl_effect *effect, int n, tl_effect_prepared *p, int joint,
                               double *column, double *sum);

#ifdef __cplusplus
}
#endif
#endif
