// SPDX-License-Identifier: Apache-2.0
// What a film of one moving camera gives, where the truth is known: built-in scenes, filmed half around and
// held by hand along a short arc, before a plain wall and in a room. Effects are chosen as `train` does.
//
//   bench_films [--seeds 2] [--first 1] [--steps 400] [--size 96] [--frames 60] [--preset fast] [--only NAME]
//               [--scenes toy,garden,ball] [--effects auto|all] [--set GROUP.KEY=VALUE].. [--threads 0]
//               [--masks] [--told] [--depth metric|relative|inverse] [--tracks]
//               [--track-noise 0] [--track-wrong 0]
//
// One JSON line per film: PSNR off and on the camera's way, of still pixels off it and of surface that the
// film shows (off_seen), how much of the still surface that the film shows is displaced, and how far tracked
// points of moving surface end from the truth. Then one line of means. With --masks a film is only looked at:
// what share of the pixels that show something moving is found (found), and what share of those found do
// (right). With --told true masks say what moves. With --depth every training picture has a depth map of that
// kind, with --tracks points are followed through them, exactly but for --track-noise pixels and a share
// --track-wrong that wanders off.
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "math/quantile.hpp"
#include "run/held_camera.hpp"
#include "shown_surface.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/run/train.hpp"
#include "trained.hpp"

using namespace splinevox;

