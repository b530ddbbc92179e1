/* summary.c: see summary.h. */
#include "track/summary.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/json_file.h"

static const char *const state_name[SUMMARY_STATES] = {"whole", "partial", "lost"};

int summary_begin(struct summary *s, const struct setup *setup, struct app_error *error) {
  memset(s, 0, sizeof *s);
  s->setup = setup;
  for (int m = 0; m < setup->mark.markers; m++) {
    s->interval[m] = json_array();
    if (!s->interval[m]) return app_fail(error, APP_FAILED, "out of memory");
  }
  return 0;
}

void summary_end(struct summary *s) {
  for (int m = 0; m < TL_MARKER_MAX; m++) json_decref(s->interval[m]);
}

static int state_of(const tl_marker_sample *sample) {
  if (!(sample->flags & TL_MARKER_SEEN)) return SUMMARY_LOST;
  return sample->flags & (TL_MARKER_PARTIAL | TL_MARKER_EDGE) ? SUMMARY_PARTIAL : SUMMARY_WHOLE;
}

static void close_interval(struct summary *s, int m, double to_s) {
  if (s->state[m] == SUMMARY_WHOLE) return;
  json_t *interval = json_object();
  json_set_text(interval, "state", state_name[s->state[m]]);
  json_set_number(interval, "from_s", s->since_s[m]);
  json_set_number(interval, "to_s", to_s);
  json_array_append_new(s->interval[m], interval);
}

static void add_marker(struct summary *s, int m, const struct track_row *row) {
  const int state = state_of(&row->sample[m]);
  s->count[m][state]++;
  if (s->pictures > 0 && state == s->state[m]) return;
  if (s->pictures > 0) close_interval(s, m, row->t_s);
  s->state[m] = state;
  s->since_s[m] = row->t_s;
}

static void add_link(struct summary *s, int link, int valid, const struct track_row *row, double sigma) {
  const tl_marker_sample *a = &row->sample[2 * link], *b = a + 1;
  const double length = hypot(a->x_px - b->x_px, a->y_px - b->y_px);
  if (!valid) return;
  s->length[link] += length;
  s->length2[link] += length * length;
  s->sigma2[link] += sigma * sigma;
  s->lengths[link]++;
}

void summary_add(struct summary *s, const struct track_row *row) {
  for (int m = 0; m < s->setup->mark.markers; m++) add_marker(s, m, row);
  if (s->setup->is_leg) {
    add_link(s, 0, row->angles.shank_valid, row, row->angles.shank_sigma_rad);
    add_link(s, 1, row->angles.foot_valid, row, row->angles.foot_sigma_rad);
  }
  if (s->pictures == 0) s->first_s = row->t_s;
  const double step = row->t_s - s->last_s;
  if (s->pictures == 1) s->step_s = step;
  if (s->pictures > 1) {
    if (step > 1.5 * s->step_s) s->gaps++;
    s->step_s += 0.05 * ((step < s->step_s ? -1.0 : 1.0) * 0.1 * s->step_s); /* goes towards the median */
  }
  s->last_s = row->t_s;
  s->pictures++;
}

/* ---- is it the right film ------------------------------------------------------ */

/* spread of a link's length over its mean; 0 where it was hardly seen */
static double spread(const struct summary *s, int link) {
  const double n = (double)s->lengths[link], mean = n > 0 ? s->length[link] / n : 0.0;
  const double variance = n > 1 ? s->length2[link] / n - mean * mean : 0.0;
  return mean > 0.0 && variance > 0.0 ? sqrt(variance) / mean : 0.0;
}

static int judge_leg(const struct summary *s, const char *video, struct app_error *error) {
  static const char *const link[2] = {"shank", "foot"};
  for (int k = 0; k < 2; k++) {
    if (10 * s->lengths[k] < s->pictures)
      return app_fail(error, APP_BAD_INPUT,
                      "%s: both markers of the %s are whole in only %zu of %zu pictures", video, link[k],
                      s->lengths[k], s->pictures);
    if (spread(s, k) > 0.1)
      return app_fail(error, APP_BAD_INPUT,
                      "%s: these are not a leg's markers: the %s's length varies by %.0f %%", video, link[k],
                      100.0 * spread(s, k));
  }
  return 0;
}

