/* identify_rows.c: regressor rows of a known motion, straight into the joints' factors; see talus/identify.h. */
#include "plant_internal.h"
#include "talus/identify.h"

/* what is folded: arrays of length n for each joint, joint after joint */
typedef struct motion {
  size_t n;
  const double *q, *v, *a, *slip, *torque;
} motion;

/* where the motion stands from instant `first` on; without slip for tl_piece_slip to fill */
static tl_piece piece_at(const motion *all, int joints, size_t first) {
  tl_piece piece = {{0}, {0}, {0}, {0}};

  for (int j = 0; j < joints; j++) {
    size_t at = (size_t)j * all->n + first;
    piece.q[j] = all->q + at;
    piece.v[j] = all->v + at;
    piece.a[j] = all->a + at;
    if (all->slip) piece.slip[j] = all->slip + at;
  }
  return piece;
}

/* rows of any plant, one instant after the other */
static void put_rows(const tl_model *m, const tl_piece *piece, int joints, size_t n, tl_piece_rows *rows) {
  double row[TL_MAX_JOINTS * TL_MAX_ROW], known[TL_MAX_JOINTS];

  for (size_t i = 0; i < n; i++) {
    tl_motion now = {{0.0}, {0.0}, {0.0}, {0.0}};
    for (int j = 0; j < joints; j++) {
      now.q[j] = piece->q[j][i];
      now.v[j] = piece->v[j][i];
      now.a[j] = piece->a[j][i];
      now.slip[j] = piece->slip[j][i];
    }
    tl_regressor(m, &now, row, known);
    for (int j = 0; j < joints; j++) {
      for (int c = 0; c < TL_MAX_ROW; c++) rows->column[j][c][i] = row[j * TL_MAX_ROW + c];
      rows->known[j][i] = known[j];
    }
  }
}

/* instants [first, first + count) */
static void fold_piece(const tl_model *m, const motion *all, size_t first, size_t count, tl_factor *factor) {
  int joints = tl_joint_count(m);
  double slip[TL_MAX_JOINTS][TL_PIECE];
  tl_piece piece = piece_at(all, joints, first);
  tl_piece_rows rows;

  if (!all->slip) {
    tl_piece_slip(m, piece.v, count, slip);
    piece.slip[0] = slip[0];
    piece.slip[1] = slip[1];
  }
  if (m->plant == TL_PLANT_LEG)
    tl_leg_piece(m, &piece, count, &rows);
  else
    put_rows(m, &piece, joints, count, &rows);
  for (int j = 0; j < joints; j++) {
    const double *torque = all->torque + (size_t)j * all->n + first;
    double *target = rows.column[j][factor[j].columns];
    for (size_t i = 0; i < count; i++) target[i] = torque[i] - rows.known[j][i];
    tl_factor_add(&factor[j], rows.column[j][0], count, TL_PIECE);
  }
}

tl_status tl_regressor_fold(const tl_model *m, size_t n, const double *q, const double *v, const double *a,
                            const double *slip, const double *torque, tl_factor *factor) {
  motion all = {n, q, v, a, slip, torque};
  int index[TL_MAX_ROW];

  if (!m || !q || !v || !a || !torque || !factor) return TL_ERR_ARGUMENT;
  for (int j = 0; j < tl_joint_count(m); j++)
    if (factor[j].columns != tl_row_index(m, j, index)) return TL_ERR_ARGUMENT;
  for (size_t first = 0; first < n; first += TL_PIECE)
    fold_piece(m, &all, first, n - first < TL_PIECE ? n - first : TL_PIECE, factor);
  return TL_OK;
}
