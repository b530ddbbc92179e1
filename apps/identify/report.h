/* report.h: what an identification found, as JSON, as words and as a page. */
#ifndef REPORT_H
#define REPORT_H

#include "common/error.h"
#include "fit.h"
#include "model/model_file.h"

struct report_input {
  const struct fit *fit;
  const struct model_file *prior;
  struct stream *const *stream;
  const char *const *path; /* of the recordings */
  int recordings;
  uint64_t seed;
};

/* R.json of the contract, atomically. */
int report_write_json(const char *path, const struct report_input *in, struct app_error *error);
/* A short table and every warning, to standard error; or the warnings alone. */
void report_say(const struct report_input *in);
void report_warn(const struct report_input *in);

/* The picture: each recording's torque over time, measured, as given and as identified, and what is left. */
struct picture;
struct picture *picture_new(int recordings, int joints);
void picture_free(struct picture *picture);
/* A fit_trace; context is the picture. */
void picture_trace(const struct fit_instant *instant, void *picture);
int picture_write(const struct picture *picture, const char *path, const struct report_input *in,
                  struct app_error *error);

/* A null direction in words, without a full stop: which parameters it is, and what became of them. `told` gathers
 * the parameters that were named (0 at first); 0, and no text, where all of these were. */
#define REPORT_TEXT 600
int report_null_text(const struct report_input *in, int direction, unsigned *told, char *text, size_t size);

/* What is to be said of a parameter that these recordings leave open: an inertia that is not fixed within 1 %, or any that
 * the angles' noise hides; without a full stop. 0, and no text, for all others. */
int report_inertia_text(const struct report_input *in, int parameter, char *text, size_t size);

#endif
