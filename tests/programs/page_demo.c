/* page_demo.c: a page with everything that page.h offers, for tests/test_page.py.
 *
 *   page_demo PATH SAMPLES TEXT      TEXT stands wherever a text may stand
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "page/page.h"

static void add_joint(struct page *page, const char *text, size_t n) {
  static struct envelope measured, predicted, residual;
  envelope_init(&measured);
  envelope_init(&predicted);
  envelope_init(&residual);
  for (size_t i = 0; i < n; i++) {
    const double t = 0.001 * (double)i;
    const int gap = i > n / 2 && i < n / 2 + n / 50;
    const double y = sin(3.0 * t) + 0.3 * sin(17.0 * t), e = 0.05 * sin(40.0 * t) * cos(0.3 * t);
    envelope_add(&measured, t, gap ? (double)NAN : y + e);
    envelope_add(&predicted, t, gap ? (double)NAN : y);
    envelope_add(&residual, t, gap ? (double)NAN : e);
  }
  json_t *chart = page_chart(page, text, "time [s]", "torque [Nm]");
  page_envelope(chart, "measured", "measured", &measured);
  page_envelope(chart, "predicted", "predicted", &predicted);
  page_envelope(page_chart_below(page, chart, "residual [Nm]"), text, "residual", &residual);
}

static void add_small_charts(struct page *page, const char *text) {
  const char *const labels[] = {"stribeck", text, "none"};
  const double share[] = {0.9, 0.08, 0.02};
  double x[200], y[200];
  for (int i = 0; i < 200; i++) {
    x[i] = 0.01 * i - 1.0;
    y[i] = i == 100 ? (double)NAN : x[i] * fabs(x[i]);
  }
  page_bars(page, "Probability", "probability", labels, share, 3);
  page_series(page_dots(page, "Friction", "velocity [rad/s]", "residual [Nm]"), text, "accent", x, y, 200);
}

int main(int argc, char **argv) {
  struct app_error error;
  app_set_name("page_demo");
  if (argc < 4) return APP_BAD_INPUT;
  const char *text = argv[3];
  const char *const columns[] = {text, "nominal [%]", "identified [%]"};
  const char *const knee[] = {"knee", "93.5", "1.20"}, *const ankle[] = {text, "80.8", "2.31"};
  struct page *page =
      page_new(text, "The identified model explains the knee's torque to 1.2 % and the ankle's to 2.3 %.");
  if (!page) return APP_FAILED;
  page_table(page, "Error of the motor torques", columns, 3);
  page_table_row(page, knee);
  page_table_row(page, ankle);
  page_heading(page, "Measured against predicted");
  page_paragraph(page, text);
  add_joint(page, text, (size_t)strtoul(argv[2], NULL, 10));
  page_heading(page, "Where the gap lies");
  add_small_charts(page, text);
  const int result = page_write(page, argv[1], &error);
  page_free(page);
  return result == 0 ? APP_OK : app_exit(&error);
}
