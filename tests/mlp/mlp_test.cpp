// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>

#include "app/program.hpp"
#include "math/bernstein.hpp"
#include "networks.hpp"
#include "rays.hpp"
#include "run/support.hpp"
#include "splinevox/data/synth.hpp"

#undef CHECK  // LibTorch has one of its own, which ends the program
#define CHECK DOCTEST_CHECK

using namespace splinevox;
using namespace splinevox::mlp;
using namespace splinevox::test;

TEST_SUITE("mlp/spline") {
  TEST_CASE(
      "De Casteljau on tensors agrees with our Bernstein weights, in value, in every control point's "
      "gradient and in time's") {
    torch::manual_seed(3);
    for (const int points : {2, 3, 5, 12}) {
      torch::Tensor p = torch::randn({40, points, 3}, torch::kDouble).requires_grad_(true);
      torch::Tensor t = torch::rand({40, 1}, torch::kDouble).requires_grad_(true);
      const torch::Tensor pull = torch::randn({40, 3}, torch::kDouble);
      const torch::Tensor x = de_casteljau(p, t);
      (x * pull).sum().backward();
      for (int i = 0; i < 40; ++i) {
        const double time = t[i][0].item<double>();
        const BasisWeights<double> w = bernstein_weights(points, time),
                                   dw = bernstein_weights_dt(points, time);
        double slope = 0;
        for (int a = 0; a < 3; ++a) {
          double value = 0;
          for (int k = 0; k < points; ++k) {
            value += w[k] * p[i][k][a].item<double>();
            slope += dw[k] * p[i][k][a].item<double>() * pull[i][a].item<double>();
            CHECK(p.grad()[i][k][a].item<double>() ==
                  doctest::Approx(w[k] * pull[i][a].item<double>()).epsilon(1e-12));
          }
          CHECK(x[i][a].item<double>() == doctest::Approx(value).epsilon(1e-12));
        }
        CHECK(t.grad()[i][0].item<double>() == doctest::Approx(slope).epsilon(1e-10));
      }
    }
  }
}

