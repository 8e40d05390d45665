// SPDX-License-Identifier: Apache-2.0
#include "backend/ray_share.hpp"

#include <algorithm>

namespace splinevox {

void RayShare::take(const StepInput& in, const Ranks* ranks) {
  const std::size_t slots = in.times.size();
  drawn_ = own_ = in.rays.size() / slots;
  first_ = 0;
  rays_ = in.rays;
  targets_ = in.targets;
  tasks_ = in.tasks;
  if (!ranks) return;
  first_ = ranks->share_begin(drawn_, ranks->rank());
  own_ = ranks->share_begin(drawn_, ranks->rank() + 1) - first_;
  own_rays_.resize(slots * own_);
  own_targets_.resize(slots * own_);
  own_tasks_.clear();
  for (std::size_t slot = 0; slot < slots; ++slot) {
    std::copy_n(in.rays.data() + slot * drawn_ + first_, own_, own_rays_.data() + slot * own_);
    std::copy_n(in.targets.data() + slot * drawn_ + first_, own_, own_targets_.data() + slot * own_);
    own_tasks_.push_back({int(slot), int(slot * own_), int((slot + 1) * own_)});
  }
  rays_ = own_rays_;
  targets_ = own_targets_;
  tasks_ = own_tasks_;
}

int RayShare::in_batch(int ray) const {
  const std::size_t slot = std::size_t(ray) / own_;
  return int(slot * drawn_ + first_ + std::size_t(ray) % own_);
}

}  // namespace splinevox
