/* controller_q31.c: the controller in fixed point, see talus/controller.h; its equations are in controller_template.h. */
#include "talus/controller.h"

#include "fixed_scalar_q31.h"

#define SINCOS(x, sine, cosine) tl_sincos_fixed((x), (sine), (cosine))

#include "curve_template.h"

#include "controller_template.h"

void tl_controller_start_q31(tl_controller_state_q31 *state) {
  static const tl_controller_state_q31 zero;

  start_q31(&zero, state);
}

void tl_controller_tick_q31(const tl_controller_q31 *c, tl_controller_state_q31 *state,
                            const tl_controller_input_q31 *in, tl_controller_output_q31 *out) {
  tick_q31(c, state, in, out);
}

void tl_controller_torque_q31(const tl_controller_q31 *c, const tl_controller_frame_q31 *desired,
                              int32_t torque_Nm[TL_CONTROLLER_JOINTS], tl_controller_parts_q31 *parts,
                              uint32_t *saturated) {
  law_q31(c, desired, torque_Nm, parts, saturated);
}
