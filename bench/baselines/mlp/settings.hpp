// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace splinevox::mlp {

/// The methods of the paper that have a perceptron where the voxel model has lattices.
enum class Kind {
  spline,   ///< Spline-NeRF: x -> control points and rigidity, De Casteljau, canonical model
  nr_nerf,  ///< NR-NeRF as the paper implements it: (x, t) -> displacement and rigidity, canonical model
  t_nerf    ///< no displacement: the radiance itself is a function of (x, t)
};
const char* name(Kind kind);
/// Throws Error listing the names.
Kind kind_of(const std::string& text);

/// Everything a run of a variant depends on. Sizes of networks are those of the released code (nerf_atlas at
/// 13666ab).
struct Settings {
  Kind kind = Kind::spline;
  std::string preset = "paper";
  int points = 5;    ///< control points of the Bezier curve, >= 2
  int samples = 64;  ///< per ray, stratified over the part inside the box
  int crops = 2,
      crop = 18;  ///< rays of a step: `crops` squares of crop x crop pixels, each of a random frame
  double lr = 2e-4, lr_final = 5e-5;  ///< Adam, cosine from one to the other over the budget
  double offset = 30, offset_rigidity = 0.3,
         divergence = 0.3;  ///< lambda_off, lambda_r, lambda_div of Eq. 6 to 8
  bool ramp = false;        ///< multiply offset and divergence by 1/100 -> 1, as the released code
  bool view_sees_position =
      false;  ///< the view factor's network also gets the canonical position's features, as the released code
  double rigidity_scale = 1;            ///< r = sigmoid(scale * output); the released code halves
  double density_noise = 0.2;           ///< standard deviation added to the raw density while training
  std::vector<int> shrink{8, 4, 2, 1};  ///< block sizes of the training pictures, stage by stage
  std::vector<double> shrink_start{0, .1, .25, .5};  ///< progress at which each stage begins
  double max_time = 900;                             ///< seconds of training, without evaluations
  bool cpu_time = false;  ///< seconds are processor time over the threads, so that other work on the machine
                          ///< does not count
  int max_steps = 0;      ///< 0: max_time decides
  std::string device = "auto";  ///< cpu, cuda, or auto: cuda where LibTorch was built with it and finds one
  std::uint64_t seed = 1;
  int downscale = 1;  ///< of the data set
  std::vector<double> background{1, 1, 1};
  std::vector<double> test_at;  ///< seconds of training at which the test split is measured
  int test_stride = 8;  ///< every n-th pixel of every n-th row is measured: whole pictures take minutes each
};

/// "paper": what the paper says. "nerf_atlas": what its code does (the divergence loss there has no gradient,
/// so here it is 0). Throws Error naming the presets.
Settings preset(const std::string& name, Kind kind);
/// The [mlp] table of config.toml.
std::string settings_text(const Settings& s);
/// Reads it back. Throws Error naming the file and key.
Settings read_settings(const std::string& path);

}  // namespace splinevox::mlp
