/* fold.c: regressor rows of a known motion, straight into the joints' factors; see talus/identify.h. */
#include "talus/identify.h"

/* Rows built before they are folded: a whole number of times in the factor's own
 * block, and small enough for the stack of a controller (9 KiB). */
#define FOLD_ROWS 64

/* one block's rows of every joint, column-major; the last column is the target */
typedef struct fold_block {
  double row[TL_MAX_JOINTS][TL_MAX_ROW + 1][FOLD_ROWS];
  int columns[TL_MAX_JOINTS];
  int joints;
} fold_block;

/* what is folded: arrays of length n for each joint, joint after joint */
typedef struct fold_motion {
  size_t n;
  const double *q, *v, *a, *slip, *torque;
} fold_motion;

static void motion_at(const tl_model *m, const fold_motion *all, int joints, size_t i, tl_motion *now) {
  for (int j = 0; j < joints; j++) {
    size_t at = (size_t)j * all->n + i;
    now->q[j] = all->q[at];
    now->v[j] = all->v[at];
    now->a[j] = all->a[at];
    if (all->slip) now->slip[j] = all->slip[at];
  }
  if (!all->slip) tl_slip_from_velocity(m, now);
}

/* rows of the instants [first, first + count) */
static void fill(fold_block *block, const tl_model *m, const fold_motion *all, size_t first, size_t count) {
  double row[TL_MAX_JOINTS * TL_MAX_ROW], known[TL_MAX_JOINTS];
  tl_motion now = {{0.0}, {0.0}, {0.0}, {0.0}};

  for (size_t i = 0; i < count; i++) {
    motion_at(m, all, block->joints, first + i, &now);
    tl_regressor(m, &now, row, known);
    for (int j = 0; j < block->joints; j++) {
      int columns = block->columns[j];
      for (int c = 0; c < columns; c++) block->row[j][c][i] = row[j * TL_MAX_ROW + c];
      block->row[j][columns][i] = all->torque[(size_t)j * all->n + first + i] - known[j];
    }
  }
}

tl_status tl_regressor_fold(const tl_model *m, size_t n, const double *q, const double *v, const double *a,
                            const double *slip, const double *torque, tl_factor *factor) {
  fold_motion all = {n, q, v, a, slip, torque};
  fold_block block;
  int index[TL_MAX_ROW];

  if (!m || !q || !v || !a || !torque || !factor) return TL_ERR_ARGUMENT;
  block.joints = tl_joint_count(m);
  for (int j = 0; j < block.joints; j++) {
    block.columns[j] = tl_row_index(m, j, index);
    if (factor[j].columns != block.columns[j]) return TL_ERR_ARGUMENT;
  }
  for (size_t first = 0; first < n; first += FOLD_ROWS) {
    size_t count = n - first < FOLD_ROWS ? n - first : FOLD_ROWS;
    fill(&block, m, &all, first, count);
    for (int j = 0; j < block.joints; j++) tl_factor_add(&factor[j], block.row[j][0], count, FOLD_ROWS);
  }
  return TL_OK;
}
