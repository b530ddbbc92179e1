/* leg_bus.h: the leg's bus (models/leg.dbc) in angles, currents and torques.
 *
 * leg_dbc.h, made from the DBC by cantools, packs and unpacks raw values; this turns
 * them into the model's quantities. Where fields lie and what a count of current or temperature
 * is worth is said by the DBC; counts per turn, signs and the count at joint angle 0 by the
 * model file's `bus:`.
 *
 *     struct leg_bus_frame frame;
 *     leg_bus_command(&frame, 0, counter, q_rad, v_rad_s, 0.0);       // a set-point for the knee
 *
 *     struct leg_bus_encoder knee;
 *     struct leg_bus_state state;
 *     leg_bus_encoder_init(&knee, &file.model, &file.bus, 0);
 *     ... leg_bus_unpack_state(&frame, &joint, &state) == 0 && joint == 0 ...
 *     leg_bus_encoder_take(&knee, &state);
 *     // knee.motor_rad (0 at joint angle 0), knee.joint_rad
 */
#ifndef LEG_BUS_H
#define LEG_BUS_H

#include <stdint.h>

#include "model/model_file.h"
#include "talus/plant.h"

/* A classic CAN frame with an identifier of 11 bits. */
struct leg_bus_frame {
  uint32_t id;
  uint8_t length;
  uint8_t data[8];
};

enum leg_bus_mode { LEG_BUS_OFF = 0, LEG_BUS_HOLD = 1, LEG_BUS_FOLLOW = 2, LEG_BUS_STOPPED = 3 };

/* ---- what the host sends ------------------------------------------------------------- */

/* A set-point: joint angle [rad], speed [rad/s] and motor torque [Nm] to be added. 0, or -1 when the
 * joint is none of the leg's or a value does not fit into its field: nothing is rounded to a limit. */
int leg_bus_command(struct leg_bus_frame *frame, int joint, uint16_t counter, double q_rad, double v_rad_s,
                    double torque_Nm);
/* Both drives let go. Reasons are the DBC's: 1 emergency stop, 2 limit broken, 3 recording failed, 4 operator. */
void leg_bus_stop(struct leg_bus_frame *frame, uint16_t counter, uint8_t reason, uint8_t source);
/* Every 10 ms. mode: off, hold or follow. */
void leg_bus_host_heartbeat(struct leg_bus_frame *frame, uint16_t counter, enum leg_bus_mode mode);

/* ---- what the bench sends ------------------------------------------------------------ */

/* What a drive measured, as it counts it; the current in the drive's own sign. */
struct leg_bus_state {
  uint16_t counter, motor_count, joint_count;
  double current_A;
};

void leg_bus_pack_state(struct leg_bus_frame *frame, int joint, const struct leg_bus_state *state);
/* 0 and the joint, or -1 when the frame is no state, or shorter than the DBC says. */
int leg_bus_unpack_state(const struct leg_bus_frame *frame, int *joint, struct leg_bus_state *state);

struct leg_bus_status {
  uint16_t counter;
  double motor_C, drive_C;
  enum leg_bus_mode state;
  uint8_t faults;
};

void leg_bus_pack_status(struct leg_bus_frame *frame, int joint, const struct leg_bus_status *status);
void leg_bus_pack_supply(struct leg_bus_frame *frame, uint16_t counter, double bus_V, double bus_A);
void leg_bus_pack_heartbeat(struct leg_bus_frame *frame, uint16_t counter, unsigned long late,
                            unsigned long missed, double uptime_s);

/* A set-point as the bench receives it. */
struct leg_bus_setpoint {
  uint16_t counter;
  double q_rad, v_rad_s, torque_Nm;
};

/* 0 and the joint, or -1 as above. */
int leg_bus_unpack_command(const struct leg_bus_frame *frame, int *joint, struct leg_bus_setpoint *setpoint);
/* 1 for a whole stop frame. */
int leg_bus_is_stop(const struct leg_bus_frame *frame);
/* 0 and the mode, or -1 when the frame is no heartbeat of the host. */
int leg_bus_unpack_host_heartbeat(const struct leg_bus_frame *frame, enum leg_bus_mode *mode);

#define LEG_BUS_LISTENED 3
/* Identifiers that a controller listens to: the stop and both states. */
extern const uint32_t leg_bus_listened[LEG_BUS_LISTENED];

/* ---- counts and angles ----------------------------------------------------------------- */

/* An absolute count, and back: 0 at joint angle 0, within half a turn of it. */
double leg_bus_joint_rad(const struct model_bus_joint *bus, uint16_t count);
uint16_t leg_bus_joint_count(const struct model_bus_joint *bus, double q_rad);
/* A relative count for a motor angle that was 0 at `zero` counts; it wraps. */
uint16_t leg_bus_motor_count(const struct model_bus_joint *bus, double motor_rad, double zero_count);

/* A joint's two encoders over time. The relative one is unrolled across its wraps: between two
 * states the motor turns less than half of what the counter holds (two turns at 16,384 counts). It is
 * zeroed from the absolute one by the mean, over all states so far in which the motor had moved, of where
 * the joint's angle and the transmission say that it should be. */
struct leg_bus_encoder {
  const tl_model *model;
  struct model_bus_joint bus;
  int joint;
  unsigned long places; /* states so far in which the motor had moved, and the first */
  uint16_t last_count;
  int64_t counts;   /* unrolled, from the first state's */
  double zero_rad;  /* of the motor at joint angle 0, on the scale of `counts` */
  double motor_rad; /* of the last state: 0 at joint angle 0 */
  double joint_rad; /* of the absolute encoder */
};

/* The model must outlive it. */
void leg_bus_encoder_init(struct leg_bus_encoder *e, const tl_model *m, const struct model_bus *bus,
                          int joint);
void leg_bus_encoder_take(struct leg_bus_encoder *e, const struct leg_bus_state *state);
/* The current in the model's sign. */
double leg_bus_current_A(const struct model_bus_joint *bus, double drive_A);

#endif
