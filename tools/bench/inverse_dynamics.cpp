// Inverse dynamics: talus against Pinocchio's rnea, in loops over the same random states.
//
//   inverse_dynamics STATES REPETITIONS
//
// First both compute the same leg (constant ratios, no friction), and their largest
// difference is printed. Then each side is timed in turn: Pinocchio on the plain two
// joints, talus on the leg with linkage and friction, and the controller's whole tick with its checks and limits.
// Prints JSON: processor time of the thread in ns a state.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <vector>

#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>

#include "talus/experimental/controller_prepare.h"
#include "talus/plant.h"

namespace {

const double knee_ratio = 51.0, ankle_ratio = 60.0;

void require(tl_status status) {
  if (status == TL_OK) return;
  std::fprintf(stderr, "inverse_dynamics: %s\n", tl_status_text(status));
  std::exit(1);
}

// the leg of models/leg.yaml, with its linkage and friction
tl_model whole_leg() {
  tl_model m;
  const tl_screw_linkage linkage = {0.002, 0.090, 0.040, 0.035, 84.75};
  require(tl_model_init(&m, TL_PLANT_LEG));
  m.shank_length_m = 0.3615;
  m.shank_mass_kg = 1.624;
  m.shank_com_m = 0.160;
  m.shank_inertia_kg_m2 = 0.0420;
  m.foot_mass_kg = 0.442;
  m.foot_com_m = 0.055;
  m.foot_inertia_kg_m2 = 0.0021;
  m.ankle_motor_mass_kg = 0.4112;
  m.ankle_motor_com_m = 0.120;
  for (tl_drive &drive : m.drive) drive.torque_constant_Nm_A = 0.1031;
  m.drive[0].coulomb_Nm = 1.2;
  m.drive[0].viscous_Nms_rad = 0.45;
  m.drive[1].coulomb_Nm = 0.8;
  m.drive[1].viscous_Nms_rad = 0.30;
  m.drive[1].rotor_inertia_kg_m2 = 2.4e-6;
  require(tl_transmission_fixed(&m.drive[0].transmission, knee_ratio));
  require(tl_transmission_screw_linkage(&m.drive[1].transmission, &linkage));
  require(tl_model_check(&m));
  return m;
}

// the same without what Pinocchio does not have: constant ratio, no friction
tl_model plain_leg() {
  tl_model m = whole_leg();
  require(tl_transmission_fixed(&m.drive[1].transmission, ankle_ratio));
  for (tl_drive &drive : m.drive) drive.coulomb_Nm = drive.viscous_Nms_rad = 0.0;
  return m;
}

// plain_leg for Pinocchio: hanging along -z, turning about y
pinocchio::Model plain_model(const tl_model &m) {
  using pinocchio::Inertia;
  using pinocchio::SE3;
  const auto body = [](double mass, double along, double inertia) {
    const Eigen::Matrix3d about_y = Eigen::Vector3d(0.0, inertia, 0.0).asDiagonal();
    return Inertia(mass, Eigen::Vector3d(0.0, 0.0, -along), about_y);
  };
  pinocchio::Model model;
  const SE3 ankle_place(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.0, 0.0, -m.shank_length_m));
  const auto knee = model.addJoint(0, pinocchio::JointModelRY(), SE3::Identity(), "knee");
  const auto ankle = model.addJoint(knee, pinocchio::JointModelRY(), ankle_place, "ankle");
  model.appendBodyToJoint(knee, body(m.shank_mass_kg, m.shank_com_m, m.shank_inertia_kg_m2));
  model.appendBodyToJoint(knee, body(m.ankle_motor_mass_kg, m.ankle_motor_com_m, 0.0));
  model.appendBodyToJoint(ankle, body(m.foot_mass_kg, m.foot_com_m, m.foot_inertia_kg_m2));
  model.gravity.linear() = Eigen::Vector3d(0.0, 0.0, -m.gravity_m_s2);
  model.armature[1] = m.drive[1].rotor_inertia_kg_m2 * ankle_ratio * ankle_ratio;
  return model;
}

// random states: column i of each matrix, and the same joint after joint for tl_inverse_batch
struct States {
  Eigen::MatrixXd q, v, a;
  std::vector<double> q_by_joint, v_by_joint, a_by_joint, torque_by_joint;

  explicit States(int n) : q(2, n), v(2, n), a(2, n), torque_by_joint(2 * std::size_t(n)) {
    std::mt19937_64 generator(1);
    const auto fill = [&](Eigen::MatrixXd &x, double size) {
      std::uniform_real_distribution<double> uniform(-size, size);
      for (double &value : x.reshaped()) value = uniform(generator);
    };
    fill(q, 0.5);
    fill(v, 4.0);
    fill(a, 40.0);
    q_by_joint = by_joint(q);
    v_by_joint = by_joint(v);
    a_by_joint = by_joint(a);
  }

  static std::vector<double> by_joint(const Eigen::MatrixXd &x) {
    std::vector<double> out;
    for (Eigen::Index j = 0; j < x.rows(); j++)
      for (Eigen::Index i = 0; i < x.cols(); i++) out.push_back(x(j, i));
    return out;
  }

  tl_motion motion(int i) const {
    return {{q(0, i), q(1, i)}, {v(0, i), v(1, i)}, {a(0, i), a(1, i)}, {0.0, 0.0}};
  }
};

