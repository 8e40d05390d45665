// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "data/synth/paint.hpp"
#include "data/synth/scene.hpp"

namespace splinevox {

struct SynthMoment::Posed {
  std::shared_ptr<const SynthScene::Content> content;
  double light = 1;  ///< at this time
  std::vector<data::Pose> now;
  std::vector<data::Bound> bounds;
  data::Bound all;  ///< a ball about the origin that holds every body
  std::optional<SynthVolume> gas;

  double distance(std::size_t body, const Vec3d& p) const {
    return data::distance_to(content->bodies[body].shape, now[body], p);
  }
};

namespace {

constexpr double kTouch = 1e-7;  ///< a ray this close to a surface has met it; then the root is polished
constexpr int kMaxMarch = 400;
constexpr std::size_t kMaxBodies = 64;  ///< of one scene, see SynthScene::open

/// Where the ray first touches a body before `limit`, or a negative number: steps by the distance bound, then
/// the secant method down to rounding.
double first_touch(const SynthMoment::Posed& posed, std::size_t body, const Ray& ray, double from,
                   double limit) {
  const auto gap = [&](double s) { return posed.distance(body, ray.origin + s * ray.direction); };
  double s = from, before = from, g = 0, g_before = 0;
  for (int i = 0; i < kMaxMarch; ++i) {
    g = gap(s);
    if (g < kTouch) {
      for (int k = 0; k < 6 && g_before > g && g != 0; ++k) {
        const double next = s + std::clamp(g * (s - before) / (g_before - g), -1e-4, 1e-4);
        before = std::exchange(s, next);
        g_before = std::exchange(g, gap(s));
        if (std::abs(g) >= std::abs(g_before)) break;
      }
      return s;
    }
    before = s;
    g_before = g;
    s += g;
    if (s > limit) return -1;
  }
  return -1;
}

Vec3d normal_at(const SynthMoment::Posed& posed, std::size_t body, const Vec3d& p) {
  constexpr double h = 1e-5;
  Vec3d sum{};
  for (const Vec3d& corner : {Vec3d{1, -1, -1}, Vec3d{-1, -1, 1}, Vec3d{-1, 1, -1}, Vec3d{1, 1, 1}})
    sum += posed.distance(body, p + h * corner) * corner;
  const double l = length(sum);
  return l > 0 ? (1 / l) * sum : Vec3d{0, 0, 1};
}

/// Lambert under a warm light from a fixed side, with ambient light that is a little stronger from above and
/// no shadows: unless the look asks for more, a point's colour changes only as its surface turns. Gloss is
/// Blinn's highlight.
Vec3d shade(const Vec3d& albedo, const Vec3d& normal, const Vec3d& along, double gloss, double light_now) {
  static const Vec3d to_light = normalize(Vec3d{0.45, -0.55, 0.9});
  const double sun = std::max(0.0, dot(normal, to_light)), sky = 0.5 + 0.5 * normal.z;
  const Vec3d light = sun * Vec3d{0.50, 0.47, 0.42} + data::mix({0.50, 0.48, 0.49}, {0.60, 0.61, 0.64}, sky);
  const double shine =
      gloss > 0 ? gloss * std::pow(std::max(0.0, dot(normal, normalize(to_light - along))), 12) : 0;
  const Vec3d c = light_now * (mul(albedo, light) + Vec3d{shine, shine, shine});
  return {std::clamp(c.x, 0.0, 1.0), std::clamp(c.y, 0.0, 1.0), std::clamp(c.z, 0.0, 1.0)};
}

}  // namespace

SynthMoment SynthScene::at(double time) const {
  auto posed = std::make_shared<SynthMoment::Posed>();
  posed->content = content_;
  const double repeats = content_->look.repeats;
  const double t =
      repeats == 1 ? time : 0.5 * (1 - std::cos(M_PI * repeats * time));  // there and back, without a jerk
  posed->light = content_->look.light * (1 - content_->look.fade * std::clamp(time, 0.0, 1.0));
  for (const data::Body& body : content_->bodies) {
    posed->now.push_back(body.pose(t));
    posed->bounds.push_back(data::bound_of(body.shape, posed->now.back()));
    const data::Bound& bound = posed->bounds.back();
    posed->all.radius = std::max(posed->all.radius, length(bound.centre) + bound.radius);
  }
  if (content_->gas) posed->gas = data::gas_at(*content_->gas, t, posed->light);
  return SynthMoment(std::move(posed));
}

bool SynthScene::has_gas() const { return content_->gas != nullptr; }

Box SynthScene::box() const {
  constexpr int kMoments = 64;
  Box box{{0, 0, 0}, {0, 0, 0}};
  if (content_->gas) {
    const SynthVolume all = data::gas_lattice();
    box = {cast<float>(all.origin), cast<float>(all.position(all.size - Int3{1, 1, 1}))};
  }
  for (int i = 0; i <= kMoments; ++i) {
    const SynthMoment moment = at(double(i) / kMoments);
    for (std::size_t body = 0; body < content_->bodies.size(); ++body) {
      const auto [lo, hi] = data::world_box(moment.posed_->bounds[body], moment.posed_->now[body]);
      box = {min(box.lo, cast<float>(lo)), max(box.hi, cast<float>(hi))};
    }
  }
  return box;
}

std::optional<SynthHit> SynthMoment::trace(const Ray& ray) const {
  if (!posed_->all.met_by(ray.origin, ray.direction)) return {};
  double nearest = std::numeric_limits<double>::infinity();
  std::optional<std::size_t> found;
  struct Candidate {
    double from, to;
    std::size_t body;
  };
  std::array<Candidate, kMaxBodies> candidates;
  std::size_t count = 0;
  for (std::size_t body = 0; body < posed_->now.size(); ++body) {
    if (!posed_->bounds[body].met_by(ray.origin, ray.direction)) continue;
    const auto [from, to] = data::inside(posed_->bounds[body], posed_->now[body], ray.origin, ray.direction);
    if (from <= to) candidates[count++] = {from, to, body};
  }
  std::sort(candidates.begin(), candidates.begin() + std::ptrdiff_t(count),
            [](const Candidate& a, const Candidate& b) { return a.from < b.from; });
  for (std::size_t i = 0; i < count && candidates[i].from <= nearest; ++i) {
    const auto [from, to, body] = candidates[i];
    const double s = first_touch(*posed_, body, ray, from, std::min(to, nearest));
    if (s < 0 || s >= nearest) continue;
    nearest = s;
    found = body;
  }
  if (!found) return {};
  const data::Body& body = posed_->content->bodies[*found];
  SynthHit hit;
  hit.body = int(*found);
  hit.along = nearest;
  hit.position = ray.origin + nearest * ray.direction;
  const Vec3d material = data::material_of(body.shape, posed_->now[*found], hit.position);
  hit.rest = data::world_of(posed_->content->rest[*found], material);
  hit.normal = normal_at(*posed_, *found, hit.position);
  hit.colour =
      shade(body.paint(material), hit.normal, ray.direction, posed_->content->look.gloss, posed_->light);
  return hit;
}

Vec3d SynthMoment::world_from_rest(int body, const Vec3d& rest) const {
  const auto i = std::size_t(body);
  const SynthScene::Content& content = *posed_->content;
  return data::world_of(posed_->now[i], data::material_of(content.bodies[i].shape, content.rest[i], rest));
}

double SynthMoment::distance(int body, const Vec3d& world) const {
  return posed_->distance(std::size_t(body), world);
}

const SynthVolume* SynthMoment::gas() const { return posed_->gas ? &*posed_->gas : nullptr; }

int SynthMoment::bodies() const { return int(posed_->now.size()); }

int SynthMoment::subjects() const { return posed_->content->subjects; }

}  // namespace splinevox
