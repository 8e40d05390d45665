// SPDX-License-Identifier: Apache-2.0
#include "run/capture/capture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/atomic_file.hpp"
#include "core/own_folder.hpp"
#include "core/stopwatch.hpp"
#include "data/message_text.hpp"
#include "run/capture/capture_stages.hpp"
#include "run/folder_lock.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

namespace fs = std::filesystem;
using data::printable;

void check_options(const CaptureOptions& o) {
  const auto require = [](bool ok, const char* option, const char* expected, double got) {
    if (!ok) fail({option, "out of range", expected, fmt::format("{}", got), ""});
  };
  require(o.every >= 0, "--every", "1 or more frames", o.every);
  require(o.frames >= 0, "--frames", "2 or more frames", o.frames);
  require(o.from >= 0 && std::isfinite(o.from), "--from", "0 or more seconds", o.from);
  require(o.to > o.from, "--to", "more seconds than --from", o.to);
  require(o.max_size == 0 || o.max_size >= 64, "--max-size", "64 or more pixels, or 0: as they are",
          o.max_size);
  require(o.fps > 0 && std::isfinite(o.fps), "--fps", "more than 0 pictures a second", o.fps);
  require(o.moments >= 1, "--moments", "1 or more", o.moments);
  if (o.every > 0 && o.frames > 0)
    fail({"--every and --frames", "both say how many frames are taken", "one of them", "", ""});
  const std::vector<std::string> lenses = capture_lenses();
  if (!o.lens.empty() && std::find(lenses.begin(), lenses.end(), o.lens) == lenses.end())
    fail({"--lens", "there is no such lens", fmt::format("{}", fmt::join(lenses, ", ")), o.lens, ""});
}

/// What capture writes in the folder.
constexpr const char* kWritten[] = {"capture.json", "transforms.json", "masks", "images", "work"};
/// Where what an earlier call wrote lies until the new data set is there, and while it is moved there.
constexpr const char *kAside = "earlier_capture", *kMoving = "earlier_capture.part";

/// Refuses sources that lie where capture writes: it would remove them. @param out  folder of the data set
void require_outside(const std::vector<fs::path>& sources, const fs::path& out) {
  std::vector<fs::path> written;
  for (const char* name : kWritten) written.push_back(fs::weakly_canonical(fs::absolute(out / name)));
  for (const char* name : {kAside, kMoving})
    written.push_back(fs::weakly_canonical(fs::absolute(out / name)));
  for (const fs::path& source : sources) {
    const fs::path whole = fs::absolute(source);
    // A link lies in one place, what it leads to in another.
    for (const fs::path& place :
         {fs::weakly_canonical(whole), fs::weakly_canonical(whole.parent_path()) / whole.filename()})
      for (const fs::path& folder : written) {
        const fs::path inside = place.lexically_relative(folder);
        if (!inside.empty() && *inside.begin() != "..")
          fail({printable(source.string()), "this source lies where capture writes and removes",
                "films, pictures and masks elsewhere than in " + printable(folder.string()), "",
                "another folder for --out, or the sources copied to another place"});
      }
  }
}

std::vector<fs::path> files_of(const CaptureCamera& camera) {
  if (camera.is_film()) return {camera.film};
  return camera.pictures;
}

/// What decides what comes out: the options, and the files by their names and sizes.
Json request_of(const CaptureOptions& o, const std::vector<CaptureCamera>& cameras) {
  Json sources = Json::array();
  for (const CaptureCamera& camera : cameras) {
    std::uintmax_t bytes = camera.is_film() ? fs::file_size(camera.film) : 0;
    for (const fs::path& picture : camera.pictures) bytes += fs::file_size(picture);
    const fs::path first = camera.is_film() ? camera.film : camera.pictures.at(0);
    sources.push_back({{"name", camera.name},
                       {"first", fs::canonical(first).string()},
                       {"pictures", camera.pictures.size()},
                       {"bytes", bytes}});
  }
  Json to = std::isfinite(o.to) ? Json(o.to) : Json();
  return {{"sources", sources}, {"every", o.every},       {"frames", o.frames}, {"from", o.from},
          {"to", to},           {"max_size", o.max_size}, {"fps", o.fps},       {"masks", o.masks},
          {"lens", o.lens},     {"moments", o.moments}};
}

