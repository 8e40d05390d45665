// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rays.hpp"
#include "run/progress.hpp"
#include "run/run_folder.hpp"

namespace splinevox::mlp {

using run::Json;

/// The device of that name ("cpu", "cuda", "auto"). Throws Error (input) if there is none or it is not to be
/// had.
torch::Device torch_device(const std::string& name);

/// A saved run.
struct MlpRun {
  std::string path;
  Settings settings;
  run::RunRecord record;
  Box box;
  MlpModel model{nullptr};
};
/// Throws Error (input) if the folder holds no run of this program.
MlpRun open_run(const std::string& path, const std::string& device);

/// Means over the views of a split, on every n-th pixel of every n-th row.
struct Measured {
  double psnr = 0;  ///< mean of the views' PSNR, dB
  double ssim = 0,
         ms_ssim =
             0;  ///< of whole pictures only (a stride of 1); 0 otherwise: neighbours that are not say nothing
  Json frames = Json::array();
};
Measured measure(MlpModel& model, const Settings& settings, const Box& box, const Split& split, int stride);
/// A view at every n-th pixel, within [0, 1].
Image view_picture(MlpModel& model, const Frame& frame, const Box& box, int stride);

/// Trains one variant into a run folder: config.toml, metrics.jsonl, metrics.json, model.pt, preview/. The
/// clock runs while batches are drawn, marched and learned from, not while views are measured, as for the
/// voxel model.
class MlpSession {
 public:
  MlpSession(const Settings& settings, Dataset& data, const run::RunFolder& folder, run::Progress& progress);
  /// Until the budget is used or a signal asks to stop; the model is saved either way. @return what
  /// metrics.json gets.
  Json run();

 private:
  double step(double progress);
  void measure_due(bool all);
  void show_held_out();
  void report_line(const Json& line) const;
  void save() const;

  const Settings settings_;
  const Dataset& data_;
  const run::RunFolder& folder_;
  run::Progress& progress_;
  Box box_;
  CropSampler sampler_;
  MlpModel model_;
  torch::optim::Adam optimiser_;
  std::int64_t step_ = 0;
  double seconds_ = 0, held_out_psnr_, held_out_seconds_ = 0, loss_ = 0;
  std::size_t tested_ = 0;  ///< entries of settings.test_at done
  Json tests_ = Json::array();
};

}  // namespace splinevox::mlp
