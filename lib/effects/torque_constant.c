/* torque_constant.c: the drive delivers (1 + excess) of what current times constant says; needs a sensor at the output.
 * It comes before all that the gear does with that torque, so that friction grows with what it truly carries. */
#include "../effect_columns.h"

enum { EXCESS, STRENGTHS };

static void change(const double *value, tl_effect_change *to) {
  to->torque_constant_error += value[EXCESS];
}

/* what the drive gives more need not be asked for */
static void columns(tl_effect_prepared *p, int joint, const double *shape, const tl_effect_wanted *wanted) {
  double *column = tl_columns_of(p, wanted, joint, EXCESS);
  size_t i;

  (void)shape;
  for (i = 0; i < p->segment->n && column && p->segment->effort_Nm; i++)
    column[i] = -p->segment->effort_Nm[i];
}

const tl_effect_kind tl_effect_torque_constant = {
    .name = "torque_constant",
    .order = 140,
    .meaning = "the torque constant is wrong by a factor",
    .places = TL_EFFECT_AT_SINGLE,
    .acts = TL_EFFECT_CHANGE,
    .needs_load_sensor = 1,
    .strengths = STRENGTHS,
    .shapes = 0,
    .parameter = {[EXCESS] = {"excess", -0.9, 2.0, 0.1, 0, 0.0}},
    .change = change,
    .columns = columns,
    .exact = 1,
};
