/* controller_f64.c: the controller in double, see talus/controller.h; its equations are in controller_template.h. */
#include "talus/controller.h"

#include "fixed_scalar_f64.h"
#include "talus/math.h"

#define SINCOS(x, sine, cosine) tl_sincos((x), (sine), (cosine))

#include "curve_template.h"

#include "controller_template.h"

void tl_controller_start_f64(tl_controller_state_f64 *state) {
  static const tl_controller_state_f64 zero;

  start_f64(&zero, state);
}

void tl_controller_tick_f64(const tl_controller_f64 *c, tl_controller_state_f64 *state,
                            const tl_controller_input_f64 *in, tl_controller_output_f64 *out) {
  tick_f64(c, state, in, out);
}

void tl_controller_torque_f64(const tl_controller_f64 *c, const tl_controller_frame_f64 *desired,
                              double torque_Nm[TL_CONTROLLER_JOINTS], tl_controller_parts_f64 *parts) {
  uint32_t unused = 0;

  law_f64(c, desired, torque_Nm, parts, &unused);
}
