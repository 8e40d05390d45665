// SPDX-License-Identifier: Apache-2.0
#include "networks.hpp"

#include <cmath>
#include <string>

namespace splinevox::mlp {

SkipMlpImpl::SkipMlpImpl(int in, int out, int hidden, int width, Activation activation, bool zero_last)
    : activation_(activation), hidden_(hidden) {
  first_ = layer("first", in, width);
  for (int i = 0; i < hidden; ++i)
    layers_.push_back(layer("layer" + std::to_string(i), width + (joins(i) ? in : 0), width));
  last_ = layer("last", width, out);
  torch::NoGradGuard constant;
  if (zero_last) torch::nn::init::zeros_(last_->weight);
}

torch::nn::Linear SkipMlpImpl::layer(const std::string& name, int in, int out) {
  torch::nn::Linear made(in, out);
  torch::NoGradGuard constant;
  if (activation_ == Activation::sine) {
    const double bound = std::sqrt(6.0 / in);
    torch::nn::init::uniform_(made->weight, -bound, bound);
  } else {
    torch::nn::init::xavier_uniform_(made->weight);
  }
  torch::nn::init::zeros_(made->bias);
  return register_module(name, made);
}

torch::Tensor SkipMlpImpl::forward(const torch::Tensor& x) {
  const auto active = [&](const torch::Tensor& h) {
    return activation_ == Activation::sine ? torch::sin(h) : torch::leaky_relu(h);
  };
  torch::Tensor h = first_(x);
  for (int i = 0; i < hidden_; ++i)
    h = layers_[std::size_t(i)](active(joins(i) ? torch::cat({h, x}, -1) : h));
  return last_(active(h));
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
  trunk_ = register_module("trunk", SkipMlp(in + kFeatures, 1 + kLatent, 5, 128, Activation::sine));
  color_ = register_module(
      "color", SkipMlp(in + kLatent, view_sees_position ? 3 + kLatent : 3, 3, 256, Activation::sine));
  view_ = register_module(
      "view", SkipMlp(view_sees_position ? in + 3 + 2 * kLatent : 3, 1, 3, 128, Activation::sine));
}

RadianceImpl::Out RadianceImpl::forward(const torch::Tensor& x, const torch::Tensor& direction) {
  const torch::Tensor trunk = trunk_(torch::cat({x, fourier_(x)}, -1)),
                      features = trunk.narrow(-1, 1, kLatent);
  const torch::Tensor color = torch::sigmoid(color_(torch::cat({x, features}, -1)));
  const torch::Tensor seen = view_sees_position_
                                 ? torch::cat({x, direction, features, color.narrow(-1, 3, kLatent)}, -1)
                                 : direction;
  return {trunk.select(-1, 0), (1 - torch::sigmoid(view_(seen)) / 2) * color.narrow(-1, 0, 3)};
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
  return {de_casteljau(out.narrow(-1, 0, 3 * points_).view({-1, points_, 3}), t),
          out.select(-1, 3 * points_)};
}

torch::Tensor de_casteljau(torch::Tensor points, const torch::Tensor& t) {
  const torch::Tensor s = t.unsqueeze(-1);
  for (int64_t n = points.size(1) - 1; n > 0; --n)
    points = (1 - s) * points.narrow(1, 0, n) + s * points.narrow(1, 1, n);
  return points.squeeze(1);
}

}  // namespace splinevox::mlp
