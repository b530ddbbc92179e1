/* controller_f32.c: the controller in float, see talus/controller.h; its equations are in controller_template.h. */
#include "talus/controller.h"

#include "controller_sincos.h"
#include "fixed_scalar_f32.h"

#define SINCOS(x, sine, cosine) tl_sincos_float((x), (sine), (cosine))

#include "curve_template.h"

#include "controller_template.h"

void tl_controller_start_f32(tl_controller_state_f32 *state) {
  static const tl_controller_state_f32 zero;

  start_f32(&zero, state);
}

void tl_controller_tick_f32(const tl_controller_f32 *c, tl_controller_state_f32 *state,
                            const tl_controller_input_f32 *in, tl_controller_output_f32 *out) {
  tick_f32(c, state, in, out);
}

void tl_controller_torque_f32(const tl_controller_f32 *c, const tl_controller_frame_f32 *desired,
                              float torque_Nm[TL_CONTROLLER_JOINTS], tl_controller_parts_f32 *parts) {
  uint32_t unused = 0;

  law_f32(c, desired, torque_Nm, parts, &unused);
}
