// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/photometric.hpp"
#include "render/accumulate.hpp"
#include "render/march.hpp"
#include "render/ray_losses.hpp"

namespace splinevox {

/// What a ray gave besides gradients.
struct RayOutcome {
  Vec3 error;  ///< photometric
  float motion_loss;
  std::int32_t samples;  ///< in stored bricks
  std::int32_t usable;   ///< 0: the loss or a gradient is not finite, or too large
};

/// Forward and backward along one ray by a team. Forward keeps which samples it shaded and the last kLanes of
/// them; backward goes from the last to the first, shades again what is no longer there (most rays have no
/// more than kLanes samples) and adds the gradients. The loss is that of Engine.
/// @tparam Jet  whether offset or divergence losses may be asked for.
template <int Sh, bool Moving, bool Jet>
struct TrainKernel {
  using Radiance = Shaded<Sh, Moving>;

  FieldView<float> field;
  const FrameView<float>* frames;  ///< [slots]
  const RayInput<float>* rays;     ///< [n] grouped by slot
  const Vec3* targets;             ///< [n]
  RayOutcome* outcomes;            ///< [n]
  int rays_per_slot, most_samples;
  RayLosses losses;
  float largest;  ///< a gradient beyond it is not usable
  GradientRows radiance;
  const GradientRows* motion;  ///< [slots] of kSliceWidth columns, one mask for all
  Vec3* behind;                ///< [n] gradient of the colour behind each ray; null: not wanted

  static std::size_t scratch_bytes(int most_samples) {
    return Stage<Jet>::kBytes + kLanes * sizeof(float) + MarchList::bytes(most_samples);
  }

