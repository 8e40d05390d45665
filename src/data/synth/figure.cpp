// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "data/synth/paint.hpp"
#include "data/synth/scene.hpp"

namespace splinevox::data {
namespace {

// The dancer faces -y and stands on the right foot (+x), which never moves: the chain of joints starts there
// and runs up through the hips. Lengths in scene units.
constexpr double kAnkle = 0.055, kShin = 0.30, kThigh = 0.30, kHip = 0.085, kSpine = 0.34, kShoulder = 0.165;
constexpr double kUpperArm = 0.24, kForearm = 0.22;
constexpr int kPlaitPieces = 4;
constexpr double kPlaitPiece = 0.085;

constexpr int kPelvis = 0, kTorso = 1, kNeck = 2, kHead = 3, kHair = 4, kRight = 5, kLeft = 11, kParts = 17;
constexpr int kThighPart = 0, kShinPart = 1, kFoot = 2, kUpper = 3, kFore = 4,
              kHand = 5;  ///< after kRight, kLeft

struct Skeleton {
  std::array<Place, kParts> part;
  std::vector<Arc> plait;
};

/// A limb that hangs from a joint: its z axis points down, x keeps the figure's x, y its back to front.
Place hang(const Place& joint) { return joint * rotate(turn_x(M_PI)); }

void pose_arm(Skeleton& s, int first, const Place& shoulder, double abduct, double swing, double elbow) {
  const Place upper = hang(shoulder) * rotate(turn_y(abduct) * turn_x(-swing));
  const Place fore = upper * shift(0, 0, kUpperArm) * rotate(turn_y(elbow));
  s.part[std::size_t(first + kUpper)] = upper;
  s.part[std::size_t(first + kFore)] = fore;
  s.part[std::size_t(first + kHand)] = fore * shift(0, 0, kForearm + 0.03);
}

/// All joints at a time in [0, 1]: two beats of the knees, one sway of the hips, arms against each other.
Skeleton pose_figure(double t) {
  const double w = 2 * M_PI * t, beat = 0.5 - 0.5 * std::cos(2 * w), sway = std::sin(w);
  const double bend = 0.12 + 0.30 * beat, tilt = 0.06 + 0.10 * sway, yaw = 0.30 * sway;
  Skeleton s;
  const Place ankle = shift(kHip + 0.05, 0.02, kFloor + kAnkle);
  const Place shin = ankle * rotate(turn_y(-tilt) * turn_x(bend));
  const Place thigh = shin * shift(0, 0, kShin) * rotate(turn_x(-2 * bend));
  const Place hip = thigh * shift(0, 0, kThigh) * rotate(turn_x(bend) * turn_y(tilt));
  const Place pelvis = hip * rotate(turn_z(yaw)) * shift(-kHip, 0, 0);
  s.part[kRight + kFoot] = ankle;
  s.part[kRight + kShinPart] = shin;
  s.part[kRight + kThighPart] = thigh;
  s.part[kPelvis] = pelvis;

  const double kick = 0.5 - 0.5 * std::cos(w), out = 0.20 + 0.55 * kick;
  const Place left_thigh =
      hang(pelvis * shift(-kHip, 0, 0)) * rotate(turn_y(-out) * turn_x(-0.30 - 0.55 * beat));
  const Place left_shin = left_thigh * shift(0, 0, kThigh) * rotate(turn_x(0.35 + 0.75 * beat));
  s.part[kLeft + kThighPart] = left_thigh;
  s.part[kLeft + kShinPart] = left_shin;
  s.part[kLeft + kFoot] = left_shin * shift(0, 0, kShin) * rotate(turn_x(M_PI) * turn_x(-0.15 - 0.25 * kick));

  const Place torso = pelvis * shift(0, 0, 0.05) *
                      rotate(turn_y(-0.16 * sway) * turn_z(0.35 * std::sin(w + 0.5) - 0.17) * turn_x(0.06));
  const Place neck = torso * shift(0, 0, kSpine);
  const Place head = neck * shift(0, 0, 0.05) * rotate(turn_z(-0.4 * sway) * turn_y(0.18 * std::sin(2 * w)));
  s.part[kTorso] = torso;
  s.part[kNeck] = neck;
  s.part[kHead] = s.part[kHair] = head * shift(0, 0, 0.115);

  const double lift = 0.5 - 0.5 * std::cos(w + 0.6), other = 0.5 - 0.5 * std::cos(w - 0.9);
  pose_arm(s, kRight, torso * shift(kShoulder, 0, kSpine - 0.06), 0.85 + 1.35 * lift, 0.35 * sway,
           0.25 + 0.65 * other);
  pose_arm(s, kLeft, torso * shift(-kShoulder, 0, kSpine - 0.06), -0.80 - 1.20 * other, -0.35 * sway,
           -0.25 - 0.75 * lift);

  std::vector<std::pair<double, double>> bends;
  for (int i = 0; i < kPlaitPieces; ++i)
    bends.push_back({2.6 * std::sin(w - 0.5 * i) + 0.01, 2.0 - 1.1 * std::cos(2 * w - 0.6 * i)});
  const Place root = head * shift(0, 0.125, 0.16) * rotate(turn_x(-1.9));
  s.plait = arcs_of(root, kPlaitPiece, bends);
  return s;
}

std::function<Pose(double)> follow(int part) {
  return [part](double t) { return Pose{pose_figure(t).part[std::size_t(part)], {1, 1, 1}, {}}; };
}

Vec3d skin(const Vec3d& m) { return mix(rgb(0xd99a74), rgb(0xc9825c), cloud(14.0 * m)); }

Vec3d face(const Vec3d& m) {
  const auto spot = [&](double x, double z, double r) {
    return edge(r - std::hypot(std::abs(m.x) - x, m.z - z), 0.012);
  };
  const double front = edge(-m.y - 0.03, 0.02);
  Vec3d c = mix(skin(m), rgb(0xd9705c), 0.55 * front * spot(0.062, -0.03, 0.024));
  c = mix(c, rgb(0xf7f3ec), front * spot(0.044, 0.018, 0.026));
  c = mix(c, rgb(0x22303c), front * spot(0.044, 0.016, 0.014));
  const double smile = std::hypot(m.x, m.z + 0.020) - 0.045;
  return mix(c, rgb(0x8a2d2a), front * edge(0.008 - std::abs(smile)) * edge(-0.042 - m.z));
}

Vec3d shirt(const Vec3d& m) {
  const Vec3d c = mix(rgb(0xf4ead5), rgb(0xc8362f), bands(m.z, 0.08, 0.5));
  const double badge = std::hypot(m.x - 0.05, m.z - 0.23);
  const double front = edge(-m.y);
  return mix(mix(c, rgb(0xf2b134), front * edge(0.038 - badge)), rgb(0x27566b), front * edge(0.02 - badge));
}

Vec3d sleeve(const Vec3d& m) { return mix(shirt({1, 1, m.z}), skin(m), edge(m.z - 0.16)); }

Vec3d trousers(const Vec3d& m) {
  const Vec3d cloth = mix(rgb(0x2b4c7e), rgb(0x3d6aa3), cloud(22.0 * m));
  return mix(cloth, rgb(0xe9d9a6), dots(std::atan2(m.y, m.x) / (2 * M_PI) * 6, m.z / 0.075, 0.26));
}

Vec3d turnup(const Vec3d& m) { return mix(trousers(m), rgb(0x16304f), bands(m.z - 0.03, 10, 0.006)); }

Vec3d shoe(const Vec3d& m) {
  return mix(mix(rgb(0x7d2540), rgb(0xa83a55), cloud(20.0 * m)), rgb(0xf5efe2), edge(-0.028 - m.z));
}

Vec3d hair(const Vec3d& m) {
  return mix(rgb(0x3a2116), rgb(0x6d4327),
             0.5 * cloud({30 * m.x, 30 * m.y, 8 * m.z}) + 0.5 * bands(m.x, 0.035, 0.4));
}

Vec3d plait(const Vec3d& m) {
  const double around = std::atan2(m.y, m.x) / (2 * M_PI);
  const Vec3d strand = mix(rgb(0x3a2116), rgb(0x7a4b2b), bands(m.z / 0.07 + around * 2, 1, 0.45));
  return mix(strand, rgb(0xe8b92f), edge(0.022 - std::abs(m.z - 0.285)));
}

void add_limbs(Bodies& bodies, int first) {
  bodies.push_back({make_cone(0.078, 0.058, kThigh), follow(first + kThighPart), trousers});
  bodies.push_back({make_cone(0.058, 0.042, kShin), follow(first + kShinPart), trousers});
  bodies.push_back({make_cone(0.052, 0.042, kUpperArm), follow(first + kUpper), sleeve});
  bodies.push_back({make_cone(0.041, 0.032, kForearm), follow(first + kFore), skin});
  Shape hand = make_ball(0.047);
  hand.flat = {0.75, 1, 1.15};
  bodies.push_back({hand, follow(first + kHand), skin});
  Shape foot = make_box({0.052, 0.105, 0.05}, 0.045);
  const auto pose = [first](double t) {
    return Pose{pose_figure(t).part[std::size_t(first + kFoot)] * shift(0, -0.045, -0.005), {1, 1, 1}, {}};
  };
  bodies.push_back({foot, pose, shoe});
}

}  // namespace

void add_figure(Bodies& bodies) {
  bodies.push_back({make_cone(0.105, 0.095, 0.06, {1.25, 0.85, 1}), follow(kPelvis), turnup});
  bodies.push_back({make_cone(0.088, 0.112, kSpine - 0.10, {1.32, 0.85, 1}), follow(kTorso), shirt});
  bodies.push_back({make_cone(0.045, 0.042, 0.06), follow(kNeck), skin});
  Shape head = make_ball(0.128);
  head.flat = {0.92, 0.96, 1.08};
  bodies.push_back({head, follow(kHead), face});
  Shape cap = make_ball(0.134);
  cap.flat = {0.97, 0.98, 1.02};
  const auto cap_pose = [](double t) {
    return Pose{pose_figure(t).part[kHair] * shift(0, 0.030, 0.030), {1, 1, 1}, {}};
  };
  bodies.push_back({cap, cap_pose, hair});
  add_limbs(bodies, kRight);
  add_limbs(bodies, kLeft);
  const auto width = [](double s) { return 0.050 - 0.045 * s + 0.008 * std::cos(2 * M_PI * s / 0.085); };
  const auto plait_pose = [](double t) { return Pose{{}, {1, 1, 1}, pose_figure(t).plait}; };
  bodies.push_back({make_tube(kPlaitPieces * kPlaitPiece, width, 0.06, 0.65), plait_pose, plait});
}

}  // namespace splinevox::data
