/* hysteresis.h: laws with a memory, stepped along a recorded motion: friction that is a spring over a small travel, and a
 * link behind a spring and a gap. Effects and their diagnosis take them from here.
 *
 *     tl_spring teeth = {.stiffness_Nm_rad = 3000.0, .gap_rad = 0.005, .soft_share = 1.0};
 *     double loss_W = 0.0, inside = tl_spring_torque(&teeth, 0.002, 0.0, &loss_W); // half the gap to each side
 *     printf("%.1f %.1f\n", inside, tl_spring_torque(&teeth, 0.0035, 0.0, &loss_W)); // prints 0.0 3.0
 */
#ifndef TALUS_HYSTERESIS_H
#define TALUS_HYSTERESIS_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Dahl's friction state in [-1, 1] along a position of n rows, beginning at `first`: dz = s (1 - s z)^power |dx| / travel
 * in the direction s of the motion, power 1 or more; each step in closed form. travel > 0, in the position's unit.
 * (Dahl, "A solid friction model", 1968.) */
void tl_dahl_along(const double *position, size_t n, double travel, double power, double first,
                   double *state);

/* A transmission that twists: teeth that meet after a gap, a spring, its damping. */
typedef struct tl_spring {
  double stiffness_Nm_rad, gap_rad; /* > 0; the whole lost motion, >= 0 */
  double soft_rad, soft_share;      /* up to this twist only this share of the stiffness; 0 rad: none */
  double hardening_Nm_rad3;         /* torque by the twist's cube, >= 0 */
  double damping_Nms_rad;           /* while in contact */
} tl_spring;

/* Its torque at a twist beyond the gap, without damping. */
double tl_spring_elastic(const tl_spring *spring, double twist_rad);
/* Its torque at a twist and its rate, to the side of the twist; teeth push and do not pull. *loss_W gains what the damping
 * takes. The one law of elasticity and backlash, in forward time and along recorded motion. */
double tl_spring_torque(const tl_spring *spring, double twist_rad, double rate_rad_s, double *loss_W);
/* Dahl's law as a rate: z' of a friction state z at speed v, for a travel and a power as in tl_dahl_along. */
double tl_dahl_rate(double v, double z, double travel, double power);

#define TL_TWO_MASS_SETTLE_S 2.0 /* in which a link on its spring comes to rest, of a joint's gear */

/* A link behind a spring and a gap, driven by the motor's recorded motion. */
typedef struct tl_two_mass {
  double stiffness_Nm_rad, gap_rad; /* > 0; the whole lost motion, >= 0 */
  double soft_rad, soft_share;      /* up to this twist only this share of the stiffness; 0 rad: none */
  double hardening_Nm_rad3;         /* torque by the twist's cube, >= 0 */
  double drag_Nm;                   /* dry friction between motor and link, in the gap and out of it, >= 0 */
  double friction_share;            /* of the joint's dry friction that stands on the link's side, 0 to 1 */
  double viscous_share;             /* of its viscous friction, 0 to 1 */
  double inertia_kg_m2;             /* of the link, > 0 */
  double coulomb_Nm, viscous_Nms_rad;
  double damping_s; /* of the spring: its damping over its stiffness */
  double
      settle_s; /* so long the motion runs backwards before its begin, or a wrong one rings; 0: without twist */
  double step_s;
  /* Row by row, where the link's pose counts: its inertia in the place of inertia_kg_m2 (which still sets the number of
   * steps), and by how much its load grows per rad and per rad/s that it runs ahead of the motor. Nullable. */
  const double *row_inertia_kg_m2, *row_stiffness_Nm_rad, *row_damping_Nms_rad;
  const double *
      row_bulge_Nm; /* by how much the load's mean from row k to the next is above that of its ends. Nullable. */
} tl_two_mass;

/* Steps of the link in one sample of step_s: enough for its own oscillation, at most 60. */
int tl_two_mass_steps(const tl_two_mass *link);

/* What comes out of tl_two_mass_along, at its n instants: the link's angle less the motor's, the torque through the
 * spring and the link's acceleration, both means over a sample. */
typedef struct tl_two_mass_motion {
  double *angle_rad, *torque_Nm, *link_rad_s2;
} tl_two_mass_motion;

/* Along the motor's angle and speed (at the joint) at n instants t_s. other_Nm is what the link needs besides its
 * inertia and friction. Leapfrog steps; friction that would reverse the link stops it. */
void tl_two_mass_along(const tl_two_mass *link, const double *t_s, const double *motor_rad,
                       const double *motor_rad_s, const double *other_Nm, size_t n, tl_two_mass_motion *out);

/* Several links, each along a motion of its own: the same as tl_two_mass_along of each, to the bit, in less time. Up to
 * TL_TWO_MASS_LANES neighbours of the list are stepped together where their tl_two_mass_steps are equal. */
#define TL_TWO_MASS_LANES 4
typedef struct tl_two_mass_run {
  tl_two_mass link;
  const double *t_s, *motor_rad, *motor_rad_s, *other_Nm;
  size_t n;
  tl_two_mass_motion out;
} tl_two_mass_run;
void tl_two_mass_along_each(const tl_two_mass_run *run, size_t runs);

#ifdef __cplusplus
}
#endif
#endif