// largest difference of the joint torques of the plain leg, relative to the largest torque
double difference(const States &states) {
  const tl_model m = plain_leg();
  const pinocchio::Model model = plain_model(m);
  pinocchio::Data data(model);
  double worst = 0.0, largest = 0.0;
  for (int i = 0; i < states.q.cols(); i++) {
    const tl_motion now = states.motion(i);
    double torque[TL_MAX_JOINTS];
    tl_inverse(&m, &now, torque);
    pinocchio::rnea(model, data, states.q.col(i), states.v.col(i), states.a.col(i));
    worst = std::max({worst, std::fabs(torque[0] * knee_ratio - data.tau[0]),
                      std::fabs(torque[1] * ankle_ratio - data.tau[1])});
    largest = std::max(largest, std::fabs(data.tau[0]));
  }
  return worst / largest;
}

double sink; // what the loops compute, so that they are not left out

double now_ns() {
  timespec now = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * double(now.tv_sec) + double(now.tv_nsec);
}

// one pass over all states [ns a state]
double rnea_pass(const pinocchio::Model &model, pinocchio::Data &data, const States &s) {
  const double begin = now_ns();
  for (int i = 0; i < s.q.cols(); i++) {
    pinocchio::rnea(model, data, s.q.col(i), s.v.col(i), s.a.col(i));
    sink += data.tau[0] + data.tau[1];
  }
  return (now_ns() - begin) / double(s.q.cols());
}

double single_pass(const tl_model &m, const States &s) {
  const double begin = now_ns();
  for (int i = 0; i < s.q.cols(); i++) {
    tl_motion now = s.motion(i);
    double torque[TL_MAX_JOINTS];
    tl_slip_from_velocity(&m, &now);
    tl_inverse(&m, &now, torque);
    sink += torque[0] + torque[1];
  }
  return (now_ns() - begin) / double(s.q.cols());
}

double batch_pass(const tl_model &m, States &s) {
  const std::size_t n = std::size_t(s.q.cols());
  const double begin = now_ns();
  tl_inverse_batch(&m, n, s.q_by_joint.data(), s.v_by_joint.data(), s.a_by_joint.data(), nullptr,
                   s.torque_by_joint.data());
  const double spent = now_ns() - begin;
  for (double torque : s.torque_by_joint) sink += torque;
  return spent / double(n);
}

struct Controller {
  tl_controller_settings settings;
  tl_controller_f64 c;
  std::vector<tl_curve_knot_f64> knot;
  tl_controller_state_f64 state;
  uint32_t ticks;

  explicit Controller(const tl_model &m) : knot(TL_CONTROLLER_KNOTS), ticks(0) {
    int refused;
    tl_controller_defaults(&m, &settings);
    require(tl_controller_prepare(&c, &m, nullptr, 0, &settings, knot.data(), &refused));
    tl_controller_start_f64(&state);
  }
};

// as many ticks as there are states, along sines that a joint can move by
double tick_pass(Controller &controller, const States &s, unsigned *status) {
  std::vector<tl_controller_input_f64> in(std::size_t(s.q.cols()));
  for (tl_controller_input_f64 &one : in) {
    const double at = 1e-3 * ++controller.ticks;
    tl_controller_frame_f64 frame = {};
    for (int j = 0; j < 2; j++) {
      frame.angle_rad[j] = 0.3 * std::sin(5.0 * at + j);
      frame.speed_rad_s[j] = 1.5 * std::cos(5.0 * at + j);
      frame.acceleration[j] = -7.5 * std::sin(5.0 * at + j);
    }
    frame.count = controller.ticks;
    one = {frame, frame, 1};
  }
  tl_controller_output_f64 out;
  const double begin = now_ns();
  for (const tl_controller_input_f64 &one : in) {
    tl_controller_tick_f64(&controller.c, &controller.state, &one, &out);
    sink += out.torque_Nm[0] + out.torque_Nm[1];
  }
  *status = out.status;
  return (now_ns() - begin) / double(in.size());
}

void print_times(const char *name, const std::vector<double> &times) {
  std::printf(", \"%s\": [", name);
  for (std::size_t i = 0; i < times.size(); i++) std::printf("%s%.4f", i ? ", " : "", times[i]);
  std::printf("]");
}

} // namespace

int main(int argc, char **argv) {
  if (argc != 3) return 2;
  States states(std::atoi(argv[1]));
  const tl_model leg = whole_leg();
  const pinocchio::Model model = plain_model(plain_leg());
  pinocchio::Data data(model);
  std::vector<double> rnea, single, batch, tick;
  Controller controller(leg);
  unsigned status = 0;

  std::printf("{\"difference\": %.3g", difference(states));
  for (int repetition = 0; repetition < std::atoi(argv[2]); repetition++) {
    rnea.push_back(rnea_pass(model, data, states));
    single.push_back(single_pass(leg, states));
    batch.push_back(batch_pass(leg, states));
    tick.push_back(tick_pass(controller, states, &status));
  }
  print_times("rnea", rnea);
  print_times("single", single);
  print_times("batch", batch);
  print_times("tick", tick);
  std::printf(", \"status\": %u", status);
  std::printf("}\n");
  return std::isfinite(sink) ? 0 : 1;
}
