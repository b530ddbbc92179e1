/* leg_bus.c: see leg_bus.h. */
#include "leg_bus.h"

#include <math.h>
#include <string.h>

#include "leg_bus/generated/leg_dbc.h"
#include "talus/transmission.h"

#define FOR_JOINT(joint, knee, ankle) ((joint) == 0 ? (knee) : (ankle))

static const double two_pi = 6.283185307179586;

static struct leg_bus_frame empty(uint32_t id, uint8_t length) {
  struct leg_bus_frame frame = {.id = id, .length = length};
  return frame;
}

/* is it this message, and whole? */
static int is(const struct leg_bus_frame *frame, uint32_t id, uint8_t length) {
  return frame->id == id && frame->length >= length && frame->length <= sizeof frame->data;
}

/* The layouts of knee and ankle are the same in the DBC (tests/test_bus.py), so one is packed for both. */
static int joint_of(const struct leg_bus_frame *frame, uint32_t knee_id, uint32_t ankle_id, uint8_t length,
                    int *joint) {
  if (is(frame, knee_id, length))
    *joint = 0;
  else if (is(frame, ankle_id, length))
    *joint = 1;
  else
    return -1;
  return 0;
}

/* x, kept within a field's range: for what is shown, never for what is commanded */
static double within(double x, double low, double high) {
  return x < low ? low : x > high ? high : x;
}

/* ---- what the host sends ------------------------------------------------------------- */

int leg_bus_command(struct leg_bus_frame *frame, int joint, uint16_t counter, double q_rad, double v_rad_s,
                    double torque_Nm) {
  struct leg_dbc_knee_command_t message;

  if (joint < 0 || joint >= TL_MAX_JOINTS) return -1;
  if (!leg_dbc_knee_command_position_is_in_phys_range(q_rad) ||
      !leg_dbc_knee_command_velocity_is_in_phys_range(v_rad_s) ||
      !leg_dbc_knee_command_torque_feedforward_is_in_phys_range(torque_Nm))
    return -1;
  message.counter = counter;
  message.position = leg_dbc_knee_command_position_encode(q_rad);
  message.velocity = leg_dbc_knee_command_velocity_encode(v_rad_s);
  message.torque_feedforward = leg_dbc_knee_command_torque_feedforward_encode(torque_Nm);
  *frame = empty(FOR_JOINT(joint, LEG_DBC_KNEE_COMMAND_FRAME_ID, LEG_DBC_ANKLE_COMMAND_FRAME_ID),
                 LEG_DBC_KNEE_COMMAND_LENGTH);
  leg_dbc_knee_command_pack(frame->data, &message, sizeof frame->data);
  return 0;
}

void leg_bus_stop(struct leg_bus_frame *frame, uint16_t counter, uint8_t reason, uint8_t source) {
  const struct leg_dbc_stop_t message = {.counter = counter, .reason = reason, .source = source};

  *frame = empty(LEG_DBC_STOP_FRAME_ID, LEG_DBC_STOP_LENGTH);
  leg_dbc_stop_pack(frame->data, &message, sizeof frame->data);
}

void leg_bus_host_heartbeat(struct leg_bus_frame *frame, uint16_t counter, enum leg_bus_mode mode) {
  const struct leg_dbc_host_heartbeat_t message = {.counter = counter, .mode = (uint8_t)mode};

  *frame = empty(LEG_DBC_HOST_HEARTBEAT_FRAME_ID, LEG_DBC_HOST_HEARTBEAT_LENGTH);
  leg_dbc_host_heartbeat_pack(frame->data, &message, sizeof frame->data);
}

/* ---- what the bench sends ------------------------------------------------------------ */

void leg_bus_pack_state(struct leg_bus_frame *frame, int joint, const struct leg_bus_state *state) {
  const double most = leg_dbc_knee_state_current_decode(INT16_MAX);
  const struct leg_dbc_knee_state_t message = {
      .counter = state->counter,
      .motor_count = state->motor_count,
      .joint_count = state->joint_count,
      .current = leg_dbc_knee_state_current_encode(within(state->current_A, -most, most))};

  *frame = empty(FOR_JOINT(joint, LEG_DBC_KNEE_STATE_FRAME_ID, LEG_DBC_ANKLE_STATE_FRAME_ID),
                 LEG_DBC_KNEE_STATE_LENGTH);
  leg_dbc_knee_state_pack(frame->data, &message, sizeof frame->data);
}

