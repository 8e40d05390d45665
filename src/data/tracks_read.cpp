// SPDX-License-Identifier: Apache-2.0
#include "data/tracks_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <map>
#include <numeric>
#include <string_view>
#include <utility>

#include "data/file_bytes.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/layouts/npy_file.hpp"
#include "data/message_text.hpp"
#include "data/npz_file.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWithoutTracks = "--tracks none trains without tracks";
constexpr const char* kTrackShape = "(points, pictures, 2) or (pictures, points, 2)";
/// Names of the arrays, as programs that follow points write them.
const std::vector<std::string> kPlaceNames = {"tracks", "pred_tracks", "trajectories"},
                               kSeenNames = {"visibility", "visible", "visibles", "pred_visibility"},
                               kHiddenNames = {"occluded", "occlusion", "pred_occluded"};
constexpr double kYes = 0.5;  ///< from which on a number says yes

std::string axes_text(const std::vector<std::size_t>& shape) {
  return fmt::format("({})", fmt::join(shape, ", "));
}

/// Without axes of length 1: a batch of one film, or of one number.
std::vector<std::size_t> without_ones(const std::vector<std::size_t>& shape) {
  std::vector<std::size_t> out = shape;
  std::erase(out, std::size_t(1));
  return out;
}

/// What a file has.
struct TrackArrays {
  NpyArray places;
  std::optional<NpyArray> seen;
  bool hidden = false;  ///< `seen` says the opposite
};

std::optional<std::string> one_of(const std::map<std::string, NpyArray>& arrays,
                                  const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (arrays.contains(name)) return name;
  return {};
}

TrackArrays read_track_arrays(const fs::path& path, const std::string& where) {
  const std::vector<std::uint8_t> start = read_bytes(path, where, std::uintmax_t(1) << 40, 8);
  const auto begins = [&](std::string_view with) {
    return start.size() >= with.size() && std::memcmp(start.data(), with.data(), with.size()) == 0;
  };
  if (begins("\x93NUMPY"))
    return {parse_npy(read_bytes(path, where, std::uintmax_t(1) << 31), where, true), {}, false};
  if (!begins("PK\x03\x04"))
    fail({where, "tracks of this kind are not read", "a .npy or .npz file, as numpy writes it",
          start.empty() ? "an empty file" : "something else", kWithoutTracks});
  std::map<std::string, NpyArray> all = read_npz(path, where);
  const auto places = one_of(all, kPlaceNames), seen = one_of(all, kSeenNames),
             hidden = one_of(all, kHiddenNames);
  if (!places) {
    std::vector<std::string> names;
    for (const auto& [name, array] : all) names.push_back(printable(name));
    fail({where, "there is no array of tracks in it", fmt::format("{}", fmt::join(kPlaceNames, " or ")),
          fmt::format("{}", fmt::join(names, ", ")), kWithoutTracks});
  }
  TrackArrays out{std::move(all[*places]), {}, !seen && hidden};
  if (seen || hidden) out.seen = std::move(all[seen ? *seen : *hidden]);
  return out;
}

/// TrackPictures of which a file may tell: the train split's frames, each with its place in the order of
/// time.
struct TrackPictures {
  std::size_t count;               ///< in the order
  std::vector<std::size_t> place;  ///< of each frame
};

/// The train split's own pictures, then those of the whole scene where those are more.
std::vector<TrackPictures> pictures_told(const OpenScene& open) {
  const RawSplit& train = open.scene.splits[0];
  const std::size_t n = train.frames.size();
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t(0));
  const auto time = [&](std::size_t i) { return train.frames[i].time; };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return time(a) < time(b); });
  std::vector<TrackPictures> out{{n, std::vector<std::size_t>(n)}};
  for (std::size_t k = 0; k < n; ++k) {
    out[0].place[order[k]] = k;
    if (k > 0 && time(order[k]) == time(order[k - 1]))
      fail({train.file, "two pictures are of one moment, so not of one camera",
            "tracks through one camera's film",
            fmt::format("{} and {} at time {}", in_quotes(train.frames[order[k - 1]].file_path),
                        in_quotes(train.frames[order[k]].file_path), number(time(order[k]))),
            kWithoutTracks});
  }
  if (open.pictures <= n) return out;
  out.push_back({open.pictures, {}});
  for (const RawFrame& frame : train.frames) out.back().place.push_back(frame.order);
  return out;
}