namespace {

struct Film {
  std::string name, scene;
  SynthOptions options;
};

std::vector<Film> films(const std::vector<std::string>& scenes) {
  const SynthOptions half{.orbit = 0.5, .film = true}, hand{.orbit = 0.12, .film = true, .shake = 0.03};
  std::vector<Film> out;
  for (const std::string& scene : scenes)
    for (const auto& [way, options] : {std::pair{"half", half}, {"hand", hand}})
      for (const bool room : {false, true}) {
        if (!room && scene == "ball") continue;  // nothing stands still but a plain wall
        Film film{fmt::format("{}-{}-{}", scene, way, room ? "room" : "wall"), scene, options};
        film.options.look.room = room;
        film.options.look.opaque = !room;
        out.push_back(std::move(film));
      }
  return out;
}

constexpr int kLongEnough = 8;   ///< steps of a run for one of a trial fit (train/effects/choose_effects.cpp)
constexpr int kMoments = 6;      ///< at which displacements are asked for, evenly over the film
constexpr int kPoints = 24;      ///< along an edge of a picture: surface points that are asked
constexpr double kStill = 1e-6;  ///< scene units: what moves less is still

double moment_of(int i) { return double(i) / (kMoments - 1); }

/// How far a point of a body's material ever is from where it is now.
double travel(const std::vector<SynthMoment>& moments, const SynthHit& hit) {
  double most = 0;
  for (const SynthMoment& m : moments)
    most = std::max(most, length(m.world_from_rest(hit.body, hit.rest) - hit.position));
  return most;
}

/// Surface points that one picture of the film shows.
struct Points {
  std::vector<Vec3> still, moving;
  std::vector<std::vector<Vec3>> truth;  ///< [moment][moving point]
};

Points points_of(const SynthScene& scene, const std::vector<SynthMoment>& moments, const Frame& frame,
                 const Box& box) {
  Points out;
  out.truth.resize(moments.size());
  const SynthMoment now = scene.at(frame.time);
  for (int y = 0; y < kPoints; ++y)
    for (int x = 0; x < kPoints; ++x) {
      const auto hit = now.trace(camera_ray(frame.camera, (x + 0.5) * frame.camera.width / kPoints,
                                            (y + 0.5) * frame.camera.height / kPoints));
      if (!hit) continue;
      const Vec3 p = cast<float>(hit->position);
      if (min(p, box.lo) != box.lo || max(p, box.hi) != box.hi) continue;
      if (travel(moments, *hit) < kStill) {
        out.still.push_back(p);
        continue;
      }
      out.moving.push_back(p);
      for (std::size_t m = 0; m < moments.size(); ++m)
        out.truth[m].push_back(cast<float>(moments[m].world_from_rest(hit->body, hit->rest)));
    }
  return out;
}

/// Against the truth, percent of the box where not said otherwise: how far the still surface is displaced at
/// other times than its picture's (shift: in the picture, percent of its width), and how far off moving
/// points end that are carried to those times.
nlohmann::json motion_figures(const VoxelModel& model, const SynthScene& scene, const Split& train) {
  constexpr std::size_t kPictures = 12;
  std::vector<SynthMoment> moments;
  std::vector<double> times;
  for (int i = 0; i < kMoments; ++i) {
    times.push_back(moment_of(i));
    moments.push_back(scene.at(times.back()));
  }
  const double percent = 100 / double(model.box.longest_edge()),
               half_voxel = 0.5 * double(model.radiance.raw.topology->lattice.spacing);
  std::vector<double> still, in_picture, moving, travelled;
  double displaced = 0;
  for (std::size_t k = 0; k < kPictures; ++k) {
    const Frame& frame = train.frames[k * (train.frames.size() - 1) / (kPictures - 1)];
    const Points points = points_of(scene, moments, frame, model.box);
    const FrameSampler own(model, frame.time);
    const auto tracked = track(model, points.moving, frame.time, times);
    for (int m = 0; m < kMoments; ++m) {
      const FrameSampler other(model, times[std::size_t(m)]);
      for (const Vec3& p : points.still) {
        const Vec3 by = other.warp(p).displacement - own.warp(p).displacement;
        const double d = length(by);
        displaced += d > half_voxel;
        still.push_back(percent * d);
        const Projection from = project(frame.camera, cast<double>(p)),
                         to = project(frame.camera, cast<double>(p + by));
        in_picture.push_back(100 * std::hypot(to.u - from.u, to.v - from.v) / frame.camera.width);
      }
      for (std::size_t i = 0; i < points.moving.size(); ++i) {
        const Vec3& truth = points.truth[std::size_t(m)][i];
        moving.push_back(percent * length(tracked[std::size_t(m)][i].position - truth));
        travelled.push_back(percent * length(points.moving[i] - truth));
      }
    }
  }
  nlohmann::json out;
  if (!still.empty())
    out = {{"still_displaced_share", displaced / double(still.size())},
           {"still_p95", quantile(still, 0.95)},
           {"still_shift", quantile(in_picture, 0.5)},
           {"still_shift_p95", quantile(in_picture, 0.95)}};
  if (!moving.empty())
    out.update({{"moving_error", quantile(moving, 0.5)},
                {"moving_error_p90", quantile(moving, 0.9)},
                {"moving_true", quantile(travelled, 0.5)}});
  return out;
}

/// The pixels of a view that show something that moves, and those beside them.
PixelMask moving_pixels(const SynthScene& scene, const Frame& frame) {
  std::vector<SynthMoment> moments;
  for (int i = 0; i < kMoments; ++i) moments.push_back(scene.at(moment_of(i)));
  const SynthMoment now = scene.at(frame.time);
  const int w = frame.camera.width, h = frame.camera.height;
  PixelMask out(w, h);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const auto hit = now.trace(camera_ray(frame.camera, x + 0.5, y + 0.5));
      if (!hit || travel(moments, *hit) < kStill) continue;
      for (int v = std::max(0, y - 1); v <= std::min(h - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(w - 1, x + 1); ++u)
          out.set(std::size_t(v) * std::size_t(w) + std::size_t(u));
    }
  return out;
}

/// Mean PSNR of pixels beside those that `left_out` says of a view, dB.
template <class LeftOut>
double psnr_without(const VoxelModel& model, const Split& split, const LeftOut& left_out) {
  Renderer renderer(model);
  double db = 0;
  for (const Frame& f : split.frames)
    db += capped_psnr(psnr(clamped(renderer.render(f.camera, f.time).rgb),
                           composite(f.image, model.background.color), left_out(f)));
  return db / double(split.frames.size());
}

/// Effects as a run that is long enough to try them out chooses them.
Prepared prepare_as_train(Config config, Dataset& data) {
  const int steps = config.run.max_steps;
  config.run.max_steps = std::max(steps, kLongEnough * config.effects.steps);
  Prepared out = prepare(config, data);
  out.config.run.max_steps = steps;
  return out;
}

/// How well what was found to move in a film's pictures is what does.
nlohmann::json mask_figures(const Film& film, const Config& config) {
  const SynthScene scene = SynthScene::open(film.scene, film.options.look);
  Dataset data = make_synth(film.scene, film.options);
  const double start = processor_seconds();
  const Prepared ready = prepare(config, data, {.effects = EffectPolicy::keep});
  nlohmann::json j{{"film", film.name}, {"seed", film.options.seed}};
  j["prepare_seconds"] = processor_seconds() - start;
  double found = 0, all = 0, marked = 0;
  for (const Frame& f : data.find("train")->frames) {
    const PixelMask truth = moving_pixels(scene, f);
    for (int y = 0; y < f.camera.height; ++y)
      for (int x = 0; x < f.camera.width; ++x) {
        all += truth.test(x, y);
        marked += f.moving.test(x, y);
        found += truth.test(x, y) && f.moving.test(x, y);
      }
  }
  j["found"] = found / std::max(1.0, all);
  j["right"] = found / std::max(1.0, marked);
  j["truth_share"] = all / double(data.find("train")->frames.size()) / std::pow(film.options.size, 2);
  if (ready.effects.film) {
    j["psnr"] = ready.effects.film->psnr;
    j["share"] = ready.effects.film->share;
    j["coloured"] = ready.effects.film->coloured;
  }
  return j;
}

/// The masks that somebody would give who knows what moves.
void tell(const SynthScene& scene, Dataset& data) {
  for (Frame& f : data.find("train")->frames) f.moving = {moving_pixels(scene, f), 1};
  data.masks.emplace().use = "moving";
}

/// How bad tracks are made.
struct TrackFaults {
  double noise;  ///< of both coordinates, pixels
  double wrong;  ///< share of the points that wander off, by a fiftieth of the picture a step
};

void spoil(Split& train, const TrackFaults& faults, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  std::map<int, std::optional<std::pair<float, float>>> strays;  // of each point, how far off it is
  for (Frame& f : train.frames)
    for (VisiblePoint& p : f.tracks) {
      auto [at, is_new] = strays.try_emplace(p.point);
      if (is_new && std::uniform_real_distribution<>()(random) < faults.wrong) at->second = {0.0f, 0.0f};
      p.u += float(faults.noise) * normal(random);
      p.v += float(faults.noise) * normal(random);
      if (!at->second) continue;
      const float by = 0.02f * float(f.camera.width);
      at->second->first += by * normal(random);
      at->second->second += by * normal(random);
      p.u += at->second->first;
      p.v += at->second->second;
    }
  for (Frame& f : train.frames)
    std::erase_if(f.tracks, [&](const VisiblePoint& p) {
      return !(p.u >= 0 && p.v >= 0 && p.u < float(f.camera.width) && p.v < float(f.camera.height));
    });
}

nlohmann::json measure(const Film& film, const Config& config, bool tried, bool told,
                       const TrackFaults& faults) {
  const SynthScene scene = SynthScene::open(film.scene, film.options.look);
  Dataset data = make_synth(film.scene, film.options);
  if (told) tell(scene, data);
  spoil(*data.find("train"), faults, film.options.seed);
  const double start = processor_seconds();
  const Prepared ready =
      tried ? prepare_as_train(config, data) : prepare(config, data, {.effects = EffectPolicy::keep});
  const double prepared = processor_seconds();
  Trainer trainer(ready.config, *data.find("train"), data.time_map);
  while (!trainer.done()) trainer.step();
  const VoxelModel model = trainer.finish();
  const double trained = processor_seconds();
  const Split& test = *data.find("test");
  const ShownSurface shown(scene, *data.find("train"));
  nlohmann::json j{
      {"film", film.name},
      {"seed", film.options.seed},
      {"effects", to_string(ready.used)},
      {"off", mean_psnr(model, test)},
      {"off_still", psnr_without(model, test, [&](const Frame& f) { return moving_pixels(scene, f); })},
      {"off_seen", psnr_without(model, test, [&](const Frame& f) { return shown.unseen(f); })},
      {"on", mean_psnr(model, *data.find("val"))}};
  j.update(motion_figures(model, scene, *data.find("train")));
  Renderer renderer(model);
  const double asked = processor_seconds();
  if (const auto held = run::held_camera_test(model, renderer, *data.find("train"), *data.find("val"))) {
    j["held"] = 100 * held->median_share;
    j["held_p95"] = 100 * held->p95_share;
    j["held_proved"] = held->proved_share;
  }
  j["held_seconds"] = processor_seconds() - asked;
  j["moving_share"] = trainer.moving_share();
  j["prepare_seconds"] = prepared - start;
  j["train_seconds"] = trained - prepared;
  j["measure_seconds"] = processor_seconds() - trained;
  return j;
}

void say(const nlohmann::json& j) {
  fmt::print("{}\n", j.dump());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("what a film of one moving camera gives, where the truth is known");
  int seeds = 2, first = 1, size = 96, frames = 60, threads = 0;
  std::string only, effects = "auto";
  std::vector<std::string> scenes{"toy", "garden", "ball"};
  run::TrainOptions options;
  options.preset = "fast";
  options.max_time = 0;
  options.max_steps = 400;
  app.add_option("--seeds", seeds);
  app.add_option("--first", first, "the first seed; the others follow it");
  app.add_option("--steps", options.max_steps);
  app.add_option("--size", size);
  app.add_option("--frames", frames);
  app.add_option("--preset", options.preset);
  app.add_option("--scenes", scenes,
                 "built-in scenes that are filmed; static: what could be had if all stood still")
      ->delimiter(',');
  app.add_option("--only", only, "films whose names hold this");
  app.add_option("--effects", effects, "auto: tried out; all: those of the preset, motion among them")
      ->check(CLI::IsMember({"auto", "all"}));
  app.add_option("--set", options.sets, "of the configuration");
  app.add_option("--threads", threads, "0: every core");
  bool masks = false, told = false, tracks = false;
  double noise = 0, wrong = 0;
  std::optional<DepthKind> depth;
  app.add_flag("--masks", masks, "only look at what moves, train nothing");
  app.add_flag("--told", told, "true masks say what moves");
  app.add_flag("--tracks", tracks, "points are followed through the training pictures");
  app.add_option("--track-noise", noise, "of both coordinates of tracks, pixels");
  app.add_option("--track-wrong", wrong, "share of the tracks that wander off");
  app.add_option("--depth", depth, "training pictures have depth maps of this kind")
      ->transform(CLI::CheckedTransformer(std::map<std::string, DepthKind>{{"metric", DepthKind::metric},
                                                                           {"relative", DepthKind::relative},
                                                                           {"inverse", DepthKind::inverse}}));
  CLI11_PARSE(app, argc, argv);
  try {
    if (threads == 0) threads = thread_count();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
    std::map<std::string, std::vector<double>> figures;  // some films lack some of them
    int count = 0;
    for (Film film : films(scenes)) {
      if (film.name.find(only) == std::string::npos) continue;
      film.options.frames = frames;
      film.options.size = size;
      film.options.depth = depth;
      film.options.tracks = tracks;
      for (int seed = first; seed < first + seeds; ++seed) {
        film.options.seed = std::uint64_t(seed);
        options.seed = film.options.seed;
        const Config config = run::effective_config(options);
        const nlohmann::json j = masks ? mask_figures(film, config)
                                       : measure(film, config, effects == "auto", told, {noise, wrong});
        say(j);
        for (const auto& [name, value] : j.items())
          if (value.is_number() && name != "seed") figures[name].push_back(value.get<double>());
        ++count;
      }
    }
    nlohmann::json means{{"films", count}};
    for (const auto& [name, values] : figures)
      means[name] = std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
    say(means);
  } catch (const Error& error) {
    fmt::print(stderr, "bench_films: {}\n", error.what());
    return 2;
  }
}