/// One call of `capture`.
class Capture {
 public:
  Capture(const CaptureOptions& options, CaptureTalk& talk)
      : options_(options), talk_(talk), folder_(options.out) {}

  Json run() {
    check_options(options_);
    std::vector<CaptureCamera> cameras = find_capture_input(options_.sources);
    if (!options_.walk.empty()) cameras.push_back(find_walk(cameras));
    for (const CaptureCamera& camera : cameras) require_outside(files_of(camera), folder_);
    claim_folder();
    const FolderLock lock(options_.out, "capturing into");
    open_folder(request_of(options_, cameras));
    ColmapProgram colmap(folder_ / "work/colmap.log", talk_);
    stage(1, "frames", [&] { take_frames(cameras); });
    stage(2, "features", [&] { find_features(folder_, state_, options_, colmap, talk_); });
    stage(3, "matches", [&] { match_features(folder_, state_, options_, colmap, false); });
    if (state_.straight && state_.done < 4) forget_straight();
    stage(4, "cameras", [&] { find_cameras(folder_, state_, options_, colmap); });
    std::optional<Solved> solved = solve();
    if (few(solved) && !state_.of_rig() && !state_.wide && int(state_.frames.size()) > kAllCompared) {
      talk_.note(fmt::format("{} of {} pictures were placed: they are compared with more of the others",
                             placed(solved), state_.frames.size()));
      state_.wide = true;
      state_.done = 2;
      stage(3, "matches", [&] { match_features(folder_, state_, options_, colmap, true); });
      stage(4, "cameras", [&] { find_cameras(folder_, state_, options_, colmap); });
      solved = solve();
    }
    if (solved && few(solved) && may_try_straight(solved->scene)) try_straight(solved, colmap);
    if (!solved) fail_placing(state_, "no model; " + colmap.last_lines());
    return finish(*solved, colmap.version());
  }

 private:
  static constexpr double kMost = 0.9;  ///< a share placed that is not worth a second search

  struct Solved {
    data::ColmapModel model;
    int models = 0;
    CapturedScene scene;
  };

  static int placed(const std::optional<Solved>& solved) { return solved ? solved->scene.placed : 0; }
  static bool few(const std::optional<Solved>& solved) {
    return !solved || placed(solved) < kMost * solved->scene.asked;
  }

  /// Not where an earlier call has, whether it placed more or not.
  bool may_try_straight(const CapturedScene& scene) const {
    std::error_code ignored;
    return scene.odd_lenses > 0 && options_.lens != "pinhole" &&
           !fs::exists(folder_ / CaptureState::kStraightModels, ignored);
  }

  /// A lens whose distortion ran away takes the cameras with it: once more without any, if that places more.
  void try_straight(std::optional<Solved>& solved, ColmapProgram& colmap) {
    talk_.note(fmt::format("{} got a lens that no camera has: cameras are found again without distortion",
                           solved->scene.odd_lenses));
    state_.straight = true;
    state_.done = 3;
    write_capture_state(folder_, state_);
    stage(4, "cameras", [&] { find_cameras(folder_, state_, options_, colmap); });
    std::optional<Solved> straight = solve();
    state_.straight = placed(straight) > placed(solved);
    if (state_.straight) solved = std::move(straight);
    write_capture_state(folder_, state_);
  }

  /// An earlier call was stopped in it: it is to be compared with what was found before.
  void forget_straight() {
    fs::remove_all(folder_ / CaptureState::kStraightModels);
    state_.straight = false;
    state_.done = 4;
  }

  CaptureCamera find_walk(const std::vector<CaptureCamera>& cameras) const {
    std::vector<CaptureCamera> walk = find_capture_input({options_.walk});
    if (cameras.size() == 1 || walk.size() > 1)
      fail({"--walk", "it is one camera that moves, past several that stand still",
            "SOURCEs of several cameras, and one film or folder",
            fmt::format("{} and {} of them", cameras.size(), walk.size()), ""});
    walk[0].name = kWalk;
    const fs::path own = files_of(walk[0])[0];
    for (const CaptureCamera& camera : cameras)
      if (fs::equivalent(own, files_of(camera)[0]))
        fail({printable(options_.walk), "the walk is also one of the cameras that stand still",
              "SOURCEs without it", printable(camera.name),
              "move it to another folder, or name each SOURCE"});
    for (const CaptureCamera& camera : cameras)
      if (camera.name == kWalk)
        fail({printable(options_.walk), "a camera has the name that is the walk's", "another name", kWalk,
              "rename that film or folder"});
    return walk[0];
  }