int leg_bus_unpack_state(const struct leg_bus_frame *frame, int *joint, struct leg_bus_state *state) {
  struct leg_dbc_knee_state_t message;

  if (joint_of(frame, LEG_DBC_KNEE_STATE_FRAME_ID, LEG_DBC_ANKLE_STATE_FRAME_ID, LEG_DBC_KNEE_STATE_LENGTH,
               joint) != 0)
    return -1;
  leg_dbc_knee_state_unpack(&message, frame->data, sizeof frame->data);
  state->counter = message.counter;
  state->motor_count = message.motor_count;
  state->joint_count = message.joint_count;
  state->current_A = leg_dbc_knee_state_current_decode(message.current);
  return 0;
}

void leg_bus_pack_status(struct leg_bus_frame *frame, int joint, const struct leg_bus_status *status) {
  const double most = leg_dbc_knee_status_motor_temperature_decode(INT16_MAX);
  const struct leg_dbc_knee_status_t message = {
      .counter = status->counter,
      .motor_temperature = leg_dbc_knee_status_motor_temperature_encode(within(status->motor_C, -most, most)),
      .drive_temperature = leg_dbc_knee_status_drive_temperature_encode(within(status->drive_C, -most, most)),
      .state = (uint8_t)status->state,
      .faults = status->faults};

  *frame = empty(FOR_JOINT(joint, LEG_DBC_KNEE_STATUS_FRAME_ID, LEG_DBC_ANKLE_STATUS_FRAME_ID),
                 LEG_DBC_KNEE_STATUS_LENGTH);
  leg_dbc_knee_status_pack(frame->data, &message, sizeof frame->data);
}

void leg_bus_pack_supply(struct leg_bus_frame *frame, uint16_t counter, double bus_V, double bus_A) {
  const double most_V = leg_dbc_supply_bus_voltage_decode(UINT16_MAX);
  const double most_A = leg_dbc_supply_bus_current_decode(INT16_MAX);
  const struct leg_dbc_supply_t message = {
      .counter = counter,
      .bus_voltage = leg_dbc_supply_bus_voltage_encode(within(bus_V, 0.0, most_V)),
      .bus_current = leg_dbc_supply_bus_current_encode(within(bus_A, -most_A, most_A))};

  *frame = empty(LEG_DBC_SUPPLY_FRAME_ID, LEG_DBC_SUPPLY_LENGTH);
  leg_dbc_supply_pack(frame->data, &message, sizeof frame->data);
}

void leg_bus_pack_heartbeat(struct leg_bus_frame *frame, uint16_t counter, unsigned long late,
                            unsigned long missed, double uptime_s) {
  const struct leg_dbc_bench_heartbeat_t message = {
      .counter = counter,
      .late_ticks = late < UINT16_MAX ? (uint16_t)late : UINT16_MAX,
      .missed_commands = missed < UINT16_MAX ? (uint16_t)missed : UINT16_MAX,
      .uptime = leg_dbc_bench_heartbeat_uptime_encode(floor(within(uptime_s, 0.0, UINT16_MAX)))};

  *frame = empty(LEG_DBC_BENCH_HEARTBEAT_FRAME_ID, LEG_DBC_BENCH_HEARTBEAT_LENGTH);
  leg_dbc_bench_heartbeat_pack(frame->data, &message, sizeof frame->data);
}

int leg_bus_unpack_command(const struct leg_bus_frame *frame, int *joint, struct leg_bus_setpoint *setpoint) {
  struct leg_dbc_knee_command_t message;

  if (joint_of(frame, LEG_DBC_KNEE_COMMAND_FRAME_ID, LEG_DBC_ANKLE_COMMAND_FRAME_ID,
               LEG_DBC_KNEE_COMMAND_LENGTH, joint) != 0)
    return -1;
  leg_dbc_knee_command_unpack(&message, frame->data, sizeof frame->data);
  setpoint->counter = message.counter;
  setpoint->q_rad = leg_dbc_knee_command_position_decode(message.position);
  setpoint->v_rad_s = leg_dbc_knee_command_velocity_decode(message.velocity);
  setpoint->torque_Nm = leg_dbc_knee_command_torque_feedforward_decode(message.torque_feedforward);
  return 0;
}