/// Places and whether they are seen, by point and picture.
class TrackTable {
 public:
  /// @param counts  of pictures that the file may be of
  TrackTable(const TrackArrays& arrays, const std::vector<TrackPictures>& choices, const std::string& where)
      : arrays_(arrays) {
    const std::vector<std::size_t>& shape = arrays.places.shape;
    std::vector<std::size_t> axes = shape;
    while (axes.size() > 3 && axes[0] == 1) axes.erase(axes.begin());
    if (axes.size() != 3 || axes[2] != 2)
      fail({where, "the tracks are of another shape", kTrackShape, axes_text(shape), kWithoutTracks});
    const auto of = [&](std::size_t length) {
      return std::find_if(choices.begin(), choices.end(),
                          [&](const TrackPictures& p) { return p.count == length; });
    };
    const auto first = of(axes[0]), second = of(axes[1]);
    std::vector<std::size_t> counts;
    for (const TrackPictures& p : choices) counts.push_back(p.count);
    if (first == choices.end() && second == choices.end())
      fail({where, "the tracks are of other pictures",
            fmt::format("{}, with as many pictures as {}", kTrackShape,
                        counts.size() > 1 ? fmt::format("the {} that train, or all {}", counts[0], counts[1])
                                          : fmt::format("the {} that train", counts[0])),
            axes_text(shape),
            "follow points through all pictures, in the order of time; or " + std::string(kWithoutTracks)});
    if (first != choices.end() && second != choices.end())
      fail({where, "which axis is of points and which of pictures is not clear", kTrackShape,
            axes_text(shape), "leave out or add some points, so that they are not as many as pictures"});
    points_first_ = second != choices.end();
    pictures_ = points_first_ ? &*second : &*first;
    points_ = axes[points_first_ ? 0 : 1];
    if (arrays.seen && without_ones(arrays.seen->shape) != without_ones({axes[0], axes[1]}))
      fail({where, "what is visible is of another shape than the tracks", axes_text({axes[0], axes[1]}),
            axes_text(arrays.seen->shape), kWithoutTracks});
  }
  std::size_t points() const { return points_; }
  const TrackPictures& pictures() const { return *pictures_; }
  /// None: it is not seen.
  std::optional<std::pair<double, double>> at(std::size_t point, std::size_t picture) const {
    const std::size_t i = points_first_ ? point * pictures_->count + picture : picture * points_ + point;
    if (arrays_.seen && (arrays_.seen->values[i] >= kYes) == arrays_.hidden) return {};
    const double u = arrays_.places.values[2 * i], v = arrays_.places.values[2 * i + 1];
    if (!std::isfinite(u) || !std::isfinite(v)) return {};
    return std::pair{u, v};
  }

 private:
  const TrackArrays& arrays_;
  const TrackPictures* pictures_;
  std::size_t points_ = 0;
  bool points_first_ = false;
};

/// The file, and how messages name it; none: there is none to read.
std::optional<std::pair<fs::path, std::string>> file_of(const fs::path& folder, const RawSplit& train,
                                                        const DatasetRules& rules) {
  if (rules.tracks == "none") return {};
  if (!rules.tracks.empty()) {
    std::error_code ignored;
    if (!fs::is_regular_file(rules.tracks, ignored))
      fail({"--tracks", "there is no such file", "a .npy or .npz file of tracks, or none",
            in_quotes(rules.tracks), ""});
    return std::pair{fs::path(rules.tracks), printable(rules.tracks)};
  }
  if (train.tracks.empty()) return {};
  const std::optional<fs::path> file = file_within(fs::canonical(folder), train.tracks);
  if (!file)
    fail({train.file, "'tracks_file_path' names no file of the data set", "a path inside it, links resolved",
          in_quotes(train.tracks), kWithoutTracks});
  return std::pair{*file, printable((folder / train.tracks).string())};
}

}  // namespace

std::optional<DatasetTracks> read_tracks(const fs::path& folder, const OpenScene& open,
                                         const LoadOptions& options, const std::vector<PictureSize>& sizes,
                                         std::vector<Frame>& frames, std::vector<std::string>& notes) {
  const RawSplit& train = open.scene.splits[0];
  const auto file = file_of(folder, train, options.rules);
  if (!file) return {};
  const auto& [path, where] = *file;
  const std::vector<TrackPictures> pictures = pictures_told(open);
  const TrackArrays arrays = read_track_arrays(path, where);
  const TrackTable table(arrays, pictures, where);
  DatasetTracks out{where, table.points(), table.pictures().count, 0};
  std::size_t seen = 0, outside = 0;
  double furthest = 0;  // of what is seen, as a share of the picture
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (std::size_t p = 0; p < table.points(); ++p) {
      const auto at = table.at(p, table.pictures().place[f]);
      if (!at) continue;
      ++seen;
      const auto [u, v] = *at;
      furthest = std::max({furthest, u / sizes[f].width, v / sizes[f].height});
      const double x = u / options.downscale, y = v / options.downscale;
      if (x >= 0 && y >= 0 && x < frames[f].camera.width && y < frames[f].camera.height)
        frames[f].tracks.push_back({int(p), float(x), float(y)});
      else
        ++outside;
    }
  }
  if (seen == 0)
    fail({where, "no point is seen in any picture that trains", "finite places where points are visible",
          fmt::format("{} points, all hidden", table.points()), kWithoutTracks});
  constexpr double kMostOutside = 0.5, kSmaller = 0.6;
  if (double(outside) > kMostOutside * double(seen))
    fail({where, "most places are outside of their pictures",
          "pixels of pictures of " + size_text(sizes[0]) + ", the centre of the first at (0.5, 0.5)",
          fmt::format("{:.0f}% outside", 100.0 * double(outside) / double(seen)),
          "multiply the places by the size of the pictures over that of those that were followed"});
  if (furthest < kSmaller)
    notes.push_back(fmt::format(
        "tracks reach {:.0f}% of the pictures' size: were they made on smaller pictures?", 100 * furthest));
  if (outside > 0) notes.push_back(fmt::format("{} places of tracks are outside of their pictures", outside));
  out.visible = double(seen - outside) / (double(table.points()) * double(frames.size()));
  notes.push_back(fmt::format("tracks of {} points through {} pictures, from {}: {:.0f}% are visible",
                              out.points, out.pictures, where, 100 * out.visible));
  return out;
}

}  // namespace splinevox::data