  /// A folder that is empty or an earlier call's. Nothing in it is changed before it is locked.
  void claim_folder() const {
    std::error_code ignored;
    const bool there = fs::exists(folder_, ignored);
    // A call that was to begin anew was stopped: before it had moved all, or before it wrote a new state.
    const auto moving = [&](const char* name) { return fs::exists(folder_ / kMoving / name, ignored); };
    const bool ours = fs::exists(folder_ / "work/state.json", ignored) ||
                      std::any_of(std::begin(kWritten), std::end(kWritten), moving) ||
                      (!fs::exists(folder_ / "capture.json", ignored) &&
                       fs::exists(folder_ / kAside / "work/state.json", ignored));
    if (there && !ours && !(fs::is_directory(folder_) && names_in_folder(options_.out).empty()))
      fail({printable(options_.out), "there is something of that name already",
            "an empty folder, a name that is free, or a folder that capture began", "",
            "another folder for --out"});
    probe_output_folder(options_.out);
  }

  /// What an earlier call did, unless it is to be begun anew. It stays until clear_folder.
  void open_folder(const Json& request) {
    bring_back();
    if (!options_.fresh) state_ = read_capture_state(folder_);
    if (!state_.request.is_null() && state_.request != request)
      fail({printable(options_.out), "this folder was made from other films or with other options",
            "the same as then: " + json_text(state_.request), json_text(request),
            "--fresh begins anew, or another folder for --out"});
    state_.request = request;
  }

  /// What a call began to set aside that was stopped meanwhile.
  void bring_back() const {
    const fs::path moving = folder_ / kMoving;
    if (!fs::exists(moving)) return;
    for (const char* name : kWritten)
      if (fs::exists(moving / name) && !fs::exists(folder_ / name)) fs::rename(moving / name, folder_ / name);
    std::error_code not_empty;
    fs::remove(moving, not_empty);
  }

  /// Of several calls that begin anew and are stopped, the first sets aside what was there.
  void set_aside() const {
    const fs::path aside = folder_ / kAside, moving = folder_ / kMoving;
    if (fs::exists(folder_ / "capture.json")) drop_aside();  // it is written last: this is newer and whole
    const auto kept = [&](const char* name) { return fs::exists(aside / name); };
    if (std::any_of(std::begin(kWritten), std::end(kWritten), kept)) {
      for (const char* name : kWritten) fs::remove_all(folder_ / name);
    } else if (fs::exists(folder_ / "work")) {
      if (fs::exists(aside))
        fail({printable(aside.string()), "there is something of that name that capture did not write",
              "a name that is free, for what an earlier call made", "", "move it away"});
      fs::create_directories(moving);
      for (const char* name : kWritten)
        if (fs::exists(folder_ / name)) fs::rename(folder_ / name, moving / name);
      fs::rename(moving, aside);
    }
  }

  void drop_aside() const {
    if (const fs::path kept = keep_drawn_masks(folder_, kAside); !kept.empty())
      talk_.note(fmt::format("{} has masks that capture did not write", printable(kept.string())));
    for (const char* name : kWritten) fs::remove_all(folder_ / kAside / name);
    std::error_code ignored;  // what is still in it is a user's
    fs::remove(folder_ / kAside, ignored);
  }

  /// Removes what new frames replace. From here on the folder says what it is made from.
  void clear_folder() const {
    if (options_.fresh) set_aside();
    for (const char* name : {"images", "masks", "work/masks"}) fs::remove_all(folder_ / name);
    fs::create_directories(folder_ / "work");
    write_capture_state(folder_, state_);
  }

  void stage(int number, const std::string& name, const std::function<void()>& work) {
    if (state_.done >= number) return;
    talk_.stage(number, name);
    const Timer timer;
    work();
    state_.seconds[name] = std::round(10 * timer.seconds()) / 10 + state_.seconds.value(name, 0.0);
    keep_notes();
    state_.done = number;
    write_capture_state(folder_, state_);
  }

  /// Those of earlier calls stay.
  void keep_notes() {
    for (const std::string& note : talk_.notes())
      if (std::find(state_.notes.begin(), state_.notes.end(), note) == state_.notes.end())
        state_.notes.push_back(note);
  }

