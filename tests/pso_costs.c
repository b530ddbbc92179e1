/* pso_costs.c: costs for tests/test_pso.py, compiled by it. A cost in C leaves Python's lock
 * alone, so that threads really run side by side, and is fast enough for many seeds. */
#include <math.h>
#include <stddef.h>

double sphere(const double *x, const void *context);
double rosenbrock(const double *x, const void *context);
double quadratic(const double *x, const void *context);
double hole(const double *x, const void *context);
double leg(const double *x, const void *context);

typedef struct sum_context {
  int n;
  double centre[64];
} sum_context;

double sphere(const double *x, const void *context) {
  const sum_context *c = context;
  double sum = 0.0;
  for (int i = 0; i < c->n; i++) sum += (x[i] - c->centre[i]) * (x[i] - c->centre[i]);
  return sum;
}

double rosenbrock(const double *x, const void *context) {
  const sum_context *c = context;
  double sum = 0.0;
  for (int i = 0; i + 1 < c->n; i++) {
    double across = x[i + 1] - x[i] * x[i];
    sum += 100.0 * across * across + (1.0 - x[i]) * (1.0 - x[i]);
  }
  return sum;
}

/* |R b - z|^2 of p columns, rows of length p + 1, and a constant */
typedef struct triangle {
  int p;
  double constant;
  double shank_mass, motor_mass, foot_mass;
  double r[32 * 33];
} triangle;

static double excess(const triangle *t, const double *b) {
  double sum = 0.0;
  for (int i = 0; i < t->p; i++) {
    const double *row = t->r + i * (t->p + 1);
    double residual = row[t->p];
    for (int j = i; j < t->p; j++) residual -= row[j] * b[j];
    sum += residual * residual;
  }
  return sum;
}

double quadratic(const double *x, const void *context) {
  const triangle *t = context;
  return excess(t, x) + t->constant;
}

/* sphere about 0.5, but nothing is defined where x[0] > 0: NaN there, infinite where x[1] > 0 */
double hole(const double *x, const void *context) {
  if (x[0] > 0.0) return nan("");
  return x[1] > 0.0 ? HUGE_VAL : sphere(x, context);
}

/* the leg's nine base parameters of its ten: p[0..2] enter through two numbers only */
double leg(const double *p, const void *context) {
  const triangle *t = context;
  double b[9] = {p[0] + t->shank_mass * p[1] * p[1] + t->motor_mass * p[2] * p[2],
                 t->shank_mass * p[1] + t->motor_mass * p[2], t->foot_mass * p[3],
                 p[4] + t->foot_mass * p[3] * p[3]};
  for (int i = 5; i < 10; i++) b[i - 1] = p[i];
  return excess(t, b) + t->constant;
}
