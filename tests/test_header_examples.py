"""The examples in the public headers: every header begins with one, each compiles without a warning as a user would have
it, runs without a failure, and prints what it says.

An example is the indented part of a header's first comment. It stands in a function that answers 0; `// prints TEXT`
behind a line says what it prints. GIVEN holds what an example names without having made it.
"""

import re
import subprocess

import pytest
from support import BUILD, REPOSITORY

pytestmark = pytest.mark.release

HEADERS = sorted(str(path.relative_to(REPOSITORY / "include")) for path in (REPOSITORY / "include").rglob("*.h"))
WARNINGS = "-std=c99 -pedantic -Wall -Wextra -Werror -Wno-unused-variable -Wno-unused-but-set-variable -Wno-unused-function".split()

ARM = "static tl_model model; static struct given_recording recorded_arm;"
ARM_BEGIN = "model = given_arm(); given_recording(&model, &recorded_arm);"
BLOCK = """static const uint32_t recorded = TL_CHANNEL_BIT(TL_CHANNEL_TIME) | TL_CHANNEL_BIT(TL_CHANNEL_JOINT)
  | TL_CHANNEL_BIT(TL_CHANNEL_JOINT_TORQUE);
static tl_block block; static tl_stop stops[ROWS]; static double work[1000000]; static const size_t work_n = 1000000;
static const double step_s = STEP_S;"""
BLOCK_BEGIN = """block = (tl_block){.n = ROWS, .t_s = recorded_arm.t_s};
block.channel[TL_CHANNEL_JOINT] = recorded_arm.q; block.channel[TL_CHANNEL_JOINT_TORQUE] = recorded_arm.torque_Nm;"""

# header: (at file scope, before the example)
GIVEN = {
    "talus/controller.h": (
        """static tl_controller_f32 leg; static int frames;
static int receive(tl_controller_input_f32 *in) {
  *in = (tl_controller_input_f32){.enable = 1};
  in->desired.count = in->measured.count = (uint32_t)++frames;
  return frames < 100;
}
static void send(float knee_A, float ankle_A) { if (!(knee_A == 0.0f && ankle_A == 0.0f)) exit(4); }""",
        """tl_model m = given_leg(); tl_controller_settings set; static tl_controller_f64 wide; int refused;
static tl_curve_knot_f64 knot[TL_CONTROLLER_KNOTS]; static tl_curve_knot_f32 knot_f32[TL_CONTROLLER_KNOTS];
tl_controller_defaults(&m, &set);
if (tl_controller_prepare(&wide, &m, NULL, 0, &set, knot, &refused) != TL_OK) return 5;
tl_controller_to_f32(&wide, knot_f32, &leg);""",
    ),
    "talus/drive_table.h": ("static tl_transmission ankle;", "ankle = given_linkage();"),
    "talus/identify.h": (
        f"{ARM} enum {{ n = ROWS }};",
        f"{ARM_BEGIN} double *q = recorded_arm.q, *v = recorded_arm.v, *a = recorded_arm.a, *torque_Nm = recorded_arm.torque_Nm;"
        "model.inertia_kg_m2 *= 2.0;",
    ),
    "talus/kinematics.h": (
        f"{ARM} {BLOCK} static double motion[100000]; static tl_track track;",
        f"""{ARM_BEGIN} {BLOCK_BEGIN} if (tl_track_memory(1, ROWS) > 100000) return 5;
for (int k = 0; k < ROWS; k++) recorded_arm.q[k] = 0.5 * recorded_arm.t_s[k];
tl_track_init(&track, 1, ROWS, motion, stops);""",
    ),
    "talus/marker.h": (
        """static uint8_t bytes[80][120][3]; static tl_image image = {&bytes[0][0][0], sizeof bytes, 360, 120, 80, 3}; static int taken;
static int next_picture(tl_image *picture) { /* a red disc, one pixel further to the right each time */
  for (int y = 0; y < 80; y++) for (int x = 0; x < 120; x++) {
    int inside = (x - 60 - taken) * (x - 60 - taken) + (y - 40) * (y - 40) <= 64;
    bytes[y][x][0] = bytes[y][x][1] = inside ? 20 : 100; bytes[y][x][2] = inside ? 220 : 100;
  }
  return picture == &image && ++taken <= 3;
}""",
        "",
    ),
    "talus/pso.h": (
        """static double cost(const double *x, const void *context) {
  return context ? 0.0 : (x[0] - 1.0) * (x[0] - 1.0) + (x[1] + 2.0) * (x[1] + 2.0);
}""",
        "",
    ),
    "talus/score.h": (
        "enum { n = ROWS }; static double t_s[ROWS], measured_Nm[ROWS], predicted_Nm[ROWS], speed_rad_s[ROWS], work[100000];"
        "static const size_t work_n = 100000;",
        """for (int k = 0; k < n; k++) {
  t_s[k] = k * STEP_S; speed_rad_s[k] = 1.0;
  measured_Nm[k] = sin(5.0 * t_s[k]); predicted_Nm[k] = 0.95 * measured_Nm[k];
}""",
    ),
    "talus/signal.h": (
        "enum { n = ROWS }; static double t_s[ROWS], angle_rad[ROWS], q[ROWS], v[ROWS], a[ROWS];",
        "for (int k = 0; k < n; k++) { t_s[k] = k * STEP_S; angle_rad[k] = 1.5 * t_s[k] * t_s[k]; }",
    ),
    "talus/experimental/controller_prepare.h": (
        "static tl_model model; static tl_effect effect[1]; static int effects;",
        'model = given_leg(); effect[0] = tl_effect_typical(tl_effect_find("stribeck"), 1); effects = 1;',
    ),
    "talus/experimental/effect.h": (
        "static tl_model model; static tl_motion motion; static double t_s;",
        "model = given_leg(); motion.v[1] = 1.0; tl_slip_from_velocity(&model, &motion);",
    ),
    "talus/experimental/excitation.h": ("static tl_model model;", "model = given_leg();"),
    "talus/experimental/regression.h": (
        f"""{ARM} {BLOCK} static tl_score_settings score; static tl_sensing sensing; static tl_layout layout; static tl_span span;
enum {{ rows = ROWS, grid = ROWS }}; static double memory[1000000], scratch[100000]; static uint8_t mask[ROWS]; static tl_factor factor[1];
static int next_block(tl_block *b, tl_span *where) {{
  static int blocks;
  *where = (tl_span){{0.0, b->t_s[b->n - 1], 0.0, HUGE_VAL}};
  return blocks++ == 0;
}}""",
        f"""{ARM_BEGIN} {BLOCK_BEGIN} score = tl_score_defaults(); int index[TL_MAX_ROW];
if (tl_factor_init(&factor[0], tl_row_index(&model, 0, index)) != TL_OK || tl_layout_init(&layout, &model, recorded) != TL_OK) return 5;
if (tl_kinematics_window(&model, &layout, 0, &score, step_s, &block, work, work_n, &sensing) != TL_OK) return 6;
tl_regression given;
if (tl_regression_init(&given, &model, recorded, &score, step_s) != TL_OK) return 7;
given.sensing[0] = sensing;
if (tl_regression_memory(&given, rows, grid) > 1000000) return 8;""",
    ),
    "talus/experimental/simulate.h": ("static tl_model model;", "model = given_arm();"),
    "talus/experimental/twin.h": (
        """static tl_model model; static tl_excitation excitation;
static void keep(double t_s, double current_A) { if (!(t_s >= 0.0 && fabs(current_A) < 50.0)) exit(4); }""",
        "model = given_leg(); if (tl_excitation_paper(&excitation, 2) != TL_OK) return 5; excitation.fade_s = 2.0;",
    ),
}

