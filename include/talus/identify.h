/* identify.h: the plant's parameters from the factors of its recordings.
 *
 * The regression rows of any number of recordings, folded into one factor a
 * joint, hold all that identification needs: a particle costs O(p^2), not O(N).
 *
 *     int index[TL_MAX_ROW];
 *     tl_factor factor[1]; // one joint: an arm
 *     if (tl_factor_init(&factor[0], tl_row_index(&model, 0, index)) != TL_OK ||
 *         tl_regressor_fold(&model, n, q, v, a, NULL, torque_Nm, factor) != TL_OK) return 1;
 *     tl_identify_settings s = tl_identify_defaults();
 *     tl_problem problem;
 *     if (tl_problem_init(&problem, &model, &s, factor) != TL_OK) return 1;
 *     size_t memory_n = tl_identify_memory(&problem);
 *     double *memory = malloc(memory_n * sizeof *memory), p[TL_MAX_PARAMETERS];
 *     tl_identify_result result;
 *     if (!memory || tl_identify_swarm(&problem, memory, memory_n, p, NULL) != TL_OK ||
 *         tl_identify_conclude(&problem, p, &result) != TL_OK) return 1;
 *     free(memory);
 *     printf("%.4f kg m^2\n", result.value[0]); // prints 0.0500 kg m^2
 *
 * How sure each parameter is: tl_identify_sigma, after a second look at the rows (tl_sandwich_add).
 */
#ifndef TALUS_IDENTIFY_H
#define TALUS_IDENTIFY_H

#include <stddef.h>
#include <stdint.h>

#include "talus/factor.h"
#include "talus/plant.h"
#include "talus/pso.h"
#include "talus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Fold the regressor rows of n instants of a motion that is at hand already into the
 * joints' factors ((joints), each initialised with as many columns as tl_row_index says);
 * the right-hand side is torque - known. Arrays as in tl_inverse_batch. No filter, no
 * grid: a recording goes through talus/experimental/regression.h instead. Takes 16 KiB of stack. Nullable: slip.
 * TL_ERR_ARGUMENT when a factor's columns are not those of its joint. */
TL_CHECK tl_status tl_regressor_fold(const tl_model *m, size_t n, const double *q, const double *v,
                                     const double *a, const double *slip, const double *torque,
                                     tl_factor *factor);

/* How the joints' residuals are weighted: by each joint's noise (the residual
 * of its own least squares), or all equal, (16) as printed. */
typedef enum tl_weighting { TL_WEIGHT_NOISE = 0, TL_WEIGHT_EQUAL = 1 } tl_weighting;

typedef struct tl_identify_settings {
  tl_pso_settings swarm;
  tl_weighting weighting;
  double null_tolerance;           /* singular values below this share of the largest: not seen by the data */
  int fixed[TL_MAX_PARAMETERS];    /* 1: keep at the model's value */
  int bounded[TL_MAX_PARAMETERS];  /* 1: lower and upper below are the user's */
  double lower[TL_MAX_PARAMETERS]; /* in the order of tl_parameters */
  double upper[TL_MAX_PARAMETERS];
} tl_identify_settings;

tl_identify_settings tl_identify_defaults(void);

/* What the swarm searches in: a weighted factor over all base parameters, bounds and scales. */
typedef struct tl_problem {
  tl_model model; /* with the prior's values */
  tl_identify_settings settings;
  int parameters, bases, joints;
  double weight[TL_MAX_JOINTS]; /* factor on each joint's residual */
  double noise[TL_MAX_JOINTS];  /* RMS residual of each joint's own least squares */
  double prior[TL_MAX_PARAMETERS];
  double scale[TL_MAX_PARAMETERS]; /* |prior|, or a tenth of the search's width where that is 0 */
  double lower[TL_MAX_PARAMETERS], upper[TL_MAX_PARAMETERS];
  /* What the swarm moves: the parameters themselves, but for a pendulum's gravity, whose moment
   * and zero it searches as moment cos zero and moment sin zero (gravity is the moment's place, -1: none):
   * a circle's centre and its seam would hold a swarm back. */
  int gravity;
  double search_lower[TL_MAX_PARAMETERS], search_upper[TL_MAX_PARAMETERS];
  tl_factor factor;
} tl_problem;

