/* twin.h: the bench twin, a plant in forward time as a real bench would record it.
 *
 * The plant follows an excitation under PD position control with held currents;
 * encoders have a resolution, currents noise, samples jitter. One call gives one
 * sample, so that a recording of any length needs the same memory.
 *
 *     tl_twin_settings settings = tl_twin_defaults(&model, &excitation);
 *     tl_twin bench;
 *     if (tl_twin_init(&bench, &model, &excitation, &settings) != TL_OK) return 1;
 *     double row[TL_CHANNEL_COUNT];
 *     while (tl_twin_next(&bench, row) == TL_OK && row[TL_CHANNEL_TIME] < 1.0)
 *       keep(row[TL_CHANNEL_TIME], row[TL_CHANNEL_KNEE_CURRENT]);
 *
 * What the drive commands is a current for leg and pendulum and a force for a slider: where a field
 * says [A], a slider's is in newtons. The leg's drives see their motor's angle, the others the joint.
 */
#ifndef TALUS_TWIN_H
#define TALUS_TWIN_H

#include <stdint.h>

#include "talus/channel.h"
#include "talus/experimental/effect.h"
#include "talus/experimental/excitation.h"
#include "talus/experimental/simulate.h"
#include "talus/plant.h"
#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_TWIN_TICKS 64 /* a current's delay is shorter than so many ticks of the control */

typedef struct tl_twin_settings {
  /* drives */
  double control_hz;               /* of the position control; the current is held between */
  double stiffness[TL_MAX_JOINTS]; /* current for position error [A/rad] */
  double damping[TL_MAX_JOINTS];   /* current for velocity error [A s/rad] */
  double velocity_hz;              /* cut-off of the low-pass on the drive's velocity, first order */
  double current_limit_A[TL_MAX_JOINTS];
  /* sensors */
  double drive_step_rad[TL_MAX_JOINTS];  /* resolution of the encoder that the drive sees; 0: exact */
  double ankle_step_rad;                 /* ... of the leg's absolute encoder at the ankle */
  double current_noise_A[TL_MAX_JOINTS]; /* standard deviation, white */
  double camera_noise_rad;               /* standard deviation, white */
  uint32_t channels;                     /* set of TL_CHANNEL_BIT to record */
  /* time */
  double sample_hz; /* at most control_hz */
  double jitter_s;  /* each instant is off by up to +-this, uniformly; below 0.45 of a sample's step */
  double clock_s;   /* instants are multiples of it; 0: any */
  double settle_s;  /* runs this long before time 0 of the recording */
  double step_s;    /* longest step of integration */
  uint64_t seed;    /* of noise and jitter */
  /* effects of the plant and of its measurements; must outlive the bench. Nullable: effect when effects is 0. */
  const tl_effect *effect;
  int effects;
} tl_twin_settings;

/* A bench for the plant: 1 kHz control with 10 Hz bandwidth and damping 0.8 from the inertia at
 * rest, 250 samples a second with 0.3 ms of jitter on a clock of 1 us, 14 bits a turn on drives and
 * 16 on the ankle (pendulum: 18 bits, slider: 1 um), noise of 20 and 5 mA (others: 0.25 % of the
 * limit), the required channels, seed 1. Series settle for whole periods until the fade has been
 * over for 1 s; ramps settle at rest for 1 s. */
tl_twin_settings tl_twin_defaults(const tl_model *m, const tl_excitation *e);

/* What this bench can do: +-1.0 rad at the knee, +-0.5 rad at the ankle, no end for others; 8 rad/s and
 * 100 rad/s^2 (slider: 2 m/s, 20 m/s^2); torque by the current limits. */
void tl_twin_limits(const tl_model *m, const tl_twin_settings *s, tl_limits limits[TL_MAX_JOINTS]);

/* Plain data, except that model and excitation must outlive it. */
typedef struct tl_twin {
  const tl_model *model;
  const tl_excitation *excitation;
  tl_twin_settings settings;
  tl_simulation simulation;     /* the truth at the last sample; its t_s counts from the start of settling */
  double torque[TL_MAX_JOINTS]; /* that acts now, as tl_forward takes it */
  double current_A[TL_MAX_JOINTS]; /* commanded */
  double position[TL_MAX_JOINTS];  /* that the drive saw last */
  double velocity[TL_MAX_JOINTS];  /* low-passed */
  uint64_t tick, sample;           /* the next ones */
  /* with effects: what they change, the plant as it really is, and the currents of the last ticks */
  tl_effect_change change[TL_MAX_JOINTS];
  tl_model truth;
  double shown_A[TL_MAX_JOINTS][TL_TWIN_TICKS];
} tl_twin;

/* At rest where the excitation begins. TL_ERR_RANGE for settings out of range,
 * TL_ERR_UNSUPPORTED for a channel that the bench does not record: the leg's are its required
 * ones and the camera's, the pendulum's joint_rad, joint_current_A and joint_torque_Nm, the
 * slider's all three; or for an effect that only a sensor at the output would show. Others as
 * tl_effect_check (TL_ERR_RANGE also for a linkage that its error does not let close, and a delay
 * beyond TL_TWIN_TICKS) and tl_simulation_init. */
TL_CHECK tl_status tl_twin_init(tl_twin *b, const tl_model *m, const tl_excitation *e,
                                const tl_twin_settings *s);
/* The next sample: row[channel] for the channels of the settings, NaN elsewhere. The bench never
 * ends; errors as tl_simulate. */
TL_CHECK tl_status tl_twin_next(tl_twin *b, double row[TL_CHANNEL_COUNT]);
/* What the bench was to do at its last sample (before the first: where it begins). */
void tl_twin_reference(const tl_twin *b, tl_motion *reference);

#ifdef __cplusplus
}
#endif
#endif