# What holds of a result that is not printed.
AFTERWARDS = {
    "talus/drive_table.h": "double r, s; tl_transmission_ratio(&ankle, 0.25, &r, &s); if (fabs(ratio - fabs(r)) > 1e-6 * fabs(r)) return 9;",
    "talus/experimental/effect.h": "if (!(joint_Nm > 0.0)) return 9;",
    "talus/experimental/regression.h": "if (factor[0].rows < 800) return 9;",
}


def example_of(header):
    """The lines of code in the first comment of a header."""
    comment = (REPOSITORY / "include" / header).read_text().split("*/")[0]
    return [line[7:] for line in comment.splitlines() if line.startswith(" *     ")]


def program_of(header):
    """A program that runs the example, and the lines that it says it prints."""
    lines, (scope, before) = example_of(header), GIVEN.get(header, ("", ""))
    includes = [line for line in lines if line.startswith("#include")]
    body = "\n".join(line for line in lines if line not in includes)
    text = f"""#include "{header}"
{chr(10).join(includes)}
#include "header_given.h"
{scope}
static int example(void) {{
{before}
{{
{body}
{AFTERWARDS.get(header, "")}
}}
return 0;
}}
int main(void) {{ return example(); }}
"""
    return text, re.findall(r"// prints (.*)$", body, re.MULTILINE)


@pytest.mark.parametrize("header", HEADERS)
def test_the_example_of_a_header(header, tmp_path):
    text, shown = program_of(header)
    (tmp_path / "example.c").write_text(text)
    folders = [f"-I{REPOSITORY / folder}" for folder in ("include", "tests")]
    compiled = ["cc", *WARNINGS, *folders, "-o", tmp_path / "example", tmp_path / "example.c", BUILD / "lib/libtalus.a", "-lm"]
    done = subprocess.run(compiled, check=False, capture_output=True, text=True)
    assert example_of(header), "no example"
    assert done.returncode == 0, done.stderr
    ran = subprocess.run([tmp_path / "example"], check=False, capture_output=True, text=True, timeout=60)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert ran.stdout.splitlines() == shown


def test_nothing_is_given_to_no_header():
    assert set(GIVEN) | set(AFTERWARDS) <= set(HEADERS)