/* Combine the joints' factors (columns of joint j: tl_row_index; (joints) of them).
 * A joint with no more rows than columns (one that hardly moved) cannot tell its noise and
 * weighs 0. TL_ERR_TOO_SHORT when all joints are such; TL_ERR_RANGE when bounds contradict
 * each other or leave the prior's physical range. */
TL_CHECK tl_status tl_problem_init(tl_problem *problem, const tl_model *prior, const tl_identify_settings *s,
                                   const tl_factor *factor);

/* Physical parameters (value) at a point of the search, x. */
void tl_problem_parameters(const tl_problem *problem, const double *x, double *value);
/* Mean square of (16) at a point of the search, weighted, less the constant that least squares would
 * leave in any case (tl_factor_excess); context is the tl_problem. A tl_pso_cost. */
double tl_identify_cost(const double *x, const void *context);

/* Doubles of memory for the swarm. */
size_t tl_identify_memory(const tl_problem *problem);
/* The swarm in the calling thread: best physical parameters. Nullable: evaluations. */
TL_CHECK tl_status tl_identify_swarm(const tl_problem *problem, double *memory, size_t memory_n, double *best,
                                     uint64_t *evaluations);
/* Widen (tenfold) the upper bounds that were not the user's and that `best` has
 * run into: 1 when any was, and the swarm should run again. */
int tl_problem_widen(tl_problem *problem, const double *best);

typedef struct tl_identify_result {
  double value[TL_MAX_PARAMETERS];
  double sigma[TL_MAX_PARAMETERS];     /* standard deviation; NaN where not identifiable */
  int identifiable[TL_MAX_PARAMETERS]; /* 0: the data do not fix it (null space, or fixed by settings) */
  int at_bound[TL_MAX_PARAMETERS];     /* 1: value lies on a bound of the search */
  double base[TL_MAX_BASE];
  double base_sigma[TL_MAX_BASE];      /* NaN where the data do not fix it */
  double base_systematic[TL_MAX_BASE]; /* as systematic below */
  /* null directions: relative changes (in units of the scale) that leave every
   * prediction as it is; unit length, largest entry positive */
  int null_count;
  double null_direction[TL_MAX_PARAMETERS][TL_MAX_PARAMETERS];
  double condition_number; /* of the regressor over the free base parameters, columns at unit length */
  double systematic[TL_MAX_PARAMETERS]; /* part of sigma that tl_identify_readings adds; 0 before it */
  int hidden[TL_MAX_PARAMETERS]; /* 1: the angles' noise moves it as much as the motion does: sigma is NaN */
  double cost;                   /* mean square of (16) at the swarm's optimum, weighted */
  double least_squares_cost;     /* of linear least squares over the same base parameters, no bounds */
} tl_identify_result;

/* From the swarm's optimum to the answer: the null space found from the data,
 * the point of the solution set nearest to the prior (minimum of the squared
 * relative changes), and the certificate. Sigmas are NaN until tl_identify_sigma. */
TL_CHECK tl_status tl_identify_conclude(const tl_problem *problem, const double *best,
                                        tl_identify_result *result);

/* ---- how sure ----------------------------------------------------------- */

/* Covariance of correlated residuals: the products x e are summed over blocks
 * of block_s, and the blocks' sums are taken as independent (White 1984; the "batch" or
 * cluster estimate), which holds whatever the noise's colour within a block. */
typedef struct tl_sandwich {
  int bases;
  double block_s;
  double begin_s;
  size_t blocks, rows;
  double sum[TL_MAX_BASE];
  double meat[TL_MAX_BASE * TL_MAX_BASE];
} tl_sandwich;