TEST_SUITE("mlp/model") {
  Rays some_rays(int64_t n) {
    const torch::Tensor d = torch::randn({n, 3});
    return {torch::rand({n, 3}) - 0.5, d / d.norm(2, 1, true), torch::rand({n, 1}) + 0.5,
            torch::rand({n, 1})};
  }
  TEST_CASE(
      "networks have as many parameters as the released code's, its fixed Fourier frequencies included") {
    Settings s = preset("nerf_atlas", Kind::spline);
    s.points = 5;
    MlpModel model(s);
    std::int64_t count = 0;
    for (const torch::Tensor& p : model->parameters()) count += p.numel();
    for (const auto& b : model->named_buffers())
      if (b.key() != "background") count += b.value().numel();
    CHECK(count == 859'797);
  }
  TEST_CASE("the divergence loss has the gradient of its value") {
    for (const Kind kind : {Kind::spline, Kind::nr_nerf}) {
      Settings s = preset("paper", kind);
      s.samples = 6;
      s.density_noise = 0;
      torch::manual_seed(2);
      MlpModel model(s);
      model->to(torch::kDouble);
      torch::Tensor moved;  // a weight of the deformation that matters
      {
        torch::NoGradGuard constant;
        for (const auto& p : model->named_parameters()) {
          torch::Tensor value = p.value();
          // The same density everywhere: weights of samples are constants of the loss, so a difference must
          // not see them change.
          if (p.key().rfind("radiance", 0) == 0)
            value.zero_();
          else
            value += 0.05 * torch::randn_like(value);
          if (p.key() == "deformation.net.layer2.weight") moved = value;
        }
      }
      REQUIRE(moved.defined());
      Rays rays = some_rays(8);
      for (torch::Tensor* t : {&rays.origin, &rays.direction, &rays.length, &rays.time})
        *t = t->to(torch::kDouble);
      const auto loss = [&] {
        torch::manual_seed(7);  // the same samples and probes
        return model->train_march(rays).divergence;
      };
      loss().backward();
      const torch::Tensor gradient = moved.grad().clone();
      const double largest = gradient.abs().max().item<double>(), by = 1e-6;
      CHECK(largest > 0);
      for (int i = 0; i < 40; ++i) {
        const int row = 37 * i % 256, column = 11 * i % 256;
        const auto at = [&](double change) {
          {
            torch::NoGradGuard constant;
            moved[row][column] += change;
          }
          const double value = loss().item<double>();
          torch::NoGradGuard constant;
          moved[row][column] -= change;
          return value;
        };
        CHECK(gradient[row][column].item<double>() ==
              doctest::Approx((at(by) - at(-by)) / (2 * by)).epsilon(1e-5).scale(1e-3 * largest));
      }
    }
  }
  TEST_CASE("settings survive their text, for every kind and preset") {
    const TempFolder folder;
    const std::string path = folder.str() + "/config.toml";
    for (const char* name : {"paper", "nerf_atlas"})
      for (const Kind kind : {Kind::spline, Kind::nr_nerf, Kind::t_nerf}) {
        Settings s = preset(name, kind);
        s.test_at = {1, 2.5};
        s.seed = 77;
        s.cpu_time = true;
        write_text(path, settings_text(s));
        CHECK(settings_text(read_settings(path)) == settings_text(s));
      }
  }
  TEST_CASE("the divergence loss reaches the deformation's weights") {
    for (const Kind kind : {Kind::spline, Kind::nr_nerf}) {
      Settings s = preset("paper", kind);
      s.samples = 8;
      torch::manual_seed(1);
      MlpModel model(s);
      {
        torch::NoGradGuard constant;  // away from the start, where nothing is displaced
        for (torch::Tensor& p : model->parameters()) p += 0.05 * torch::randn_like(p);
      }
      const Marched m = model->train_march(some_rays(16));
      REQUIRE(m.divergence.defined());
      CHECK(m.divergence.item<double>() > 0);
      m.divergence.backward();
      double size = 0;
      for (const auto& p : model->named_parameters())
        if (p.key().rfind("deformation", 0) == 0 && p.value().grad().defined())
          size += p.value().grad().abs().sum().item<double>();
      CHECK(size > 0);
      CHECK(std::isfinite(size));
    }
  }
  TEST_CASE("before training nothing moves, no gradient is NaN, and an empty ray shows the background") {
    for (const Kind kind : {Kind::spline, Kind::nr_nerf, Kind::t_nerf}) {
      Settings s = preset("paper", kind);
      s.samples = 8;
      MlpModel model(s);
      Rays rays = some_rays(16);
      rays.length[3] = 0;
      const Marched m = model->train_march(rays);
      for (int a = 0; a < 3; ++a) CHECK(m.rgb[3][a].item<float>() == 1);
      torch::Tensor loss = m.rgb.sum();
      if (m.offset.defined()) loss = loss + m.offset;
      if (m.divergence.defined()) loss = loss + m.divergence;
      loss.backward();
      for (const torch::Tensor& p : model->parameters())
        if (p.grad().defined()) CHECK(torch::isfinite(p.grad()).all().item<bool>());
    }
  }
}

TEST_SUITE("mlp/program") {
  TEST_CASE("train leaves a run that eval and render read and that report shows; the picture is learned") {
    const TempFolder folder;
    SynthOptions synth;
    synth.frames = 10;
    synth.size = 24;
    write_synth("dancer", folder.str() + "/data", synth);
    for (const char* kind : {"spline", "nr-nerf", "t-nerf"}) {
      CAPTURE(kind);
      const std::string run = folder.str() + "/" + kind;
      Started train({SPLINEVOX_MLP, "train",       folder.str() + "/data",
                     "--out",       run,           "--kind",
                     kind,          "--max-steps", "20",
                     "--samples",   "4",           "--shrink",
                     "1",           "--stride",    "4",
                     "--test-at",   "0,1e9",       "--lr",
                     "2e-3",        "--quiet"});
      const Ended trained = train.wait();
      CAPTURE(trained.err);
      REQUIRE(trained.code == 0);
      for (const char* file : {"config.toml", "metrics.jsonl", "metrics.json", "model.pt"})
        CHECK_MESSAGE(std::filesystem::exists(run + "/" + file), file);
      const auto figures = run::read_json(run + "/metrics.json");
      CHECK(figures["steps"] == 20);
      REQUIRE(figures["tests"].size() == 2);
      CHECK(figures["tests"][1]["psnr"] > figures["tests"][0]["psnr"].get<double>() + 0.2);
      const Ended eval = Started({SPLINEVOX_MLP, "eval", run, "--stride", "4", "--json"}).wait();
      CAPTURE(eval.err);
      REQUIRE(eval.code == 0);
      CHECK(run::Json::parse(eval.out)["psnr"] > 5);
      CHECK(Started({SPLINEVOX_MLP, "render", run, "--out", run + "/pictures", "--stride", "4", "--quiet"})
                .wait()
                .code == 0);
      CHECK(std::filesystem::exists(run + "/pictures/r_000.png"));
      CHECK(program({"report", run, "--out", run + "/page.html"}).code == 0);
    }
    CHECK(Started({SPLINEVOX_MLP, "eval", folder.str()}).wait().code == 2);
    CHECK(Started({SPLINEVOX_MLP, "train", folder.str() + "/data", "--out", folder.str() + "/x", "--kind",
                   "nerf"})
              .wait()
              .code == 2);
  }
}
