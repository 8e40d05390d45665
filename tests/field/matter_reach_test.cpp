// SPDX-License-Identifier: Apache-2.0
#include "field/matter_reach.hpp"

#include <doctest/doctest.h>

#include <map>
#include <tuple>
#include <vector>

#include "field/edit/edit_motion.hpp"
#include "math/activation.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;

namespace {

using Key = std::tuple<float, float, float>;

/// Weights of all vertices with matter, by asking everywhere.
std::map<Key, float> everywhere(const VoxelModel& model, double parameter, int stride) {
  const FrameSampler sampler(model, FrameSampler::AtParameter{parameter});
  const Lattice& lattice = model.radiance.raw.topology->lattice;
  std::map<Key, float> out;
  for (int x = 0; x < lattice.size.x; x += stride)
    for (int y = 0; y < lattice.size.y; y += stride)
      for (int z = 0; z < lattice.size.z; z += stride) {
        const Vec3 p = lattice.position({x, y, z});
        const float weight = one_minus_exp_neg(sampler.density(p) * lattice.spacing);
        if (weight >= 1e-2f) out[{p.x, p.y, p.z}] = weight;
      }
  return out;
}

std::map<Key, float> visited(const VoxelModel& model, double parameter, int stride) {
  std::vector<std::map<Key, float>> slabs(std::size_t(matter_slabs(model, stride)));
  visit_matter(model, parameter, stride, [&](int slab, const MatterSample& s) {
    slabs[std::size_t(slab)][{s.x.x, s.x.y, s.x.z}] = s.weight;
  });
  std::map<Key, float> out;
  for (auto& slab : slabs) out.merge(slab);
  return out;
}

}  // namespace

TEST_SUITE("field/matter_reach") {
  TEST_CASE("places with matter are found as by asking everywhere") {
    VoxelModel faint =
        test::noisy_model(4, 5, FirstPoint::free, BasisKind::bspline, 0, true, false, /*presence=*/true);
    faint.radiance.activation = {10, -4};
    const std::vector<VoxelModel> models{test::blob_model(33, {.moves = false}),
                                         test::blob_model(40, {.points = 4, .twist = 0.8f, .rigidity = true}),
                                         std::move(faint)};
    for (std::size_t m = 0; m < models.size(); ++m)
      for (const double parameter : {0.0, 0.7})
        for (const int stride : {1, 2, 3}) {
          CAPTURE(m);
          CAPTURE(parameter);
          CAPTURE(stride);
          const auto expected = everywhere(models[m], parameter, stride);
          CHECK(expected.size() > (stride == 3 ? 10 : 50));
          CHECK(visited(models[m], parameter, stride) == expected);
        }
  }
}