  template <class Team>
  SPLINEVOX_HD void operator()(int index, const Team& team) const {
    RayInput<float> ray = rays[index];
    if (ray.count > most_samples) ray.count = most_samples;  // what the list has room for
    const int slot = index / rays_per_slot;
    const FrameView<float> frame = frames[slot];
    const RowHarmonics<Sh> harmonics(ray.direction);
    const Stage<Jet> stage{reinterpret_cast<float*>(team.scratch())};
    const MarchList list(team.scratch() + Stage<Jet>::kBytes + kLanes * sizeof(float), most_samples);
    typename Team::template Lanes<Radiance> sample;
    // In memory, because they live as long as the ray, and registers are few: the lanes' largest weights,
    // then the weight from which on a sample is visible.
    float* const heaviest = reinterpret_cast<float*>(team.scratch() + Stage<Jet>::kBytes);
    team.each([&](int lane) { heaviest[lane] = 0; });
    const Marched m = march<Sh, Moving>(team, ray, field, frame, harmonics, losses.stop, list, sample,
                                        [&](int lane, auto&&, float w, int) {
                                          if (w > heaviest[lane]) heaviest[lane] = w;
                                        });
    if (radiance.marks) {
      typename Team::template Lanes<float> most;
      team.each([&](int lane) { most[lane] = heaviest[lane]; });
      const float all = team.max(most), never = 2;  // no weight is beyond 1
      const float enough =
          has_matter(targets[index], ray.background, losses.faintest) ? losses.visible_share * all : never;
      team.each([&](int lane) { heaviest[lane] = enough; });
    }
    // Kept doubled and weighted, as the sweep needs it. What that adds is taken off again at the end, exactly
    // where the weight is 1.
    const Vec3 d_rgb =
        photometric_gradient(m.rgb + m.transmittance * ray.background, targets[index], ray.weight);

    // Of the gradient: what is behind the samples to come.
    float rest = composite_end(m.transmittance, ray.background, d_rgb, losses.transmittance);
    if (behind)
      team.each([&](int lane) {
        if (lane == 0) behind[index] = m.transmittance * d_rgb;
      });
    team.sync();
    typename Team::template Lanes<float> value;
    typename Team::template Lanes<bool> bad;
    team.each([&](int lane) {
      value[lane] = 0;
      bad[lane] = false;
    });
    for (int first = (m.live - 1) / kLanes * kLanes; m.live > 0 && first >= 0; first -= kLanes) {
      const int n = m.live - first < kLanes ? m.live - first : kLanes;
      const bool gone = first + kLanes < m.live;  // the last chunk is still there
      typename Team::template Lanes<float> before, later, share, weight;
      team.each([&](int lane) {
        if (lane >= n) {
          sample[lane].stored = false;
          sample[lane].passed = 1;
        } else if (gone) {
          sample[lane] = shade_sample<Sh, Moving>(ray, list.index[first + lane], field, frame, harmonics);
        }
        before[lane] = sample[lane].passed;
      });
      team.product_before(before);
      const float start = list.before[first / kLanes];
      team.each([&](int lane) {
        before[lane] *= start;
        share[lane] = sample[lane].stored
                          ? composite_share(sample[lane].emission, before[lane] * sample[lane].alpha, d_rgb)
                          : 0.0f;
        later[lane] = share[lane];
      });
      const float all = team.sum_after(later);

      typename Team::template Lanes<bool> keep, shows;
      typename Team::template Lanes<SampleGradient<Sh>> gradient;
      typename Team::template Lanes<Place> place;
      team.each([&](int lane) {
        const Radiance& s = sample[lane];
        const float w = weight[lane] = s.stored ? before[lane] * s.alpha : 0.0f;
        keep[lane] = s.stored && !(w < losses.min_weight);
        shows[lane] = keep[lane] && radiance.marks && w > 0 && !(w < heaviest[lane]);
        if (!keep[lane]) return;
        const EmissionAdjoint<float> d = emission_vjp(
            s.emission,
            composite_vjp(s.emission, w, before[lane] * s.passed, field.step, rest + later[lane], d_rgb));
        gradient[lane] = sample_vjp(s, d, field, harmonics, rays[index], w);
        SPLINEVOX_UNROLL for (const Pack& p : gradient[lane].radiance)
            SPLINEVOX_UNROLL for (const float g : p.v) bad[lane] |= !(g < largest && g > -largest);
        place[lane] = s.at;
      });
      const std::uint32_t kept = team.ballot(keep), visible = team.ballot(shows);
      SPLINEVOX_UNROLL for (int k = 0; k < Radiance::kWidth; k += 8) {
        team.sync();
        team.each([&](int lane) {
          if (keep[lane])
            SPLINEVOX_UNROLL for (int c = 0; c < 8; ++c) stage.row(lane)[c] =
                gradient[lane].radiance[(k + c) / Pack::kSize][c % Pack::kSize];
        });
        team.sync();
        constexpr int kUsed = 4 + RowHarmonics<Sh>::kCount;
        accumulate<false>(team, field.radiance, place, kept, visible, stage, k, kUsed - k < 8 ? kUsed - k : 8,
                          k == 0, radiance);
      }
      if constexpr (Moving) {
        const Vec3 probe = Jet ? draw_probe(losses.probe_seed, std::size_t(index))
                               : Vec3{};  // here, where registers are free for it
        team.sync();
        team.each([&](int lane) {
          if (!keep[lane]) return;
          const Radiance& s = sample[lane];
          float* row = stage.row(lane);
          Pack g = gradient[lane].motion;
          if constexpr (Jet) {
            float h[3][4] = {};
            value[lane] += motion_loss_sample(jet_of(s, frame), losses.motion, probe, weight[lane],
                                              field.motion.inv_spacing, g, h);
            SPLINEVOX_UNROLL for (int a = 0; a < 3; ++a) SPLINEVOX_UNROLL for (int c = 0; c < 4; ++c) {
              row[8 + 4 * a + c] = h[a][c];
              bad[lane] |= !(h[a][c] < largest && h[a][c] > -largest);
            }
          }
          SPLINEVOX_UNROLL for (int c = 0; c < 4; ++c) {
            row[c] = g[c];
            bad[lane] |= !(g[c] < largest && g[c] > -largest);
          }
          SPLINEVOX_UNROLL for (int i = 0; i < kScalars; ++i) {
            const float slope = gradient[lane].scalars[i];
            row[kSliceScalars + i] = slope;
            bad[lane] |= !(slope < largest && slope > -largest);
          }
          place[lane] = s.observed;
        });
        team.sync();
        accumulate<Jet>(team, field.motion, place, kept, 0, stage, 0, field.slice_used, true, motion[slot]);
      }
      rest += all;
    }
    const Vec3 error = (0.5f / rays[index].weight) * d_rgb;
    const float loss = team.sum(value), squared = dot(error, error);
    const bool usable = team.ballot(bad) == 0 && loss + squared < largest;
    team.each([&](int lane) {
      if (lane == 0) outcomes[index] = {error, loss, m.stored, usable};
    });
  }

 private:
  SPLINEVOX_HD MotionJet<float> jet_of(const Radiance& s, const FrameView<float>& frame) const {
    const TrilinearValue<Pack> v =
        gather_pack(field.motion.rows(s.observed.cell), s.observed.fraction, frame.slice, kSliceWidth, 0);
    return motion_jet(v, field.motion.inv_spacing, s.r, s.r_slope);
  }
};

}  // namespace splinevox
