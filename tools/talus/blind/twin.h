/* twin.h: a bench of its own for withheld cases: a leg, or one joint alone, on PD control, integrated by velocity steps with dry
 * friction as a set-valued law. It shares nothing with lib/ on purpose: what it makes must not follow the forms
 * that the diagnosis fits. */
#ifndef BLIND_TWIN_H
#define BLIND_TWIN_H

#include <stddef.h>
#include <stdint.h>

enum { KNEE, ANKLE, JOINTS };
/* Coordinates: mount (sideways, up, rotation), shank and foot from the vertical, both drives as joint angles. */
enum { X, Z, PHI, SHANK, FOOT, DRIVE_K, DRIVE_A, COORDS };
enum { MAX_CONTACTS = 4, MAX_POINTS = 30000, MAX_WAVES = 3, ELEMENTS = 5, HARMONICS = 12 };

typedef struct {
  double coulomb, viscous;
  /* friction laws; form 0 is absent */
  double stribeck_form, stribeck_extra, stribeck_speed, stribeck_power;
  double load_form, load_coef, load_ref, load_rotor;
  double eff_form, eff_driving, eff_back, eff_smooth;
  double asym_coulomb, asym_viscous;
  double nlv_form, nlv_size, nlv_speed, nlv_power;
  double pos_form, pos_size, pos_centre, pos_width, pos_phase;
  double pre_form, pre_share, pre_travel, pre_power, pre_rise, pre_speed;
  double drift_form, drift_size, drift_tau, drift_session, drift_on;
  double walk_size, walk_tau;
  double cross_size, cross_width, cross_phase; /* friction that follows the other joint's angle */
  /* transmission between drive and joint */
  double elastic_form, stiffness, hardening, soft_share, soft_zone, damping, gap_half, gap_coulomb,
      link_share, viscous_share;
  double rotor_share; /* knee: part of I1 that is the drive's */
  double ripple_n[MAX_WAVES], ripple_a[MAX_WAVES], ripple_p[MAX_WAVES]; /* torque at the joint */
  double ripple_load;                                                   /* 1: in proportion to the load */
  double angle_n[MAX_WAVES], angle_a[MAX_WAVES], angle_p[MAX_WAVES];    /* transmission error */
  /* motor and sensor */
  double cog_n[MAX_WAVES], cog_a[MAX_WAVES], cog_p[MAX_WAVES];
  double sat_form, sat_droop, sat_ref, sat_width;
  double dead_zone;
  double delay, lag;
  double enc_n, enc_a, enc_p; /* motor encoder's error */
  /* in parallel with the joint */
  double spring_form, spring_k, spring_k3, spring_zero;
  double wander_a[MAX_WAVES], wander_w[MAX_WAVES], wander_p[MAX_WAVES];
  double hose_torque, hose_travel;
  double product; /* torque by the product of both joints' speeds */
  double offset;  /* a constant torque */
  double torque_constant, current_limit, bandwidth, zeta;
  double
      control_inertia; /* that the control counts with, at the joint; 0: the leg's of the narrow protocol */
} twin_joint;

typedef struct {
  double gravity, ms, ds, i1, mf, df, i_f, mm, dma, ls, ima, ratio;
  double lead, ab, bo, ac, bof, n_ab, n_bo, n_ac; /* the true linkage, and the one the control knows */
  double zero, n_zero;                            /* their nut positions at joint angle 0 */
  double wave_a, wave_w, wave_p; /* a general error of the linkage, motor rad over joint rad */
  double tilt, tilt_foot;
  double x_mass, x_k, x_c, z_mass, z_k, z_c, phi_inertia, phi_k, phi_c, phi_lever;
  double cable, cable_2;
  double bus_a[MAX_WAVES], bus_w[MAX_WAVES], bus_p[MAX_WAVES];
  double jump_s, jump_mass, jump_r, jump_length;
  double fan_a, fan_w, fan_p, fan_on;
  double drag, drag_power, toe_r;
  double temp_rise, temp_tau;
  double alone; /* 1: the knee's drive and the shank are all there is: a pendulum, or a slider (m for rad) */
  double range; /* joint angle beyond which a run is given up; 0: 1.5 */
  twin_joint joint[JOINTS];
  /* the run */
  double step_s, session_s, settle_s, seed, ref_filter;
  double base_hz, harmonics, knee_a[HARMONICS], knee_p[HARMONICS], ankle_a[HARMONICS], ankle_p[HARMONICS];
  double smooth; /* 1: a cubic through the points, else straight lines */
  double points, point_s[MAX_POINTS], point_knee[MAX_POINTS], point_ankle[MAX_POINTS];
} twin_bench;

typedef struct {
  double q[COORDS], v[COORDS], a[COORDS];
  double current[JOINTS], shown[JOINTS];             /* in the winding; what the sensor shows */
  double applied[JOINTS];                            /* friction of the last step [Nm at the joint] */
  double load[JOINTS], load_all[JOINTS];             /* through the gear, without and with losses */
  double motor[JOINTS], ratio[JOINTS], bend[JOINTS]; /* the transmission at q */
  double z[JOINTS][ELEMENTS], hose[JOINTS], walk[JOINTS];
  double reference[JOINTS], reference_v[JOINTS], last_angle[JOINTS];
  double work_in, work_lost;
  uint64_t random;
} twin_state;

/* A dry contact: direction in all coordinates, levels against motion in either direction. */
typedef struct {
  double direction[COORDS], up, down, force;
  int joint;
} twin_contact;

int twin_read(twin_bench *bench, const char *path);
int twin_joints(const twin_bench *b);

double twin_linkage(const twin_bench *b, double angle, double *ratio, double *bend);
double twin_linkage_known(const twin_bench *b, double angle, double *ratio);
void twin_transmission(const twin_bench *b, int joint, double angle, double *motor, double *ratio,
                       double *bend);

size_t twin_basis(const twin_bench *b, double basis[COORDS][COORDS]);
void twin_mass(const twin_bench *b, double t, const twin_state *s, double mass[COORDS][COORDS]);
void twin_zero(twin_bench *b);
void twin_forces(const twin_bench *b, twin_state *s, double t, double *force);
double twin_energy(const twin_bench *b, double t, const twin_state *s);

double twin_motor_torque(const twin_bench *b, const twin_state *s, int joint, double t);
double twin_smooth_friction(const twin_bench *b, const twin_state *s, int joint, double t);
double twin_memory(const twin_bench *b, twin_state *s, int joint);
double twin_dry(const twin_bench *b, const twin_state *s, int joint, double t, double slip);
double twin_beside(const twin_bench *b, twin_state *s, int joint, double t);
void twin_coupling(const twin_bench *b, const twin_state *s, int joint, double *drive_torque,
                   double *joint_torque);
int twin_flexible(const twin_joint *j);
double twin_joint_angle(const double *q, int joint);

void twin_step(const twin_bench *b, twin_state *s, double t);
void twin_control(const twin_bench *b, twin_state *s, double t);
double twin_shown_angle(const twin_bench *b, const twin_state *s, int joint, double ahead_s);
double twin_normal(uint64_t *state);

#endif
