// SPDX-License-Identifier: Apache-2.0
#include "rays.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "math/aabb.hpp"
#include "math/camera.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::mlp {
namespace {

/// Fills tensors of rays and colours pixel by pixel.
class Rows {
 public:
  explicit Rows(int64_t n)
      : rays_{torch::zeros({n, 3}), torch::zeros({n, 3}), torch::zeros({n, 1}), torch::zeros({n, 1})},
        color_(torch::zeros({n, 3})) {}
  void add(const Camera& camera, double u, double v, double time, const Box& box) {
    const Ray ray = camera_ray(camera, u, v);
    const Interval inside = intersect(box, ray.origin, ray.direction);
    const double near = inside.far > inside.near ? inside.near : 0,
                 far = inside.far > inside.near ? inside.far : 0;
    for (int a = 0; a < 3; ++a) {
      rays_.origin.data_ptr<float>()[3 * next_ + a] = float(ray.origin[a] + near * ray.direction[a]);
      rays_.direction.data_ptr<float>()[3 * next_ + a] = float(ray.direction[a]);
    }
    rays_.length.data_ptr<float>()[next_] = float(far - near);
    rays_.time.data_ptr<float>()[next_] = float(std::clamp(time, 0.0, 1.0));
    ++next_;
  }
  void color(const std::array<std::uint16_t, 4>& rgba, Vec3 background) {
    const float alpha = rgba[3] * (1 / 65535.0f);
    for (int c = 0; c < 3; ++c)
      color_.data_ptr<float>()[3 * colored_ + c] =
          alpha * (rgba[c] * (1 / 65535.0f)) + (1 - alpha) * background[c];
    ++colored_;
  }
  Rays rays() const { return rays_; }
  torch::Tensor colors() const { return color_; }

 private:
  Rays rays_;
  torch::Tensor color_;
  int64_t next_ = 0, colored_ = 0;
};

template <class Visit>
void visit_strided(int width, int height, int stride, Visit&& visit) {
  for (int y = stride / 2; y < height; y += stride)
    for (int x = stride / 2; x < width; x += stride) visit(x, y);
}

Picture shrink(const Picture& image, int block) {
  Image16 cut{image.width / block * block, image.height / block * block, {}};
  for (int y = 0; y < cut.height; ++y)
    for (int x = 0; x < cut.width; ++x)
      for (const std::uint16_t v : image.pixel(x, y)) cut.rgba.push_back(v);
  return area_downscale(std::move(cut), block);
}

}  // namespace

Rays view_rays(const Camera& camera, double time, const Box& box, int stride) {
  Rows rows(int64_t(strided(camera.width, stride)) * strided(camera.height, stride));
  visit_strided(camera.width, camera.height, stride,
                [&](int x, int y) { rows.add(camera, x + 0.5, y + 0.5, time, box); });
  return rows.rays();
}

torch::Tensor view_colors(const Picture& image, Vec3 background, int stride) {
  Rows rows(int64_t(strided(image.width, stride)) * strided(image.height, stride));
  visit_strided(image.width, image.height, stride,
                [&](int x, int y) { rows.color(image.pixel(x, y), background); });
  return rows.colors();
}

CropSampler::CropSampler(const Split& train, const Box& box, const Settings& settings)
    : train_(train), box_(box), settings_(settings) {}

void CropSampler::set_shrink(int block) {
  if (block == block_) return;
  block_ = block;
  shrunk_.clear();
  if (block > 1)
    for (const Frame& f : train_.frames) shrunk_.push_back(shrink(f.image, block));
}

CropBatch CropSampler::draw(std::int64_t step) const {
  const Rng rng(settings_.seed, 1 + 16 * std::uint64_t(step));
  const Vec3 background{float(settings_.background[0]), float(settings_.background[1]),
                        float(settings_.background[2])};
  Rows rows(int64_t(settings_.crops) * settings_.crop * settings_.crop);
  for (int c = 0; c < settings_.crops; ++c) {
    const std::size_t f = rng.below(3 * c, std::uint32_t(train_.frames.size()));
    const Frame& frame = train_.frames[f];
    const Picture& image = block_ == 1 ? frame.image : shrunk_[f];
    const auto corner = [&](int draw, int size) {
      return int(rng.below(std::uint64_t(draw), std::uint32_t(std::max(1, size - settings_.crop + 1))));
    };
    const int x0 = corner(3 * c + 1, image.width), y0 = corner(3 * c + 2, image.height);
    for (int y = 0; y < settings_.crop; ++y)
      for (int x = 0; x < settings_.crop; ++x) {
        const int px = std::min(x0 + x, image.width - 1), py = std::min(y0 + y, image.height - 1);
        rows.add(frame.camera, (px + 0.5) * block_, (py + 0.5) * block_, frame.time, box_);
        rows.color(image.pixel(px, py), background);
      }
  }
  return {rows.rays(), rows.colors()};
}

}  // namespace splinevox::mlp
