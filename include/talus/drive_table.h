/* drive_table.h: a drive's transmission as three tables, with a proven bound of what fixed point makes of them.
 *
 *     tl_curve_knot_f64 knot[TL_DRIVE_TABLE_KNOTS];
 *     tl_drive_table table;
 *     if (tl_drive_table_make(&table, &ankle, knot) != TL_OK) return 1;
 *     tl_curve_knot_q31 knot_q31[TL_CURVE_MAX_KNOTS];
 *     tl_curve_q31 ratio_q31;
 *     if (tl_curve_to_q31(&table.ratio, TL_Q_ANGLE, knot_q31, &ratio_q31) != TL_OK) return 1;
 *     int32_t q_q29 = 1 << 27, slope; // 0.25 rad
 *     uint32_t saturated = 0;
 *     double ratio = table.ratio_scale * tl_curve_at_q31(&ratio_q31, q_q29, &slope, &saturated) / 2147483648.0;
 *
 * A table spans +-30 degrees. The bound has two parts: what interpolation does, step^4 / 384 times the largest
 * fourth derivative, which interval arithmetic on the closed form encloses; and what rounding does.
 */
#ifndef TALUS_DRIVE_TABLE_H
#define TALUS_DRIVE_TABLE_H

#include "talus/curve.h"
#include "talus/status.h"
#include "talus/transmission.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TL_DRIVE_TABLE_KNOTS (3 * TL_CURVE_MAX_KNOTS)
#define TL_DRIVE_TABLE_ERROR 4e-9 /* of full scale: with this the number of knots is enough */

/* Curves over the joint angle, in [-1, 1]; each times its scale is the motor angle [rad], the ratio, and 1 / ratio. */
typedef struct tl_drive_table {
  tl_curve_f64 angle, ratio, inverse;
  double angle_scale_rad, ratio_scale, inverse_scale; /* > 0 */
  double step_rad;
  /* proven bounds of the error in fixed point over +-30 degrees, of full scale */
  double angle_error, ratio_error, inverse_error;
} tl_drive_table;

/* The tables of a linkage or a series, with 33, 65 or 129 knots each: the fewest whose bounds for angle and ratio are
 * within TL_DRIVE_TABLE_ERROR, or else 129. `knot` has room for TL_DRIVE_TABLE_KNOTS and must outlive the table.
 * TL_ERR_UNSUPPORTED for other kinds, TL_ERR_RANGE when the ratio changes sign or is too steep for Q31. */
TL_CHECK tl_status tl_drive_table_make(tl_drive_table *table, const tl_transmission *t,
                                       tl_curve_knot_f64 *knot);

#ifdef __cplusplus
}
#endif
#endif
