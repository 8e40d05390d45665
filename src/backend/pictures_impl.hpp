// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "backend/field_mirror.hpp"
#include "core/parallel.hpp"
#include "render/picture_kernel.hpp"
#include "render/picture_maker.hpp"
#include "render/specialise.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/render/render_image.hpp"

namespace splinevox {

/// PictureMaker on any executor.
template <class Executor>
class Pictures final : public PictureMaker {
 public:
  explicit Pictures(const VoxelModel& model) : model_(model) {
    radiance_.upload(run_, model.radiance.raw.topology);
    run_.upload(rows_, model.radiance.raw.values.data(), model.radiance.raw.values.size());
    if (!model.motion.levels.empty()) motion_.upload(run_, model.motion.levels.back().topology);
  }
  void set_time(const MotionSlice& slice, const BitGrid& occupied) override {
    run_.upload(slice_, slice.values.data(), slice.values.size());
    run_.upload(bits_, occupied.bits.data(), occupied.bits.size());
    occupancy_ = occupied.view();
    occupancy_.bits = bits_.data();
  }
  void draw(const Camera& camera, float step, float stop, Rendered& out) override {
    FieldView<float> field = view_field(model_, rows_.data(), step);
    field.radiance = radiance_.brick_view();
    if (field.moving) field.motion = motion_.brick_view();
    const int most = most_samples(model_.box, step);
    if (most > MarchList::kMostSamples)
      fail({"the march step", "a ray would have too many samples for the device",
            "at most " + std::to_string(MarchList::kMostSamples), std::to_string(most), "--device cpu"});
    run_.resize(pixels_, std::size_t(camera.width) * camera.height);
    specialise(model_.radiance.sh_order, field.moving, [&]<int Sh, bool Moving>() {
      using Kernel = PictureKernel<Sh, Moving>;
      const Kernel kernel{field, {slice_.data(), occupancy_}, camera, model_.box, stop, most, pixels_.data()};
      run_.for_teams(kernel.count(), kernel, Kernel::scratch_bytes(most));
    });
    host_.resize(pixels_.size());
    run_.download(pixels_, host_.data());
    const bool one_colour = !model_.background.learned() && !model_.surroundings.any();
    parallel_for(camera.height, [&](int y) {
      for (int x = 0; x < camera.width; ++x) {
        const std::size_t i = std::size_t(y) * camera.width + x;
        const Pixel& p = host_[i];
        // One colour needs no ray, and neither does what does not show.
        const Vec3 behind = !one_colour && p.transmittance > 0
                                ? model_.behind(camera_ray(camera, x + 0.5, y + 0.5))
                                : model_.background.color;
        const Vec3 rgb = p.rgb + p.transmittance * behind;
        for (int c = 0; c < 3; ++c) {
          out.rgb.data[3 * i + c] = rgb[c];
          out.flow.data[3 * i + c] = p.flow[c];
        }
        out.alpha.data[i] = 1 - p.transmittance;
        out.depth.data[i] = p.depth;
        out.rigidity.data[i] = p.rigidity;
      }
    });
  }

 private:
  const VoxelModel& model_;
  Executor run_;
  LatticeMirror<Executor> radiance_, motion_;
  typename Executor::template Buffer<float> rows_, slice_;
  typename Executor::template Buffer<std::uint32_t> bits_;
  typename Executor::template Buffer<Pixel> pixels_;
  OccupancyView<float> occupancy_;
  std::vector<Pixel> host_;
};

}  // namespace splinevox
