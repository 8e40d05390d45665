// SPDX-License-Identifier: Apache-2.0
#include "data/tracks/tracks_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "data/layouts/folder_list.hpp"
#include "data/message_text.hpp"
#include "data/pictures/pictures.hpp"
#include "data/times/name_table.hpp"
#include "data/tracks/flow_file.hpp"
#include "data/tracks/follow_flow.hpp"
#include "data/tracks/followed.hpp"
#include "data/tracks/table_read.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

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

/// The file or folder, and how messages name it; none: there is none to read.
std::optional<std::pair<fs::path, std::string>> file_of(const fs::path& folder, const RawSplit& train,
                                                        const DatasetRules& rules) {
  if (rules.tracks == "none") return {};
  if (!rules.tracks.empty()) {
    std::error_code ignored;
    if (!fs::is_regular_file(rules.tracks, ignored) && !fs::is_directory(rules.tracks, ignored))
      fail({"--tracks", "there is no such file", "a .npy or .npz file of tracks, a folder of flow, or none",
            in_quotes(rules.tracks), ""});
    return std::pair{fs::path(rules.tracks), printable(rules.tracks)};
  }
  if (train.tracks.empty()) return {};
  const fs::path root = fs::canonical(folder);
  std::optional<fs::path> file = file_within(root, train.tracks);
  if (!file) file = folder_within(root, train.tracks);
  if (!file)
    fail({train.file, "'tracks_file_path' names nothing in the data set", "a path inside it, links resolved",
          in_quotes(train.tracks), kWithoutTracks});
  return std::pair{*file, printable((folder / train.tracks).string())};
}

void check_one_size(const RawSplit& train, const std::vector<PictureSize>& sizes, const std::string& where) {
  for (std::size_t i = 0; i < sizes.size(); ++i)
    if (sizes[i] != sizes[0])
      fail({where, "flow is of pictures of one size", size_text(sizes[0]),
            fmt::format("{} is {}", in_quotes(train.frames[i].file_path), size_text(sizes[i])),
            kWithoutTracks});
}

/// The first number in each name that is not the same in all; empty: there is none.
std::vector<double> first_numbers(const std::vector<std::string>& names) {
  std::vector<NamedPicture> pictures;
  for (const std::string& name : names) pictures.push_back({name});
  const Table table = table_of(pictures, false);
  std::vector<double> out;
  if (!table.columns.empty())
    for (const NameNumber& number : table.columns[0].numbers) out.push_back(number.value);
  return out;
}

std::vector<double> steps_of(const std::vector<double>& numbers) {
  std::vector<double> out;
  for (std::size_t k = 1; k < numbers.size(); ++k) out.push_back(numbers[k] - numbers[k - 1]);
  return out;
}

/// With one picture held out and the flow of one pair missing there are as many files as for the pictures
/// that train alone, and every point behind the gap would be a picture late. The files' numbers then skip
/// one where no picture was left out, nor do the pictures' own numbers.
void check_none_missing(const std::vector<std::string>& files, const RawSplit& train,
                        const std::vector<TrackPictures>& choices, const std::string& where) {
  if (choices.size() < 2 || files.size() < 2 || files.size() + 1 != choices[0].count) return;
  std::vector<std::string> pictures(choices[0].count);
  std::vector<double> order(choices[0].count);
  for (std::size_t f = 0; f < pictures.size(); ++f) {
    const std::size_t k = choices[0].place[f];
    pictures[k] = fs::path(train.frames[f].file_path).filename().string();
    order[k] = double(choices[1].place[f]);
  }
  const std::vector<double> steps = steps_of(first_numbers(files)), named = steps_of(first_numbers(pictures)),
                            left_out = steps_of(order);
  if (steps.empty()) return;
  const double usual = *std::min_element(steps.begin(), steps.end());
  const auto whole = [&](double step) { return usual > 0 && std::fmod(step, usual) == 0; };
  if (!std::all_of(steps.begin(), steps.end(), whole)) return;  // moments, say, and not a count
  for (std::size_t k = 0; k < steps.size(); ++k)
    if (steps[k] != usual && steps[k] != usual * left_out[k] && (named.empty() || steps[k] != named[k]))
      fail({where, "flow is missing between two of its files: no picture was left out there",
            "a file for each picture and the next",
            fmt::format("{} and then {}", in_quotes(files[k]), in_quotes(files[k + 1])), kWithoutTracks});
}

}  // namespace

std::optional<DatasetTracks> read_tracks(const fs::path& folder, const OpenScene& open,
                                         const LoadOptions& options, const std::vector<PictureSize>& sizes,
                                         std::vector<Frame>& frames, std::vector<std::string>& notes) {
  const RawSplit& train = open.scene.splits[0];
  const auto file = file_of(folder, train, options.rules);
  if (!file) return {};
  const auto& [path, where] = *file;
  const std::vector<TrackPictures> choices = pictures_told(open);
  std::vector<std::size_t> counts;
  for (const TrackPictures& pictures : choices) counts.push_back(pictures.count);
  const FollowedPoints followed = [&] {
    if (!fs::is_directory(path)) return read_track_table(path, where, counts);
    check_one_size(train, sizes, where);
    const FlowFiles files = find_flow(path, where);
    check_none_missing(files.forward, train, choices, where);
    return follow_flow(path, files, where, counts, sizes[0], notes);
  }();
  const TrackPictures& pictures =
      *std::find_if(choices.begin(), choices.end(),
                    [&](const TrackPictures& choice) { return choice.count == followed.seen.size(); });
  DatasetTracks out{where, followed.points, pictures.count, 0};
  std::size_t seen = 0, outside = 0;
  double furthest = 0;  // of what is seen, as a share of the picture
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (const VisiblePoint& p : followed.seen[pictures.place[f]]) {
      ++seen;
      furthest = std::max({furthest, double(p.u) / sizes[f].width, double(p.v) / sizes[f].height});
      const float x = p.u / float(options.downscale), y = p.v / float(options.downscale);
      if (x >= 0 && y >= 0 && x < float(frames[f].camera.width) && y < float(frames[f].camera.height))
        frames[f].tracks.push_back({p.point, x, y});
      else
        ++outside;
    }
  }
  if (seen == 0)
    fail({where, "no point is seen in any picture that trains", "finite places where points are visible",
          fmt::format("{} points, all hidden", out.points), kWithoutTracks});
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
  out.visible = double(seen - outside) / (double(out.points) * double(frames.size()));
  notes.push_back(fmt::format("tracks of {} points through {} pictures, from {}: {:.0f}% are visible",
                              out.points, out.pictures, where, 100 * out.visible));
  return out;
}

}  // namespace splinevox::data
