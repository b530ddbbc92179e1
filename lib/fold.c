/* fold.c: regressor rows of a known motion, straight into the joints' factors; see talus/identify.h. */
#include <string.h>

#include "plant_internal.h"
#include "talus/identify.h"

/* what is folded: arrays of length n for each joint, joint after joint */
typedef struct motion {
  size_t n;
  const double *q, *v, *a, *slip, *torque;
} motion;

/* instants [first, first + count) */
static void take_piece(const tl_model *m, const motion *all, size_t first, size_t count, tl_piece *piece) {
  size_t bytes = count * sizeof(double);

  for (int j = 0; j < tl_joint_count(m); j++) {
    size_t at = (size_t)j * all->n + first;
    memcpy(piece->q[j], all->q + at, bytes);
    memcpy(piece->v[j], all->v + at, bytes);
    memcpy(piece->a[j], all->a + at, bytes);
    if (all->slip) memcpy(piece->slip[j], all->slip + at, bytes);
  }
  if (!all->slip) tl_piece_slip(m, count, piece);
}

/* rows of any plant, one instant after the other */
static void put_rows(const tl_model *m, const tl_piece *piece, size_t count, tl_piece_rows *rows) {
  double row[TL_MAX_JOINTS * TL_MAX_ROW], known[TL_MAX_JOINTS];

  for (size_t i = 0; i < count; i++) {
    tl_motion now = {{piece->q[0][i], piece->q[1][i]},
                     {piece->v[0][i], piece->v[1][i]},
                     {piece->a[0][i], piece->a[1][i]},
                     {piece->slip[0][i], piece->slip[1][i]}};
    tl_regressor(m, &now, row, known);
    for (int j = 0; j < TL_MAX_JOINTS; j++) {
      for (int c = 0; c < TL_MAX_ROW; c++) rows->column[j][c][i] = row[j * TL_MAX_ROW + c];
      rows->known[j][i] = known[j];
    }
  }
}

tl_status tl_regressor_fold(const tl_model *m, size_t n, const double *q, const double *v, const double *a,
                            const double *slip, const double *torque, tl_factor *factor) {
  motion all = {n, q, v, a, slip, torque};
  tl_piece piece;
  tl_piece_rows rows;
  int joints, index[TL_MAX_ROW];

  if (!m || !q || !v || !a || !torque || !factor) return TL_ERR_ARGUMENT;
  joints = tl_joint_count(m);
  for (int j = 0; j < joints; j++)
    if (factor[j].columns != tl_row_index(m, j, index)) return TL_ERR_ARGUMENT;
  memset(&piece, 0, sizeof piece);
  for (size_t first = 0; first < n; first += TL_PIECE) {
    size_t count = n - first < TL_PIECE ? n - first : TL_PIECE;
    take_piece(m, &all, first, count, &piece);
    if (m->plant == TL_PLANT_LEG)
      tl_leg_piece(m, &piece, count, &rows);
    else
      put_rows(m, &piece, count, &rows);
    for (int j = 0; j < joints; j++) {
      double *target = rows.column[j][factor[j].columns];
      for (size_t i = 0; i < count; i++) target[i] = torque[(size_t)j * n + first + i] - rows.known[j][i];
      tl_factor_add(&factor[j], rows.column[j][0], count, TL_PIECE);
    }
  }
  return TL_OK;
}
