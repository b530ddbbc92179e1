/* reread.c: see reread.h. */
#include "reread.h"

struct rereading {
  struct folding *f;
  const tl_problem *problem;
  const struct inputs *in; /* the whole recordings */
};

static int fold_into(const struct rereading *r, const struct inputs *in, tl_factor *out,
                     struct app_error *error) {
  tl_status status;

  if (fold_all(r->f, &in->file->model, in->stream, in->n, error) != 0) return -1;
  status = tl_problem_merge(r->problem, r->f->factor, out);
  return status == TL_OK ? 0 : app_fail(error, APP_FAILED, "%s", tl_status_text(status));
}

static int reread(const struct rereading *r, const struct inputs *in, double window_factor, int rounding,
                  tl_factor *out, struct app_error *error) {
  for (int i = 0; i < in->n; i++) stream_reread(in->stream[i], window_factor, rounding);
  return fold_into(r, in, out, error);
}

/* how fair a picture of the recordings the excerpts are, and their rows as they were recorded */
static int read_as_recorded(const struct rereading *r, const struct inputs *in, tl_factor *out, double *share,
                            struct app_error *error) {
  tl_status status;

  if (reread(r, in, 1.0, -1, out, error) != 0) return -1;
  status = tl_reading_share(r->problem, out, share);
  return status == TL_OK ? 0 : app_fail(error, APP_FAILED, "%s", tl_status_text(status));
}

/* without rows where a recording is too short or too slow to be thinned: that is no error */
static int read_thinned(const struct rereading *r, int whole, tl_factor *out, struct app_error *error) {
  struct app_error ignored;
  struct inputs thinned;
  int result = 0;

  out->rows = 0;
  if (inputs_open_excerpts(&thinned, r->in, whole, TL_THINNED, &ignored) == 0)
    result = fold_into(r, &thinned, out, error);
  inputs_close(&thinned);
  return result;
}

/* every reading but those as recorded and thinned */
static int read_worse(const struct rereading *r, const struct inputs *in, tl_readings *readings,
                      struct app_error *error) {
  for (int k = 0; k < TL_ROUNDINGS; k++)
    if (reread(r, in, 1.0, k, &readings->rounded[k], error) != 0) return -1;
  return reread(r, in, TL_LONGER_WINDOW, -1, &readings->longer, error);
}

static int read_excerpts(const struct rereading *r, int whole, tl_readings *readings, int *fair,
                         struct app_error *error) {
  struct inputs excerpts;
  struct app_error none;
  double share = 0.0;
  int result = inputs_open_excerpts(&excerpts, r->in, whole, 1, whole ? error : &none);

  if (result == 0)
    result = read_as_recorded(r, &excerpts, &readings->as_recorded, &share, error);
  else if (!whole)
    result = 0; /* no usable row among them: no picture */
  *fair = whole || share >= TL_READING_SHARE;
  if (result == 0 && *fair) result = read_worse(r, &excerpts, readings, error);
  if (result == 0 && *fair) result = read_thinned(r, whole, &readings->thinned, error);
  inputs_close(&excerpts);
  return result;
}

int reread_all(tl_readings *readings, struct folding *f, const tl_problem *problem, const struct inputs *in,
               struct app_error *error) {
  const struct rereading r = {f, problem, in};
  int fair, whole = !inputs_are_long(in);

  f->robust = 0;
  f->task = "doubting the readings of";
  if (read_excerpts(&r, whole, readings, &fair, error) != 0) return -1;
  return fair ? 0 : read_excerpts(&r, 1, readings, &fair, error);
}
