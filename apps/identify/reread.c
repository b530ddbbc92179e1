/* reread.c: see reread.h. */
#include "reread.h"

struct rereading {
  struct folding *f;
  const tl_problem *problem;
  const tl_model *model;
  const struct fit_input *in;
};

static int fold_into(const struct rereading *r, struct stream *const *stream, tl_factor *out,
                     struct app_error *error) {
  tl_status status;

  if (fold_all(r->f, r->model, stream, r->in->streams, error) != 0) return -1;
  status = tl_problem_merge(r->problem, r->f->factor, out);
  return status == TL_OK ? 0 : app_fail(error, APP_FAILED, "%s", tl_status_text(status));
}

static int reread(const struct rereading *r, double window_factor, int rounding, tl_factor *out,
                  struct app_error *error) {
  int result;

  for (int i = 0; i < r->in->streams; i++) stream_reread(r->in->stream[i], window_factor, rounding);
  result = fold_into(r, r->in->stream, out, error);
  for (int i = 0; i < r->in->streams; i++) stream_reread(r->in->stream[i], 1.0, -1);
  return result;
}

int reread_all(tl_readings *readings, struct folding *f, const tl_problem *problem, const tl_model *model,
               const struct fit_input *in, struct app_error *error) {
  const struct rereading r = {f, problem, model, in};

  f->robust = 0;
  if (reread(&r, 1.0, -1, &readings->as_recorded, error) != 0) return -1;
  for (int k = 0; k < TL_ROUNDINGS; k++)
    if (reread(&r, 1.0, k, &readings->rounded[k], error) != 0) return -1;
  if (reread(&r, TL_LONGER_WINDOW, -1, &readings->longer, error) != 0) return -1;
  readings->thinned.rows = 0;
  return in->thinned ? fold_into(&r, in->thinned, &readings->thinned, error) : 0;
}
