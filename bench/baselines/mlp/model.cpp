// SPDX-License-Identifier: Apache-2.0
#include "model.hpp"

namespace splinevox::mlp {
namespace {

constexpr int64_t kPieceRays = 1024;

/// exp(-optical depth before each sample): [n, s] from [n, s].
torch::Tensor transmittance_before(const torch::Tensor& depth) {
  return torch::exp(-(torch::cumsum(depth, 1) - depth));
}

}  // namespace

MlpModelImpl::MlpModelImpl(const Settings& settings) : settings_(settings) {
  background_ = register_buffer("background", torch::tensor(std::vector<float>(settings.background.begin(),
                                                                               settings.background.end())));
  if (settings.kind != Kind::t_nerf)
    deformation_ = register_module("deformation", Deformation(settings.kind, settings.points));
  radiance_ = register_module("radiance",
                              Radiance(settings.kind == Kind::t_nerf ? 4 : 3, settings.view_sees_position));
}

Marched MlpModelImpl::train_march(const Rays& rays) {
  const auto there = [&](const torch::Tensor& t) { return t.to(device()); };
  return march({there(rays.origin), there(rays.direction), there(rays.length), there(rays.time)}, true);
}

torch::Tensor MlpModelImpl::picture(const Rays& rays) {
  torch::NoGradGuard constant;
  std::vector<torch::Tensor> pieces;
  const int64_t n = rays.origin.size(0);
  for (int64_t first = 0; first < n; first += kPieceRays) {
    const int64_t count = std::min(kPieceRays, n - first);
    const auto part = [&](const torch::Tensor& t) { return t.narrow(0, first, count).to(device()); };
    pieces.push_back(
        march({part(rays.origin), part(rays.direction), part(rays.length), part(rays.time)}, false)
            .rgb.cpu());
  }
  return torch::cat(pieces);
}

Marched MlpModelImpl::march(const Rays& rays, bool training) {
  const int64_t n = rays.origin.size(0), s = settings_.samples;
  const auto kind = rays.origin.options();
  const torch::Tensor place = training ? torch::rand({n, s}, kind) : torch::full({n, s}, 0.5, kind);
  const torch::Tensor distance = rays.length * (torch::arange(s, kind) + place) / double(s);  // [n, s]
  torch::Tensor x =
      (rays.origin.unsqueeze(1) + rays.direction.unsqueeze(1) * distance.unsqueeze(-1)).reshape({-1, 3});
  const auto per_sample = [&](const torch::Tensor& t) {
    return t.unsqueeze(1).expand({n, s, t.size(1)}).reshape({n * s, t.size(1)});
  };
  const torch::Tensor t = per_sample(rays.time), direction = per_sample(rays.direction);

  const bool moves = settings_.kind != Kind::t_nerf;
  const bool diverges = training && moves && settings_.divergence > 0;
  if (diverges) x.requires_grad_(true);
  DeformationImpl::Out warp;
  torch::Tensor rigidity, delta, canonical = moves ? x : torch::cat({x, t}, -1);
  if (moves) {
    warp = deformation_(x, t);
    rigidity = torch::sigmoid(settings_.rigidity_scale * warp.rigidity);
    delta = rigidity.unsqueeze(-1) * warp.delta;
    canonical = x + delta;
  }
  const RadianceImpl::Out seen = radiance_(canonical, direction);
  torch::Tensor raw = seen.density;
  if (training && settings_.density_noise > 0) raw = raw + settings_.density_noise * torch::randn_like(raw);
  const torch::Tensor depth = torch::softplus(raw - 1).view({n, s}) * (rays.length / double(s));
  const torch::Tensor weight = transmittance_before(depth) * -torch::expm1(-depth);  // [n, s]
  Marched out;
  out.rgb = (weight.unsqueeze(-1) * seen.rgb.view({n, s, 3})).sum(1) +
            torch::exp(-depth.sum(1, true)) * background_;
  if (!training || !moves) return out;

  const torch::Tensor visible = weight.detach().reshape({-1});
  if (settings_.offset > 0) {
    // |Delta_0| softened as in math/offset.hpp: the plain form has no gradient at 0.
    const torch::Tensor length = torch::sqrt((warp.delta * warp.delta).sum(-1) + 1e-8);
    out.offset = (visible * (torch::pow(length, 2 - rigidity) + settings_.offset_rigidity * rigidity)).mean();
  }
  if (diverges) {
    // One Rademacher probe per sample (Hutchinson), differentiable a second time.
    const torch::Tensor probe = torch::randint(0, 2, x.sizes(), kind) * 2 - 1;
    const torch::Tensor pulled = torch::autograd::grad({(delta * probe).sum()}, {x}, {}, true, true)[0];
    const torch::Tensor divergence = (pulled * probe).sum(-1);
    out.divergence = (visible * divergence * divergence).mean();
  }
  return out;
}

}  // namespace splinevox::mlp
