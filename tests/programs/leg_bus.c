/* leg_bus.c: the leg's bus for tests/test_bus.py, one request a line on standard input.
 *
 *   leg_bus MODEL.yaml
 *
 *   command JOINT COUNTER Q V TORQUE     stop COUNTER REASON SOURCE     host COUNTER MODE
 *   state JOINT COUNTER MOTOR ANGLE A    status JOINT COUNTER C C STATE FAULTS
 *   supply COUNTER V A                   bench COUNTER LATE MISSED UPTIME
 *       print the frame as "ID#DATA", or "refused"
 *   frame ID#DATA       what a frame says
 *   count JOINT Q MOTOR ZERO     angles to counts
 *   take JOINT MOTOR ANGLE       two counts to the encoder's angles, one state after the other
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "leg_bus/leg_bus.h"

static struct model_file file;
static struct leg_bus_encoder encoder[TL_MAX_JOINTS];

static void show(const struct leg_bus_frame *frame) {
  printf("%03X#", (unsigned)frame->id);
  for (int i = 0; i < frame->length; i++) printf("%02X", frame->data[i]);
  printf("\n");
}

static int make_host_frame(const char *word, const double *x) {
  struct leg_bus_frame frame;
  if (strcmp(word, "command") == 0) {
    if (leg_bus_command(&frame, (int)x[0], (uint16_t)x[1], x[2], x[3], x[4]) != 0) return printf("refused\n");
  } else if (strcmp(word, "stop") == 0)
    leg_bus_stop(&frame, (uint16_t)x[0], (uint8_t)x[1], (uint8_t)x[2]);
  else if (strcmp(word, "host") == 0)
    leg_bus_host_heartbeat(&frame, (uint16_t)x[0], (enum leg_bus_mode)x[1]);
  else
    return 0;
  show(&frame);
  return 1;
}

static int make_bench_frame(const char *word, const double *x) {
  struct leg_bus_frame frame;
  if (strcmp(word, "state") == 0) {
    const struct leg_bus_state state = {(uint16_t)x[1], (uint16_t)x[2], (uint16_t)x[3], x[4]};
    leg_bus_pack_state(&frame, (int)x[0], &state);
  } else if (strcmp(word, "status") == 0) {
    const struct leg_bus_status status = {(uint16_t)x[1], x[2], x[3], (enum leg_bus_mode)x[4], (uint8_t)x[5]};
    leg_bus_pack_status(&frame, (int)x[0], &status);
  } else if (strcmp(word, "supply") == 0)
    leg_bus_pack_supply(&frame, (uint16_t)x[0], x[1], x[2]);
  else if (strcmp(word, "bench") == 0)
    leg_bus_pack_heartbeat(&frame, (uint16_t)x[0], (unsigned long)x[1], (unsigned long)x[2], x[3]);
  else
    return 0;
  show(&frame);
  return 1;
}

static int convert(const char *word, const double *x) {
  const int joint = (int)x[0];
  if (strcmp(word, "count") == 0) {
    const struct model_bus_joint *bus = &file.bus.joint[joint];
    printf("%u %u\n", leg_bus_joint_count(bus, x[1]), leg_bus_motor_count(bus, x[2], x[3]));
  } else if (strcmp(word, "take") == 0) {
    const struct leg_bus_state state = {.motor_count = (uint16_t)x[1], .joint_count = (uint16_t)x[2]};
    leg_bus_encoder_take(&encoder[joint], &state);
    printf("%.17g %.17g\n", encoder[joint].motor_rad, encoder[joint].joint_rad);
  } else
    return 0;
  return 1;
}

static void explain(const char *text) {
  struct leg_bus_frame frame = {0};
  struct leg_bus_setpoint setpoint;
  struct leg_bus_state state;
  enum leg_bus_mode mode;
  char *data, pair[3] = "";
  int joint;

  frame.id = (uint32_t)strtoul(text, &data, 16);
  for (data++; data[0] && data[1]; data += 2) {
    memcpy(pair, data, 2);
    frame.data[frame.length++] = (uint8_t)strtoul(pair, NULL, 16);
  }
  if (leg_bus_unpack_command(&frame, &joint, &setpoint) == 0)
    printf("command %d %u %.17g %.17g %.17g\n", joint, setpoint.counter, setpoint.q_rad, setpoint.v_rad_s,
           setpoint.torque_Nm);
  else if (leg_bus_unpack_state(&frame, &joint, &state) == 0)
    printf("state %d %u %u %u %.17g\n", joint, state.counter, state.motor_count, state.joint_count,
           leg_bus_current_A(&file.bus.joint[joint], state.current_A));
  else if (leg_bus_unpack_host_heartbeat(&frame, &mode) == 0)
    printf("host %d\n", (int)mode);
  else
    printf("%s\n", leg_bus_is_stop(&frame) ? "stop" : "nothing");
}

int main(int argc, char **argv) {
  struct app_error error;
  char line[256], word[32], *rest;

  if (argc != 2 || model_file_read(argv[1], &file, &error) != 0) return 2;
  for (int j = 0; j < TL_MAX_JOINTS; j++) leg_bus_encoder_init(&encoder[j], &file.model, &file.bus, j);
  while (fgets(line, sizeof line, stdin)) {
    double x[6] = {0};
    line[strcspn(line, "\n")] = '\0';
    snprintf(word, sizeof word, "%.*s", (int)strcspn(line, " "), line);
    rest = line + strcspn(line, " ");
    if (strcmp(word, "frame") == 0) {
      explain(rest);
      continue;
    }
    for (int i = 0; i < 6 && *rest; i++) x[i] = strtod(rest, &rest);
    if (make_host_frame(word, x) || make_bench_frame(word, x) || convert(word, x)) continue;
    return 2;
  }
  return 0;
}
