// SPDX-License-Identifier: Apache-2.0
#include "data/tracks/table_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "data/file_bytes.hpp"
#include "data/layouts/npy_file.hpp"
#include "data/message_text.hpp"
#include "data/npz_file.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTrackShape = "(points, pictures, 2) or (pictures, points, 2)";
/// Names of the arrays, as programs that follow points write them.
const std::vector<std::string> kPlaceNames = {"tracks", "pred_tracks", "trajectories"},
                               kSeenNames = {"visibility", "visible", "visibles", "pred_visibility"},
                               kHiddenNames = {"occluded", "occlusion", "pred_occluded"};
constexpr double kYes = 0.5;  ///< from which on a number says yes

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

/// The first of the names that is there.
std::optional<std::string> one_of(const std::vector<std::string>& there,
                                  const std::vector<std::string>& names) {
  const auto found = std::find_first_of(names.begin(), names.end(), there.begin(), there.end());
  return found == names.end() ? std::nullopt : std::optional(*found);
}

TrackArrays read_track_arrays(const fs::path& path, const std::string& where) {
  const std::vector<std::uint8_t> start = read_bytes(path, where, std::uintmax_t(1) << 40, 8);
  if (begins_with(start, kNpyMark))
    return {parse_npy(read_bytes(path, where, std::uintmax_t(1) << 31), where, true), {}, false};
  if (!begins_with(start, kZipMark))
    fail({where, "tracks of this kind are not read", "a .npy or .npz file, as numpy writes it",
          start.empty() ? "an empty file" : "something else", kWithoutTracks});
  const NpzFile file(path, where);  // what else is in it is nobody's concern
  const std::vector<std::string> all = file.names();
  const auto places = one_of(all, kPlaceNames), seen = one_of(all, kSeenNames),
             hidden = one_of(all, kHiddenNames);
  if (!places) {
    std::vector<std::string> names;
    for (const std::string& name : all) names.push_back(printable(name));
    fail({where, "there is no array of tracks in it", fmt::format("{}", fmt::join(kPlaceNames, " or ")),
          fmt::format("{}", fmt::join(names, ", ")), kWithoutTracks});
  }
  TrackArrays out{file.array(*places, true), {}, !seen && hidden};
  if (seen || hidden) out.seen = file.array(seen ? *seen : *hidden, true);
  return out;
}

/// Places and whether they are seen, by point and picture.
class TrackTable {
 public:
  /// @param counts  of pictures that the file may be of
  TrackTable(const TrackArrays& arrays, const std::vector<std::size_t>& counts, const std::string& where)
      : arrays_(arrays) {
    const std::vector<std::size_t>& shape = arrays.places.shape;
    const std::vector<std::size_t> axes = without_batch(shape, 3);
    if (axes.size() != 3 || axes[2] != 2)
      fail({where, "the tracks are of another shape", kTrackShape, axes_text(shape), kWithoutTracks});
    const auto is_count = [&](std::size_t length) {
      return std::find(counts.begin(), counts.end(), length) != counts.end();
    };
    const bool first = is_count(axes[0]), second = is_count(axes[1]);
    if (!first && !second)
      fail({where, "the tracks are of other pictures",
            fmt::format("{}, with as many pictures as {}", kTrackShape,
                        counts.size() > 1 ? fmt::format("the {} that train, or all {}", counts[0], counts[1])
                                          : fmt::format("the {} that train", counts[0])),
            axes_text(shape),
            "follow points through all pictures, in the order of time; or " + std::string(kWithoutTracks)});
    if (first && second)
      fail({where, "which axis is of points and which of pictures is not clear", kTrackShape,
            axes_text(shape), "leave out or add some points, so that they are not as many as pictures"});
    points_first_ = second;
    pictures_ = axes[second ? 1 : 0];
    points_ = axes[second ? 0 : 1];
    if (arrays.seen && without_ones(arrays.seen->shape) != without_ones({axes[0], axes[1]}))
      fail({where, "what is visible is of another shape than the tracks", axes_text({axes[0], axes[1]}),
            axes_text(arrays.seen->shape), kWithoutTracks});
  }
  std::size_t points() const { return points_; }
  std::size_t pictures() const { return pictures_; }
  /// None: it is not seen.
  std::optional<std::pair<double, double>> at(std::size_t point, std::size_t picture) const {
    const std::size_t i = points_first_ ? point * pictures_ + picture : picture * points_ + point;
    if (arrays_.seen && (arrays_.seen->values[i] >= kYes) == arrays_.hidden) return {};
    const double u = arrays_.places.values[2 * i], v = arrays_.places.values[2 * i + 1];
    if (!std::isfinite(u) || !std::isfinite(v)) return {};
    return std::pair{u, v};
  }

 private:
  const TrackArrays& arrays_;
  std::size_t pictures_ = 0, points_ = 0;
  bool points_first_ = false;
};

}  // namespace

FollowedPoints read_track_table(const fs::path& path, const std::string& where,
                                const std::vector<std::size_t>& counts) {
  const TrackArrays arrays = read_track_arrays(path, where);
  const TrackTable table(arrays, counts, where);
  FollowedPoints out{table.points(), std::vector<std::vector<VisiblePoint>>(table.pictures())};
  for (std::size_t k = 0; k < table.pictures(); ++k)
    for (std::size_t p = 0; p < table.points(); ++p)
      if (const auto at = table.at(p, k))
        out.seen[k].push_back({int(p), float(at->first), float(at->second)});
  return out;
}

}  // namespace splinevox::data
