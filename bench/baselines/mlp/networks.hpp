// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <torch/torch.h>

#include "settings.hpp"

namespace splinevox::mlp {

enum class Activation { leaky_relu, sine };

/// Perceptron of a first layer, `hidden` more and a last one; the input joins again, before the activation,
/// at every third hidden layer but the last of them, the first included: the released code's, to the number
/// of parameters. Leaky ReLU layers start as Xavier uniform, sine layers as U(+-sqrt(6 / inputs)), both as
/// there; its sines have no frequency factor.
struct SkipMlpImpl : torch::nn::Module {
  /// @param zero_last  the last layer starts at 0: no displacement before training.
  SkipMlpImpl(int in, int out, int hidden, int width, Activation activation, bool zero_last = false);
  /// [n, in] -> [n, out]
  torch::Tensor forward(const torch::Tensor& x);

 private:
  bool joins(int layer) const { return layer % kSkip == 0 && layer + 1 != hidden_; }
  torch::nn::Linear layer(const std::string& name, int in, int out);

  static constexpr int kSkip = 3;
  Activation activation_;
  int hidden_;
  torch::nn::Linear first_{nullptr}, last_{nullptr};
  std::vector<torch::nn::Linear> layers_;
};
TORCH_MODULE(SkipMlp);

/// Random Fourier features (Tancik et al. 2020): x -> (sin xB, cos xB), B normal with standard deviation 32,
/// fixed.
struct FourierImpl : torch::nn::Module {
  explicit FourierImpl(int in, int count = 128, double sigma = 32);
  /// [n, in] -> [n, 2 count]
  torch::Tensor forward(const torch::Tensor& x);

 private:
  torch::Tensor frequencies_;
};
TORCH_MODULE(Fourier);

/// Raw density and colour at points: Eq. 5, RGB = (1 - sigmoid(MLP(v)) / 2) sigmoid(MLP(x)). The trunk sees
/// the position as it is beside its Fourier features.
struct RadianceImpl : torch::nn::Module {
  /// @param in  3, or 4 where time is an input (T-NeRF).
  /// @param view_sees_position  the view's network also gets the position, the trunk's features and the
  /// colour's, as the released code.
  RadianceImpl(int in, bool view_sees_position);
  struct Out {
    torch::Tensor density;  ///< [n] raw
    torch::Tensor rgb;      ///< [n, 3] in (0, 1)
  };
  /// @param x [n, in]  @param direction [n, 3] of unit length
  Out forward(const torch::Tensor& x, const torch::Tensor& direction);

 private:
  static constexpr int kLatent = 64;
  bool view_sees_position_;
  Fourier fourier_{nullptr};
  SkipMlp trunk_{nullptr}, color_{nullptr}, view_{nullptr};
};
TORCH_MODULE(Radiance);

/// Displacement before rigidity and raw rigidity of points at times: Eq. 2 to 4.
struct DeformationImpl : torch::nn::Module {
  DeformationImpl(Kind kind, int points);
  struct Out {
    torch::Tensor delta;     ///< [n, 3] Delta_0, scene units
    torch::Tensor rigidity;  ///< [n] raw
  };
  /// @param x [n, 3]  @param t [n, 1] in [0, 1]
  Out forward(const torch::Tensor& x, const torch::Tensor& t);

 private:
  Kind kind_;
  int points_;
  SkipMlp net_{nullptr};
};
TORCH_MODULE(Deformation);

/// Bezier curves by De Casteljau (Eq. 3, with index i + 1 as the released code: the paper's i - 1 runs
/// backwards).
/// @param points [n, K, 3]  @param t [n, 1]  @return [n, 3]
torch::Tensor de_casteljau(torch::Tensor points, const torch::Tensor& t);

}  // namespace splinevox::mlp
