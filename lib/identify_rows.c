/* identify_rows.c: regressor rows of a known motion, straight into the joints' factors; see talus/identify.h. */
#include "talus/identify.h"

/* what is folded: arrays of length n for each joint, joint after joint */
typedef struct motion {
  size_t n;
  const double *q, *v, *a, *slip, *torque;
} motion;

/* where the motion stands from instant `first` on; without slip for tl_slip_block to fill */
static tl_motion_block block_at(const motion *all, int joints, size_t first) {
  tl_motion_block block = {{0}, {0}, {0}, {0}};

  for (int j = 0; j < joints; j++) {
    size_t at = (size_t)j * all->n + first;
    block.q[j] = all->q + at;
    block.v[j] = all->v + at;
    block.a[j] = all->a + at;
    if (all->slip) block.slip[j] = all->slip + at;
  }
  return block;
}

/* instants [first, first + count) */
static void fold_block(const tl_model *m, const motion *all, size_t first, size_t count, tl_factor *factor) {
  int joints = tl_joint_count(m);
  double slip[TL_MAX_JOINTS][TL_BLOCK_ROWS];
  tl_motion_block block = block_at(all, joints, first);
  tl_regressor_block rows;

  if (!all->slip) {
    tl_slip_block(m, block.v, count, slip);
    block.slip[0] = slip[0];
    block.slip[1] = slip[1];
  }
  tl_regressor_rows(m, &block, count, &rows);
  for (int j = 0; j < joints; j++) {
    const double *torque = all->torque + (size_t)j * all->n + first;
    double *target = rows.column[j][factor[j].columns];
    for (size_t i = 0; i < count; i++) target[i] = torque[i] - rows.known[j][i];
    tl_factor_add(&factor[j], rows.column[j][0], count, TL_BLOCK_ROWS);
  }
}

tl_status tl_regressor_fold(const tl_model *m, size_t n, const double *q, const double *v, const double *a,
                            const double *slip, const double *torque, tl_factor *factor) {
  motion all = {n, q, v, a, slip, torque};
  int index[TL_MAX_ROW];

  if (!m || !q || !v || !a || !torque || !factor) return TL_ERR_ARGUMENT;
  for (int j = 0; j < tl_joint_count(m); j++)
    if (factor[j].columns != tl_row_index(m, j, index)) return TL_ERR_ARGUMENT;
  for (size_t first = 0; first < n; first += TL_BLOCK_ROWS)
    fold_block(m, &all, first, n - first < TL_BLOCK_ROWS ? n - first : TL_BLOCK_ROWS, factor);
  return TL_OK;
}
