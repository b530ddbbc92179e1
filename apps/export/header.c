/* header.c: writes the header, see header.h. */
#include "header.h"

#include <ctype.h>
#include <inttypes.h>
#include <string.h>

#include "common/error.h"

enum scalar { F64, F32, Q31 };
static const char *const suffix[] = {"f64", "f32", "q31"};

int header_name(const char *path, char *name, size_t size) {
  const char *slash = strrchr(path, '/'), *begin = slash ? slash + 1 : path, *dot = strrchr(begin, '.');
  size_t n = dot && dot != begin ? (size_t)(dot - begin) : strlen(begin), i;

  if (n == 0 || n >= size || isdigit((unsigned char)begin[0])) return -1;
  for (i = 0; i < n; i++) {
    if (!isalnum((unsigned char)begin[i]) && begin[i] != '_') return -1;
    name[i] = begin[i];
  }
  name[n] = 0;
  return 0;
}

/* one number of a struct or a knot in the scalar's own writing; they read back to the same bits */
static void put(struct output *out, enum scalar kind, const void *at, int index) {
  if (kind == Q31) {
    int32_t q = ((const int32_t *)at)[index];
    /* -2^31 has no literal of its own type */
    if (q == INT32_MIN)
      output_text(out, "INT32_MIN");
    else
      output_printf(out, "%" PRId32, q);
  } else if (kind == F32) {
    float x = ((const float *)at)[index];
    output_printf(out, x < 1e6f && x > -1e6f && x == (float)(int)x ? "%.1ff" : "%.9gf", (double)x);
  } else {
    output_printf(out, "%.17g", ((const double *)at)[index]);
  }
}

static size_t place(const tl_controller_field *f, enum scalar kind) {
  return kind == F64 ? f->f64 : kind == F32 ? f->f32 : f->q31;
}

static void put_fields(struct output *out, enum scalar kind, const void *from, const tl_controller_field *f,
                       int n, const char *indent) {
  int i, k;

  for (i = 0; i < n; i++) {
    const void *at = (const char *)from + place(&f[i], kind);

    output_printf(out, "%s.%s = %s", indent, f[i].name, f[i].count > 1 ? "{" : "");
    for (k = 0; k < f[i].count; k++) {
      if (k) output_text(out, ", ");
      put(out, kind, at, k);
    }
    output_text(out, f[i].count > 1 ? "},\n" : ",\n");
  }
}

/* a curve's numbers; its knots are in the array of the header, from `first` on */
static int put_curve(struct output *out, enum scalar kind, const char *name, const void *curve,
                     const char *field, int first) {
  const tl_curve_f64 *d = curve;
  const tl_curve_f32 *f = curve;
  const tl_curve_q31 *q = curve;
  int n = kind == F64 ? d->n : kind == F32 ? f->n : q->n;

  if (!n) return 0;
  output_printf(out, "         .%s = {%s_knot_%s + %d, %d, ", field, name, suffix[kind], first, n);
  if (kind == F64)
    output_printf(out, "%.17g, %.17g},\n", d->first, d->per_step);
  else if (kind == F32)
    output_printf(out, "%.9gf, %.9gf},\n", (double)f->first, (double)f->per_step);
  else
    output_printf(out, "%" PRId32 ", %" PRIu32 "u, %" PRIu32 ", %" PRIu32 "u},\n", q->first, q->span, q->up,
                  q->per_step);
  return n;
}

static void put_knots(struct output *out, enum scalar kind, const char *name, const void *knot, int n) {
  int i;

  if (!n) return;
  output_printf(out, "static const tl_curve_knot_%s %s_knot_%s[%d] = {\n", suffix[kind], name, suffix[kind],
                n);
  for (i = 0; i < n; i++) {
    output_text(out, "    {");
    put(out, kind, knot, 2 * i);
    output_text(out, ", ");
    put(out, kind, knot, 2 * i + 1);
    output_text(out, "},\n");
  }
  output_text(out, "};\n");
}

static void put_joint(struct output *out, enum scalar kind, const char *name, const void *joint,
                      const tl_controller_joint_f64 *like, int *first) {
  int n, i;
  const tl_controller_field *f = tl_controller_curves(&n);

  output_text(out, "        {\n");
  for (i = 0; i < n; i++)
    *first += put_curve(out, kind, name, (const char *)joint + place(&f[i], kind), f[i].name, *first);
  f = tl_controller_joint_fields(&n);
  put_fields(out, kind, joint, f, n, "         ");
  output_printf(out, "         .uses = %" PRId32 ", .side = %" PRId32 "},\n", like->uses, like->side);
}

