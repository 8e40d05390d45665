// SPDX-License-Identifier: Apache-2.0
#include "train/home.hpp"

#include <utility>

namespace splinevox {
namespace {

StepModel step_model(Volume& volume) {
  Lattices& l = volume.lattices;
  StepModel out;
  out.model = &l.model;
  out.radiance = learned(l.model.radiance.raw, l.radiance);
  out.radiance.visible = l.visible.rows;
  for (std::size_t i = 0; i < l.levels.size(); ++i)
    out.levels.push_back(learned(l.levels[i], l.level_learners[i]));
  out.active = &volume.occupancy.active;
  out.occupancy = volume.occupancy.grids();
  out.curves = l.curves;
  out.static_prior = l.static_prior;
  out.may_spoil = l.may_spoil;
  return out;
}

}  // namespace

Home::Home(Volume volume, std::unique_ptr<StepBackend> backend)
    : volume_(std::move(volume)), backend_(std::move(backend)) {}

const Volume& Home::read() const {
  if (!here_) {
    backend_->download();
    volume_.lattices.sum_levels(volume_.moving.rows);
    here_ = true;
  }
  return volume_;
}

Volume& Home::change() {
  read();
  sent_ = false;
  return volume_;
}

StepSums Home::step(const StepInput& in) {
  if (!sent_) backend_->upload(step_model(volume_));
  sent_ = true;
  here_ = false;
  volume_.lattices.forget_sum();  // the backend makes its own, and this one is old after the step
  const StepSums sums = backend_->run(in);
  Visible& visible = volume_.lattices.visible;
  if (sums.usable && !visible.rows.empty()) visible.rays += std::int64_t(in.rays.size());
  return sums;
}

void Home::archive(Archive& a, const Setting& setting) {
  read();
  if (a.reading()) sent_ = false;
  volume_.archive(a, setting);
}

VoxelModel Home::take() {
  read();
  backend_.reset();
  Lattices& l = volume_.lattices;
  VoxelModel model = std::move(l.model);
  l = Lattices();
  return model;
}

}  // namespace splinevox
