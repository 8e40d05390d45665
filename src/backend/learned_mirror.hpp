// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "backend/field_mirror.hpp"
#include "backend/step.hpp"
#include "field/learn_kernels.hpp"

namespace splinevox {

/// Words of a mask into another; clears the first.
struct MergeMaskKernel {
  std::uint64_t *from, *to;
  const std::uint64_t* among;
  std::size_t words;
  SPLINEVOX_HD std::size_t count() const { return words; }
  SPLINEVOX_HD void operator()(std::size_t i) const {
    to[i] |= from[i] & among[i];
    from[i] = 0;
  }
};

/// LearnedRows in an executor's memory, with a gradient.
template <class Executor>
struct LearnedMirror {
  template <class T>
  using Buffer = typename Executor::template Buffer<T>;
  LatticeMirror<Executor> lattice;
  int width = 0;
  Buffer<float> values, m, v, gradient, rate, weight;
  Buffer<std::uint64_t> touched, visible, marks;  ///< marks: what the step's rays make visible
  std::vector<Buffer<float>> member;
  std::vector<float> threshold, tv, tv_weight;  ///< of total variation: of the model, and of this step
  bool varies = false;                          ///< total variation of this step has weights

  std::size_t rows() const { return lattice.topology->rows(); }

  void upload(Executor& run, const LearnedRows& from) {
    lattice.upload(run, from.values->topology);
    width = from.values->width;
    run.upload(values, from.values->values.data(), from.values->values.size());
    run.upload(m, from.m->data(), from.m->size());
    run.upload(v, from.v->data(), from.v->size());
    run.upload(rate, from.rate.data(), from.rate.size());
    run.resize(gradient, values.size());
    run.zero(gradient);
    run.resize(touched, rows() / 64);
    run.zero(touched);
    run.upload(visible, reinterpret_cast<const std::uint64_t*>(from.visible.data()),
               from.visible.size() * kBrick);
    run.resize(marks, from.visible.size() * kBrick);
    run.zero(marks);
    tv.assign(from.tv.begin(), from.tv.end());
    member.clear();
    threshold.clear();
    for (const Shrink& group : from.shrink) {
      run.upload(member.emplace_back(), group.member.data(), group.member.size());
      threshold.push_back(group.threshold);
    }
  }
  void download(Executor& run, const LearnedRows& to) {
    run.download(values, to.values->values.data());
    run.download(m, to.m->data());
    run.download(v, to.v->data());
    if (!to.visible.empty()) run.download(visible, to.visible.data()->word);
  }

  /// What total variation needs of this step, before any kernel of it is queued.
  void prepare(Executor& run, float scale, float share) {
    tv_weight.resize(tv.size());
    varies = false;
    for (std::size_t k = 0; k < tv.size(); ++k) {
      tv_weight[k] = scale * tv[k] / share;
      varies |= tv_weight[k] > 0;
    }
    run.upload(weight, tv_weight.data(), tv_weight.size());
  }
  void regularise(Executor& run, float share, std::uint64_t draw) {
    if (varies)
      run.for_each(TvKernel{values.data(), weight.data(), gradient.data(), touched.data(),
                            visible.size() > 0 ? visible.data() : nullptr, lattice.view(), width, share,
                            draw});
  }
  /// A prior on this level's curves; on those of `sum` with its gradient here, if it is given, where `among`
  /// has a row.
  template <class Prior>
  void hold_curves(Executor& run, const MotionField& motion, const Prior& prior, float share,
                   std::uint64_t draw, const float* sum = nullptr, const std::uint64_t* among = nullptr) {
    if (!prior.any()) return;
    run.for_each(CurvePriorKernel<Prior>{sum ? sum : values.data(), gradient.data(), touched.data(), rows(),
                                         among, width, motion.stride(), motion.stored_points(),
                                         motion.stored_points() < motion.points, prior, share, draw});
  }
  void check(Executor& run, std::int64_t* bad_rows, float largest) {
    run.for_each(CheckKernel{gradient.data(), touched.data(), bad_rows, rows(), width, largest});
  }
  void update(Executor& run, const std::int64_t* bad, const MomentFactors& factors, float rate_scale) {
    UpdateKernel k{};
    k.values = values.data();
    k.gradient = gradient.data();
    k.m = m.data();
    k.v = v.data();
    k.rate = rate.data();
    k.touched = touched.data();
    k.bad = bad;
    k.rows = rows();
    k.width = width;
    k.groups = int(member.size());
    for (int g = 0; g < k.groups; ++g) {
      k.member[g] = member[g].data();
      k.threshold[g] = threshold[g];
    }
    k.factors = factors;
    k.rate_scale = rate_scale;
    run.for_each(k);
    run.zero(touched);
    if (marks.size() > 0) run.for_each(KeepMarksKernel{visible.data(), marks.data(), bad, marks.size()});
  }
};

}  // namespace splinevox