int summary_judge(const struct summary *s, const char *video, struct app_error *error) {
  size_t seen = 0;
  if (s->pictures == 0) return app_fail(error, APP_BAD_INPUT, "%s: no pictures", video);
  for (int m = 0; m < s->setup->mark.markers; m++) seen += s->pictures - s->count[m][SUMMARY_LOST];
  if (seen == 0)
    return app_fail(error, APP_BAD_INPUT, "%s: none of the markers appears in any of %zu pictures", video,
                    s->pictures);
  for (int m = 0; m < s->setup->mark.markers; m++)
    if (s->count[m][SUMMARY_LOST] == s->pictures)
      return app_fail(
          error, APP_BAD_INPUT, "%s: marker %s (hue %.0f degrees) does not appear in any of %zu pictures",
          video, s->setup->name[m], s->setup->mark.color[s->setup->mark.color_of[m]].hue_deg, s->pictures);
  return s->setup->is_leg ? judge_leg(s, video, error) : 0;
}

/* ---- words -------------------------------------------------------------------- */

static void print_marker(const struct summary *s, int m) {
  fprintf(stderr, "  %-8s whole in %zu, partly hidden in %zu, lost in %zu pictures", s->setup->name[m],
          s->count[m][SUMMARY_WHOLE], s->count[m][SUMMARY_PARTIAL], s->count[m][SUMMARY_LOST]);
  const size_t n = json_array_size(s->interval[m]);
  for (size_t i = 0; i < n && i < 4; i++) {
    json_t *one = json_array_get(s->interval[m], i);
    fprintf(stderr, "%s%s %.3f to %.3f s", i ? ", " : ": ", json_string_value(json_object_get(one, "state")),
            json_number_value(json_object_get(one, "from_s")),
            json_number_value(json_object_get(one, "to_s")));
  }
  fprintf(stderr, "%s\n", n > 4 ? ", ..." : "");
}

static double angle_sigma(const struct summary *s, int link) {
  return s->lengths[link] ? sqrt(s->sigma2[link] / (double)s->lengths[link]) : 0.0;
}

void summary_print(const struct summary *s, const char *video) {
  const double length_s = s->last_s - s->first_s;
  fprintf(stderr, "%s: %zu pictures in %.3f s (%.2f a second), %zu gaps\n", video, s->pictures, length_s,
          length_s > 0.0 ? (double)(s->pictures - 1) / length_s : 0.0, s->gaps);
  for (int m = 0; m < s->setup->mark.markers; m++) print_marker(s, m);
  if (s->setup->is_leg)
    fprintf(stderr,
            "  angles to %.3f (shank) and %.3f mrad (foot); the links' lengths vary by %.2f and %.2f %%\n",
            1e3 * angle_sigma(s, 0), 1e3 * angle_sigma(s, 1), 100.0 * spread(s, 0), 100.0 * spread(s, 1));
}

static json_t *marker_json(const struct summary *s, int m) {
  json_t *one = json_object();
  for (int k = 0; k < SUMMARY_STATES; k++)
    json_object_set_new(one, state_name[k], json_integer((json_int_t)s->count[m][k]));
  json_object_set(one, "intervals", s->interval[m]);
  return one;
}

json_t *summary_json(struct summary *s, const char *video) {
  json_t *root = json_object(), *markers = json_object();
  for (int m = 0; m < s->setup->mark.markers; m++) {
    close_interval(s, m, s->last_s);
    s->state[m] = SUMMARY_WHOLE; /* closed */
    json_object_set_new(markers, s->setup->name[m], marker_json(s, m));
  }
  json_set_text(root, "schema", "talus-track/1");
  json_set_text(root, "video", video);
  json_object_set_new(root, "pictures", json_integer((json_int_t)s->pictures));
  json_object_set_new(root, "gaps", json_integer((json_int_t)s->gaps));
  json_set_number(root, "first_s", s->first_s);
  json_set_number(root, "last_s", s->last_s);
  json_object_set_new(root, "markers", markers);
  if (s->setup->is_leg) {
    json_set_number(root, "shank_sigma_rad", angle_sigma(s, 0));
    json_set_number(root, "foot_sigma_rad", angle_sigma(s, 1));
    json_set_number(root, "shank_length_spread", spread(s, 0));
    json_set_number(root, "foot_length_spread", spread(s, 1));
  }
  return root;
}
