// SPDX-License-Identifier: Apache-2.0
#include "train/state.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backend/background_gradient.hpp"
#include "math/schedule.hpp"
#include "train/effects/effect_table.hpp"
#include "train/film/moving_part.hpp"
#include "train/film/moving_tracks.hpp"
#include "train/paced.hpp"
#include "train/ray_batch.hpp"
#include "train/still/changing_cells.hpp"

namespace splinevox {
namespace {

/// A window of time is for what moves.
SamplingConfig sampling_of(const Config& config) {
  SamplingConfig out = config.sampling;
  if (!config.motion.enabled) out.window = 1;
  return out;
}

/// Whether Frame::moving says what moves. Cameras that stand still all the time know it better; those of a
/// film that rests for a while do not.
bool told_by_frames(const Setting& setting) {
  const std::vector<Frame>& frames = setting.train.frames;
  return !tell_cells(setting.still, setting.train) &&
         std::any_of(frames.begin(), frames.end(), [](const Frame& f) { return !f.moving.empty(); });
}

/// What moves in each frame: as the frames have it if `told`, else by cameras that stand still. Empty where
/// nothing is known or nothing is asked.
std::vector<CoarseMask> moving_in(const Setting& setting, bool told) {
  const std::vector<Frame>& frames = setting.train.frames;
  std::vector<CoarseMask> out(frames.size());
  for (const StillCamera& camera : setting.still)
    for (std::size_t i = 0; i < camera.frames.size(); ++i)
      out[std::size_t(camera.frames[i])] = camera.changing(i);
  for (std::size_t f = 0; f < frames.size() && told; ++f)
    if (!frames[f].moving.empty()) out[f] = frames[f].moving;
  const bool any = std::any_of(out.begin(), out.end(), [](const CoarseMask& m) { return !m.empty(); });
  return any && changes(effects_of(setting.config)) ? out : std::vector<CoarseMask>();
}

void archive_masks(Archive& a, const Split& train, std::vector<CoarseMask>& masks) {
  std::uint64_t count = masks.size();
  a(count);
  check_fits(count == 0 || count == train.frames.size());
  masks.resize(count);
  for (std::size_t f = 0; f < masks.size(); ++f) {
    CoarseMask& mask = masks[f];
    std::vector<std::uint64_t> words = mask.squares.words();
    a(mask.factor, words);
    if (a.reading() && words.empty()) mask = {};
    if (!a.reading() || words.empty()) continue;
    const Picture& image = train.frames[f].image;
    check_fits(mask.factor > 0 && mask.factor <= std::max(image.width, image.height));
    PixelMask squares(image.width / mask.factor, image.height / mask.factor);
    check_fits(squares.words().size() == words.size());
    squares.set_words(std::move(words));
    mask.squares = std::move(squares);
  }
}

/// @param masks  what moves in each frame, told by the frames if `told`
Volume starting_volume(const Setting& setting, const TimeMap& time_map, const std::vector<CoarseMask>& masks,
                       bool told) {
  const SceneBounds bounds = starting_bounds(setting.config, setting.train, setting.stats);
  MovingPart part;
  // What cameras that stand still see change is no mask of all that moves: they alone say what is static.
  if (freezes(setting.config))
    part.cells = told ? cells_that_move(masks, setting.train, bounds.box)
                      : changing_cells(setting.still, setting.train, bounds.box);
  part.proved = part.cells.cells() > 0;
  return {Lattices(setting, time_map, bounds.box),
          {bounds.hull, {}, {}},
          std::move(part),
          cameras_to_learn(setting.config.cameras, setting.train)};
}

}  // namespace

Trainer::State::State(const Config& config, const Split& train, const TimeMap& time_map, Ranks* r,
                      std::unique_ptr<StepBackend> backend)
    : setting(config, train),
      ranks(r),
      told(told_by_frames(setting)),
      moving(moving_in(setting, told)),
      home(starting_volume(setting, time_map, moving, told), std::move(backend)),
      sampler(train, home.read().lattices.model.box, sampling_of(config), config.run.seed, setting.unit),
      cameras(setting.config.cameras, home.read().cameras, setting.unit),
      errors(config.sampling.hard_share > 0 ? ErrorMap(train) : ErrorMap()),
      depths(starting_depth_fits(train, setting.config.loss.depth)),
      depth_weight(splinevox::depth_weight(train, setting.config.loss.depth)),
      followed(config.loss.tracks > 0 && config.motion.enabled ? points_that_move(train)
                                                               : std::vector<char>()) {
  tell_what_moves();
  if (home.surroundings().any())
    surroundings = SurroundingsLearner(setting.config, home.surroundings(), setting.unit);
}

/// To the sampler of rays.
void Trainer::State::tell_what_moves() {
  // Of a rig other cameras see what one does not. Its cells are known better, and need no prior.
  sampler.set_moving(moving, told ? setting.config.loss.still : 0);
}

bool Trainer::State::refine(double progress_now) {
  progress = progress_now;
  if (home.surroundings().any()) surroundings.refine(setting.config, progress, home.surroundings());
  // A run that goes on has left out what its pace did not allow: until that is known again nothing is added.
  const std::optional<double> batches = clock.batches(setting.config);
  plan.limit_stages(batches ? most_stages(*batches) : std::max(1, plan.counts().stages));
  sampler.set_share(batches ? batch_share(*batches) : 1);
  if (plan.due(setting.config, progress).empty()) return false;
  Volume& volume = home.change();
  const bool changed = plan.carry_out(setting, progress, clock.step > 0, window(), volume);
  sampler.set_box(volume.lattices.model.box);
  return changed;
}

bool Trainer::State::occupancy_is_due() const {
  const int whole = setting.config.sampling.occupancy_every;
  const int every = window().whole ? whole : std::max(1, whole / 2);
  return clock.step > 0 && (clock.step % every == 0 || cameras.strayed(home.cameras()));
}

void Trainer::State::refresh_occupancy() {
  cameras.look(home.cameras());
  splinevox::refresh_occupancy(setting, home.change(), window());
}

void Trainer::State::fit_depths() {
  if (!depths.empty() && depth_fit_is_due(clock.step))
    splinevox::fit_depths(setting, home.read(), window(), depths);
}

void Trainer::State::draw() {
  const bool by_error = !errors.empty() && progress >= setting.config.sampling.hard_start;
  sampler.draw(clock.step, progress, home.march_step(), home.background(), home.surroundings(), batch,
               home.cameras(), depths, by_error ? &errors : nullptr);
  if (!followed.empty())
    draw_tracks(setting.train, batch, followed, moving, home.box(), home.march_step(), tracks);
  batch.grids.clear();
  for (const int f : batch.frames) batch.grids.push_back(home.occupancy().grid_of(f));
}

RayLosses Trainer::State::ray_losses() const {
  const Config& c = setting.config;
  const double ramp = c.loss.ramp ? std::pow(0.01, 1 - progress) : 1.0;
  RayLosses losses;
  losses.stop = c.sampling.stop;
  losses.min_weight = c.sampling.min_weight;
  losses.visible_share = c.grid.seen_share;
  losses.faintest = kHalfLevel * setting.unit;
  losses.transmittance = progress >= c.loss.transmittance_start ? c.loss.transmittance : 0;
  losses.motion.offset = float(c.loss.offset * ramp);
  losses.motion.offset_rigidity = c.loss.offset_rigidity;
  losses.motion.offset_softening = 1e-4f * home.march_step();
  losses.motion.divergence = float(c.loss.divergence * ramp);
  losses.motion.hutchinson = c.loss.divergence_kind == DivergenceKind::hutchinson;
  losses.depth = depth_weight;
  losses.tracks = float(c.loss.tracks * cosine_decay(progress, 0.0));
  losses.track_scale = 1 / home.box().longest_edge();
  losses.probe_seed = batch.draw;
  return losses;
}

StepInput Trainer::State::step_input() {
  const OptimiserConfig& o = setting.config.optimiser;
  const LossConfig& loss = setting.config.loss;
  StepInput in{};
  in.rays = batch.rays;
  in.targets = batch.targets;
  in.depths = batch.depths;
  in.tasks = batch.tasks;
  in.tracks = tracks.view();
  in.times = batch.times;
  in.occupancy = batch.grids;
  in.background = &home.background();
  behind_.resize(batch.lines.size());
  in.behind = behind_;
  in.losses = ray_losses();
  lost.reset();
  if (own_loss) {
    colour_gradient_ = [this](std::span<const Vec3> colours, std::span<Vec3> gradients) {
      lost = own_loss(ray_batch(setting.train, batch, colours), gradients);
    };
    in.colour_gradient = &colour_gradient_;
  }
  in.tv_scale = float(std::pow(double(loss.tv_final), progress));
  in.tv_share = loss.tv_share;
  in.draw = batch.draw;
  in.factors = moment_factors(o.kind == OptimiserKind::adam ? o.beta1 : 0.0, o.beta2, o.epsilon,
                              double(clock.step + 1));
  in.radiance_rate = float(cosine_decay(progress, o.final_radiance));
  in.motion_rate = float(cosine_decay(progress, o.final_motion));
  in.errors = cameras.gains() || !errors.empty();
  in.slopes = cameras.clocks();
  return in;
}

void Trainer::State::learn_background(const StepInput& in, BackgroundGradient gradient) {
  if (home.surroundings().any()) {
    if (ranks) sum_over_ranks(*ranks, {&behind_[0].x, 3 * behind_.size()});
    surroundings.step(setting.config, batch.lines, behind_, home.background(), in, home.surroundings());
    gradient = background_gradient(home.background(), in.rays, in.tasks, behind_);
  }
  if (home.background().learned())
    update(home.background(), background, gradient, in.factors,
           setting.config.optimiser.lr_background * in.radiance_rate);
}

void Trainer::State::learn_cameras(const StepInput& in, const StepSums& sums) {
  if (!errors.empty()) errors.learn(batch.patches, sums.errors);
  cameras.update(home.cameras(), setting.train, batch, sums, in.factors, progress, in.motion_rate);
}

void Trainer::State::archive(Archive& a) {
  a.section("steps", [&] {
    a(clock.step);
    plan.archive(a);
  });
  a.section("clock", [&] { a(clock.seconds, clock.seconds_at_start, clock.phases); });
  home.archive(a, setting);
  a.section("background", [&] {
    const int order = home.background().order;
    a(home.background(), background);
    check_fits(home.background().order == order);
  });
  if (home.surroundings().any())
    a.section("surroundings",
              [&] { check_fits(surroundings.archive(a, setting.config, home.surroundings())); });
  a.section("moving", [&] {  // what cameras that stand still tell is found again
    if (a.reading() && told == a.exhausted()) {
      told = !told;
      if (!told) moving = moving_in(setting, told);  // as an older version began it
    }
    if (told) archive_masks(a, setting.train, moving);
  });
  a.section("cameras", [&] { cameras.archive(a, home.cameras()); });
  if (!errors.empty())
    a.section("errors", [&] {
      const std::size_t tiles = errors.tiles();
      errors.archive(a);
      check_fits(errors.tiles() == tiles);
    });
  if (const std::size_t frames = depths.size(); frames > 0)
    a.section("depths", [&] {
      a(depths);
      check_fits(depths.size() == frames);
    });
  if (!a.reading()) return;
  Volume& volume = home.change();
  check_fits(plan.fits(setting.config, volume.lattices));
  sampler.set_box(volume.lattices.model.box);
  tell_what_moves();
  plan.fit(setting, volume);
}

}  // namespace splinevox