int leg_bus_is_stop(const struct leg_bus_frame *frame) {
  return is(frame, LEG_DBC_STOP_FRAME_ID, LEG_DBC_STOP_LENGTH);
}

int leg_bus_unpack_host_heartbeat(const struct leg_bus_frame *frame, enum leg_bus_mode *mode) {
  struct leg_dbc_host_heartbeat_t message;

  if (!is(frame, LEG_DBC_HOST_HEARTBEAT_FRAME_ID, LEG_DBC_HOST_HEARTBEAT_LENGTH)) return -1;
  leg_dbc_host_heartbeat_unpack(&message, frame->data, sizeof frame->data);
  if (!leg_dbc_host_heartbeat_mode_is_in_range(message.mode)) return -1;
  *mode = (enum leg_bus_mode)message.mode;
  return 0;
}

const uint32_t leg_bus_listened[LEG_BUS_LISTENED] = {LEG_DBC_STOP_FRAME_ID, LEG_DBC_KNEE_STATE_FRAME_ID,
                                                     LEG_DBC_ANKLE_STATE_FRAME_ID};

/* ---- counts and angles ----------------------------------------------------------------- */

/* x less the whole turns of `turn` that bring it nearest to 0 */
static double within_half(double x, double turn) {
  return x - turn * floor(x / turn + 0.5);
}

double leg_bus_joint_rad(const struct model_bus_joint *bus, uint16_t count) {
  const double turn = bus->joint_counts_per_turn;

  return bus->joint_sign * two_pi * within_half(count - bus->joint_zero_count, turn) / turn;
}

/* the whole number nearest to x, modulo `turn` */
static uint16_t wrapped(double x, double turn) {
  const double whole = floor(x + 0.5);

  return (uint16_t)(whole - turn * floor(whole / turn));
}

uint16_t leg_bus_joint_count(const struct model_bus_joint *bus, double q_rad) {
  const double turn = bus->joint_counts_per_turn;

  return wrapped(bus->joint_zero_count + bus->joint_sign * q_rad / two_pi * turn, turn);
}

uint16_t leg_bus_motor_count(const struct model_bus_joint *bus, double motor_rad, double zero_count) {
  const double counts = bus->motor_sign * motor_rad / two_pi * bus->motor_counts_per_turn;

  return wrapped(zero_count + counts, UINT16_MAX + 1.0);
}

void leg_bus_encoder_init(struct leg_bus_encoder *e, const tl_model *m, const struct model_bus *bus,
                          int joint) {
  memset(e, 0, sizeof *e);
  e->model = m;
  e->bus = bus->joint[joint];
  e->joint = joint;
}

void leg_bus_encoder_take(struct leg_bus_encoder *e, const struct leg_bus_state *state) {
  const double step = e->bus.motor_sign * two_pi / e->bus.motor_counts_per_turn;
  const int moved = e->places == 0 || state->motor_count != e->last_count;
  double relative, expected;

  if (e->places > 0) e->counts += (int16_t)(uint16_t)(state->motor_count - e->last_count);
  e->last_count = state->motor_count;
  e->places += (unsigned long)moved;
  relative = step * (double)e->counts;
  e->joint_rad = leg_bus_joint_rad(&e->bus, state->joint_count);
  expected = tl_transmission_motor_angle(&e->model->drive[e->joint].transmission, e->joint_rad);
  /* at rest nothing new is learnt: the absolute encoder's rounding is the same each time */
  if (moved) e->zero_rad += (relative - expected - e->zero_rad) / (double)e->places;
  e->motor_rad = relative - e->zero_rad;
}

double leg_bus_current_A(const struct model_bus_joint *bus, double drive_A) {
  return bus->current_sign * drive_A;
}