/* the struct of one scalar: `c` and where its joints are */
static void put_controller(struct output *out, enum scalar kind, const struct header_parts *p, const void *c,
                           const void *const joint[TL_CONTROLLER_JOINTS]) {
  int n, first = 0, j;
  const tl_controller_field *f = tl_controller_fields(&n);

  output_printf(out, "static const tl_controller_%s %s_%s = {\n    .joint = {\n", suffix[kind], p->name,
                suffix[kind]);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++)
    put_joint(out, kind, p->name, joint[j], &p->made.f64.joint[j], &first);
  output_text(out, "    },\n");
  put_fields(out, kind, c, f, n, "    ");
  output_printf(out, "    .tilted = %d, .stale_ticks = %d, .decay_ticks = %d, .recover_ticks = %d,\n};\n\n",
                (int)p->made.f64.tilted, (int)p->made.f64.stale_ticks, (int)p->made.f64.decay_ticks,
                (int)p->made.f64.recover_ticks);
}

static void put_limits(struct output *out, const struct header_parts *p) {
  static const char *const joint[] = {"knee", "ankle"};
  char text[512];
  int j;

  output_printf(
      out, "/* Made by talus-export from %s. What is in it, and how it is used: docs/controller.md.\n *\n",
      app_printable(text, sizeof text, p->path, strlen(p->path)));
  output_printf(out, " * Period %g s; zero torque %g s after the last good frame.\n", p->made.settings.tick_s,
                (double)(p->made.f64.stale_ticks + p->made.f64.decay_ticks) * p->made.settings.tick_s);
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    const tl_controller_joint_settings *s = &p->made.settings.joint[j];
    output_printf(out,
                  " * %s: %.6g Nm at the motor, %g A, %g W, %.6g Nm/s; stops %.6g .. %.6g rad;\n"
                  " *   %g of the friction compensated.\n",
                  joint[j], p->made.f64.joint[j].torque_limit_Nm, s->current_limit_A, s->power_limit_W,
                  s->rate_Nm_s, s->low_rad, s->high_rad, s->friction_share);
  }
}

static void put_bound(struct output *out, const struct header_parts *p) {
  static const char *const joint[] = {"knee", "ankle"};
  int j;

  output_text(out, " *\n * Motor torque in fixed point is off the model's closed form, for every motion "
                   "within these limits, by at\n"
                   " * most (proven; effects as their curves have them)\n");
  for (j = 0; j < TL_CONTROLLER_JOINTS; j++) {
    double error = p->bound.fixed_Nm[j];
    output_printf(out, " *   %s %.2g Nm, %.2g of its torque limit", joint[j], error,
                  error / p->made.f64.joint[j].torque_limit_Nm);
    if (p->bound.curves_Nm[j] > 0.0)
      output_printf(out, "; the curves are off their effects by at most %.2g Nm (sampled)",
                    p->bound.curves_Nm[j]);
    output_text(out, j ? "\n */\n" : "\n");
  }
}

void header_write(struct output *out, struct header_parts *p) {
  const void *const f64[] = {&p->made.f64.joint[0], &p->made.f64.joint[1]};
  const void *const f32[] = {&p->f32.joint[0], &p->f32.joint[1]};
  const void *const q31[] = {&p->q31.joint[0], &p->q31.joint[1]};
  int n = tl_controller_knots(&p->made.f64);
  int fits = tl_controller_to_q31(&p->made.f64, p->knot_q31, &p->q31) == TL_OK;

  tl_controller_to_f32(&p->made.f64, p->knot_f32, &p->f32);
  put_limits(out, p);
  put_bound(out, p);
  output_printf(out,
                "#ifndef TALUS_EXPORT_%s_H\n#define TALUS_EXPORT_%s_H\n\n#include \"talus/controller.h\"\n\n",
                p->name, p->name);
  put_knots(out, F64, p->name, p->made.knot, n);
  put_controller(out, F64, p, &p->made.f64, f64);
  put_knots(out, F32, p->name, p->knot_f32, n);
  put_controller(out, F32, p, &p->f32, f32);
  if (fits) {
    put_knots(out, Q31, p->name, p->knot_q31, n);
    put_controller(out, Q31, p, &p->q31, q31);
  } else {
    output_text(
        out,
        "/* no fixed point: a number of the model or a sum within the limits is beyond its formats */\n\n");
  }
  output_text(out, "#endif\n");
}
