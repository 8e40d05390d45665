// SPDX-License-Identifier: Apache-2.0
#include "networks.hpp"

#include <cmath>
#include <string>

namespace splinevox::mlp {

SkipMlpImpl::SkipMlpImpl(int in, int out, int layers, int width, Activation activation, bool zero_last) : activation_(activation) {
  int size = in;
  for (int i = 0; i <= layers; ++i) {
    const bool joins = i > 0 && i < layers && i % kSkip == 0;
    const bool last = i == layers;
    torch::nn::Linear layer(size + (joins ? in : 0), last ? out : width);
    torch::NoGradGuard constant;
    if (last && zero_last) torch::nn::init::zeros_(layer->weight);
    else if (activation == Activation::sine) {
      const double bound = std::sqrt(6.0 / double(layer->options.in_features()));
      torch::nn::init::uniform_(layer->weight, -bound, bound);
    } else {
      torch::nn::init::xavier_uniform_(layer->weight);
    }
    torch::nn::init::zeros_(layer->bias);
    layers_.push_back(register_module("layer" + std::to_string(i), layer));
    size = width;
  }
}

torch::Tensor SkipMlpImpl::forward(const torch::Tensor& x) {
  torch::Tensor h = x;
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    const bool last = i + 1 == layers_.size();
    if (i > 0 && !last && i % kSkip == 0) h = torch::cat({h, x}, -1);
    h = layers_[i](h);
    if (!last) h = activation_ == Activation::sine ? torch::sin(h) : torch::leaky_relu(h);
  }
  return h;
}

FourierImpl::FourierImpl(int in, int count, double sigma) {
  frequencies_ = register_buffer("frequencies", sigma * torch::randn({in, count}));
}

torch::Tensor FourierImpl::forward(const torch::Tensor& x) {
  const torch::Tensor phase = torch::matmul(x, frequencies_);
  return torch::cat({torch::sin(phase), torch::cos(phase)}, -1);
}

RadianceImpl::RadianceImpl(int in, bool view_sees_position) : view_sees_position_(view_sees_position) {
  constexpr int kFeatures = 256;
  fourier_ = register_module("fourier", Fourier(in));
  trunk_ = register_module("trunk", SkipMlp(kFeatures, 1 + kLatent, 5, 128, Activation::sine));
  color_ = register_module("color", SkipMlp(in + kLatent, 3, 3, 256, Activation::sine));
  view_ = register_module("view", SkipMlp(view_sees_position ? 3 + in + kLatent : 3, 1, 3, 128, Activation::sine));
}

RadianceImpl::Out RadianceImpl::forward(const torch::Tensor& x, const torch::Tensor& direction) {
  const torch::Tensor trunk = trunk_(fourier_(x));
  const torch::Tensor place = torch::cat({x, trunk.narrow(-1, 1, kLatent)}, -1);
  const torch::Tensor seen = view_sees_position_ ? torch::cat({direction, place}, -1) : direction;
  return {trunk.select(-1, 0), (1 - torch::sigmoid(view_(seen)) / 2) * torch::sigmoid(color_(place))};
}

DeformationImpl::DeformationImpl(Kind kind, int points) : kind_(kind), points_(points) {
  const int in = kind == Kind::spline ? 3 : 4, out = kind == Kind::spline ? 3 * points + 1 : 4;
  net_ = register_module("net", SkipMlp(in, out, 5, 256, Activation::leaky_relu, true));
}

DeformationImpl::Out DeformationImpl::forward(const torch::Tensor& x, const torch::Tensor& t) {
  if (kind_ == Kind::nr_nerf) {
    const torch::Tensor out = net_(torch::cat({x, t}, -1));
    return {out.narrow(-1, 0, 3), out.select(-1, 3)};
  }
  const torch::Tensor out = net_(x);
  return {de_casteljau(out.narrow(-1, 0, 3 * points_).view({-1, points_, 3}), t), out.select(-1, 3 * points_)};
}

torch::Tensor de_casteljau(torch::Tensor points, const torch::Tensor& t) {
  const torch::Tensor s = t.unsqueeze(-1);
  for (int64_t n = points.size(1) - 1; n > 0; --n) points = (1 - s) * points.narrow(1, 0, n) + s * points.narrow(1, 1, n);
  return points.squeeze(1);
}

}  // namespace splinevox::mlp