TL_CHECK tl_status tl_sandwich_init(tl_sandwich *s, int bases, double block_s);
/* One row: its instant, columns x (n of base parameters index[]), residual, both times the joint's weight. */
void tl_sandwich_add(tl_sandwich *s, double t_s, const double *x, size_t stride, const int *index, int n,
                     double weight, double residual);
/* End the last block (also between recordings). */
void tl_sandwich_close(tl_sandwich *s);

/* Fill the sigmas. TL_ERR_TOO_SHORT with fewer blocks than base parameters + 2 (sigmas then stay NaN). */
TL_CHECK tl_status tl_identify_sigma(const tl_problem *problem, const tl_sandwich *s,
                                     tl_identify_result *result);

/* ---- how far off ---------------------------------------------------------- */

/* Residuals do not show what pulls the parameters the same way in every block: noise and resolution of the angles, which
 * also enter the regressor (errors in variables), what the windows smear, what happens between two samples. The
 * same recordings read once more, a little worse in one of these respects, show how far each of them moves the answer. */
#define TL_ROUNDINGS 8           /* readings that differ in where the rounding's steps lie */
#define TL_ROUNDING_VARIANCE 2.0 /* of the noise that a rounding adds, in that of the angle's own */
#define TL_LONGER_WINDOW 1.5
#define TL_THINNED 2 /* every second sample */

/* A long recording is read again in excerpts, TL_READING_ROWS of it in TL_READING_PLACES places: the time that readings
 * take does not grow with the recording, and what they tell is as wide as that many rows are. */
#define TL_READING_ROWS 16384
#define TL_READING_PLACES 8
/* Where a direction of the regressor has a smaller share of its weight in the excerpts than this, they are no picture of
 * the recording: it is read whole. */
#define TL_READING_SHARE 0.25

/* Rows of one place in a recording of `rows`, one of several of `all` rows together: even, and at least 2. A recording of
 * not more than TL_READING_PLACES such places is read whole. */
size_t tl_reading_place_rows(size_t rows, size_t all);
/* The row that place k of 0..TL_READING_PLACES-1 begins at, place_rows long; 0 where place_rows >= rows. */
size_t tl_reading_place(size_t rows, size_t place_rows, size_t k);

typedef struct tl_readings {
  tl_factor as_recorded; /* each of them all joints in one, by tl_problem_merge */
  tl_factor rounded[TL_ROUNDINGS];
  tl_factor longer;  /* windows TL_LONGER_WINDOW times as long */
  tl_factor thinned; /* without rows: the recordings are too short or too slow to be thinned */
} tl_readings;

/* Round n angles to steps that add TL_ROUNDING_VARIANCE times the variance of their noise (its standard deviation, in the
 * angle's unit; 0: as they are); `number` of 0..TL_ROUNDINGS-1 and the joint say where the steps lie. */
void tl_round_angles(double *x, size_t n, double noise, int number, int joint);

/* The joints' factors ((joints) of them) in one, by the weights of the problem. */
TL_CHECK tl_status tl_problem_merge(const tl_problem *problem, const tl_factor *factor, tl_factor *merged);

/* The least share, over all directions that the problem's rows see, that a reading has of their weight, at as many rows: 1
 * where the reading is a fair picture of them, 0 where it lacks one. */
TL_CHECK tl_status tl_reading_share(const tl_problem *problem, const tl_factor *reading, double *share);

/* After tl_identify_sigma: adds to the variances what the readings tell (docs/signal.md has the formulas), and finds the
 * parameters that noise hides. Where a rounded reading has no rows, noise hides the whole motion: every parameter is hidden,
 * and its `systematic` is as large as its value. TL_ERR_ARGUMENT where as_recorded has no rows, or a reading other columns
 * than the problem. */
TL_CHECK tl_status tl_identify_readings(const tl_problem *problem, const tl_readings *readings,
                                        tl_identify_result *result);

#ifdef __cplusplus
}
#endif
#endif
