// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "train/archive.hpp"
#include "train/volume.hpp"

namespace splinevox {

/// The volume that a run learns, wherever its parameters are: in this class, or in the memory of the backend
/// that makes the steps. Parameters can be reached through this class alone. It downloads them before they
/// are read and uploads them after a change, so neither side ever works on an old copy. References are good
/// until the next step.
class Home {
 public:
  Home(Volume volume, std::unique_ptr<StepBackend> backend);

  /// The volume as the steps so far have left it.
  const Volume& read() const;
  /// The same, to be changed.
  Volume& change();
  StepSums step(const StepInput& in);
  /// See StepBackend.
  bool takes_colour_gradient() const { return backend_->takes_colour_gradient(); }
  /// Of the last step, see StepBackend.
  std::vector<int> bad_rays() { return backend_->bad_rays(); }
  /// Saves or restores the volume. Throws Error (input) where a restored one does not fit the setting.
  void archive(Archive& a, const Setting& setting);
  /// The volume's model at the end of training, whose memory is freed: no step after it.
  VoxelModel take();

  // What no backend changes needs no download.
  const Occupancy& occupancy() const { return volume_.occupancy; }
  const Box& box() const { return volume_.lattices.model.box; }
  float march_step() const { return volume_.lattices.model.step; }
  double moving_share() const { return volume_.moving.share; }
  const Background& background() const { return volume_.lattices.model.background; }
  Background& background() { return volume_.lattices.model.background; }
  const Surroundings& surroundings() const { return volume_.lattices.model.surroundings; }
  Surroundings& surroundings() { return volume_.lattices.model.surroundings; }
  const CameraFits& cameras() const { return volume_.cameras; }
  CameraFits& cameras() { return volume_.cameras; }

 private:
  mutable Volume volume_;
  std::unique_ptr<StepBackend> backend_;
  mutable bool here_ = true;  ///< the parameters of the last step are in the volume
  bool sent_ = false;         ///< the backend has this volume, or what its steps have made of it
};

}  // namespace splinevox
