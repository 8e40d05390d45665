// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

class PictureMaker;

/// What one view of a model shows. Each [height * width * channels]; scene units where not said otherwise.
struct Rendered {
  Image rgb;    ///< 3: composited over the background, not clamped
  Image alpha;  ///< 1: 1 - transmittance at the end of the ray
  Image
      depth;   ///< 1: expected distance along the viewing axis over the part that was hit; 0 where alpha is 0
  Image flow;  ///< 3: visibility-weighted displacement to canonical, x' - x
  Image rigidity;  ///< 1: visibility-weighted r in (0, 1): 1 moves, 0 is static
};

struct RenderOptions {
  float stop = 1e-3f;    ///< a ray ends when its transmittance falls below this; colour error <= stop
  float step_scale = 1;  ///< multiplies the model's march step
  int across = 1;  ///< across x across rays go through each pixel, evenly, and layers are their means, that
                   ///< of depth over what is hit; 1 to kMostAcross, or 0: as many as rays_across says
};
inline constexpr int kMostAcross = 8;

/// How many rays a pixel should have along each of its edges: 2 where voxels are so narrow, seen from the
/// camera, that one ray misses some of what its pixel shows, else 1 (docs/experiments.md).
int rays_across(const VoxelModel& model, const Camera& camera);

/// Renders one model, which must outlive it, any number of times. Knows where the canonical volume is empty,
/// and what the last time's slice and occupancy were: views of one time after the other cost only their rays,
/// and so do times at which nothing has moved on, because nothing in the model does or an edit holds it.
class Renderer {
 public:
  explicit Renderer(const VoxelModel& model);
  /// With something else that draws than the calling arena's threads (make_renderer, backend/device.hpp).
  /// @param maker  null: the threads do
  Renderer(const VoxelModel& model, std::unique_ptr<PictureMaker> maker);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();
  /// The model at a time in [0, 1] (clamped). Runs on the TBB threads of the calling arena; the same bits for
  /// any number of threads, and whatever was rendered before. Not for use by two threads at once.
  Rendered render(const Camera& camera, double time, const RenderOptions& options = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// One picture: see Renderer.
Rendered render_image(const VoxelModel& model, const Camera& camera, double time,
                      const RenderOptions& options = {});

}  // namespace splinevox