  void take_frames(std::vector<CaptureCamera> cameras) {
    std::optional<CaptureCamera> walk;
    if (!options_.walk.empty()) {
      walk = std::move(cameras.back());
      cameras.pop_back();
    }
    std::vector<CapturePlan> plans = plan_capture(std::move(cameras), options_, talk_);
    state_.rig.clear();
    if (plans.size() > 1)
      for (const CapturePlan& plan : plans) state_.rig.push_back(plan.camera.name);
    if (walk) plans.push_back(plan_walk(std::move(*walk), options_, talk_));
    check_plans(plans);
    clear_folder();
    state_.frames = write_capture_frames(plans, folder_, talk_);
    state_.numbered = needs_numbers(state_);
  }

  /// What can be told before anything is removed.
  void check_plans(const std::vector<CapturePlan>& plans) const {
    std::size_t pictures = 0;
    std::vector<fs::path> masks;
    for (const CapturePlan& plan : plans) {
      pictures += plan.groups.size();
      std::copy_if(plan.masks.files.begin(), plan.masks.files.end(), std::back_inserter(masks),
                   [](const fs::path& mask) { return !mask.empty(); });
    }
    require_outside(masks, folder_);
    if (pictures < 3)
      fail({printable(options_.out), "there are too few pictures", "3 or more", fmt::format("{}", pictures),
            "a smaller --every, or more of --from to --to"});
  }

  std::optional<Solved> solve() const {
    const auto found = largest_model(folder_ / state_.models());
    if (!found) return {};
    Solved solved{data::read_colmap_binary(found->first), found->second, {}};
    name_frames(solved.model, state_);
    solved.scene = place_frames(solved.model, state_.frames, state_.rig);
    return solved;
  }

  Json finish(const Solved& solved, const std::string& version) {
    const CapturedScene& scene = solved.scene;
    const bool rig = state_.of_rig();
    const std::string what = rig ? "cameras" : "pictures",
                      share = fmt::format("{} of {} {}", scene.placed, scene.asked, what);
    const std::string odd =
        scene.odd_lenses == 0
            ? ""
            : fmt::format("; {} with a lens that no camera has: --lens radial, or pinhole", scene.odd_lenses);
    if (scene.placed < kLeastPlaced * scene.asked) fail_placing(state_, share + odd);
    talk_.stage(5, "data set");
    if (const std::string note = models_note(solved.models, scene, share); !note.empty()) talk_.note(note);
    if (!scene.left_out.empty())
      talk_.note(fmt::format("{} {} found no place and are left out, such as {}{}", scene.left_out.size(),
                             what, data::in_quotes(scene.left_out[0]), odd));
    if (!rig && scene.parallax < 0.1)
      talk_.note(
          fmt::format("the camera went only {:.1f}% of the distance to what it sees: depth is hardly "
                      "determined; walk sideways or around",
                      100 * scene.parallax));
    if (scene.unrest > 0.02)
      talk_.note(
          fmt::format("cameras seem to move: places of one differ by {:.1f}% of the distance to what "
                      "it sees; the mean is taken",
                      100 * scene.unrest));
    write_transforms(folder_, state_, scene);
    keep_notes();
    const Json figures{{"kind", rig ? "cameras that stand still" : "one camera that moves"},
                       {"pictures", state_.frames.size()},
                       {"written", scene.frames.size()},
                       {"things", what},
                       {"asked", scene.asked},
                       {"placed", scene.placed},
                       {"share", double(scene.placed) / scene.asked},
                       {"reprojection_error", solved.model.error},
                       {"points", solved.model.points.size()},
                       {"observations", solved.model.observations},
                       {"models", solved.models},
                       {"scale", scene.scale},
                       {"parallax", scene.parallax},
                       {"unrest", scene.unrest},
                       {"left_out", scene.left_out},
                       {"colmap", version},
                       {"splinevox", kVersion},
                       {"seconds", state_.seconds},
                       {"request", state_.request},
                       {"notes", state_.notes}};
    write_file((folder_ / "capture.json").string(), {json_text(figures, 1) + "\n"});
    drop_aside();
    return figures;
  }

  const CaptureOptions& options_;
  CaptureTalk& talk_;
  fs::path folder_;
  CaptureState state_;
};

}  // namespace

Json capture(const CaptureOptions& options, CaptureTalk& talk) { return Capture(options, talk).run(); }

}  // namespace splinevox::run
