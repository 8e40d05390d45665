// SPDX-License-Identifier: Apache-2.0
#include "run/capture/frame_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "data/layouts/rig_footage.hpp"
#include "data/message_text.hpp"
#include "data/times/names.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

/// What tells when each camera's pictures were taken, ascending: equal numbers are one moment.
using Moments = std::vector<std::vector<double>>;

std::string name_of(const std::filesystem::path& picture) { return picture.filename().string(); }

/// The numbers in the names; none where they do not surely count the moments, in the pictures' order.
std::optional<Moments> moments_by_numbers(const std::vector<CaptureCamera>& cameras) {
  const bool several = cameras.size() > 1;
  std::vector<data::NamedPicture> pictures;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    for (const std::filesystem::path& picture : cameras[c].pictures)  // one camera alone moves
      pictures.push_back({(std::filesystem::path(cameras[c].name) / picture.filename()).generic_string(),
                          several ? c : pictures.size(), 0});
  const data::NamesRead read = data::read_names(pictures);
  if (read.verdict != data::NamesRead::Verdict::times || (several && !read.sure)) return {};
  Moments moments;
  auto next = read.times.begin();
  for (const CaptureCamera& camera : cameras) {
    const auto end = next + std::ptrdiff_t(camera.pictures.size());
    if (std::adjacent_find(next, end, std::greater_equal<>()) != end) return {};
    moments.emplace_back(next, end);
    next = end;
  }
  return moments;
}

/// All names that are used, where most of each camera's are those of the camera with the most pictures:
/// others may have stopped early. Else none.
std::vector<std::string> names_of_most(const std::vector<data::Footage>& footage) {
  const auto most = std::max_element(
      footage.begin(), footage.end(),
      [](const data::Footage& a, const data::Footage& b) { return a.pictures.size() < b.pictures.size(); });
  const std::set<std::string> long_list(most->pictures.begin(), most->pictures.end());
  std::set<std::string> all;
  for (const data::Footage& camera : footage) {
    const auto known = std::count_if(camera.pictures.begin(), camera.pictures.end(),
                                     [&](const std::string& name) { return long_list.contains(name); });
    if (2 * std::size_t(known) <= camera.pictures.size()) return {};
    all.insert(camera.pictures.begin(), camera.pictures.end());
  }
  return {all.begin(), all.end()};
}

/// The places of the names among all that are used, where most are used by several cameras; else none.
std::optional<Moments> moments_by_names(const std::vector<CaptureCamera>& cameras) {
  std::vector<data::Footage> footage;
  for (const CaptureCamera& camera : cameras) {
    footage.push_back({camera.name, "", {}});
    for (const std::filesystem::path& picture : camera.pictures)
      footage.back().pictures.push_back(name_of(picture));
  }
  std::vector<std::string> names = data::shared_names(footage);
  if (names.empty()) names = names_of_most(footage);
  if (names.empty()) return {};
  std::sort(names.begin(), names.end(), data::natural_less);
  Moments moments;
  for (const data::Footage& camera : footage) {
    moments.emplace_back();
    for (const std::string& name : camera.pictures)
      moments.back().push_back(
          double(std::lower_bound(names.begin(), names.end(), name, data::natural_less) - names.begin()));
  }
  return moments;
}

/// A name that pictures of two cameras have; empty if there is none.
std::string name_in_common(const std::vector<CaptureCamera>& cameras) {
  std::set<std::string> names;
  for (const CaptureCamera& camera : cameras)
    for (const std::filesystem::path& picture : camera.pictures)
      if (!names.insert(name_of(picture)).second) return name_of(picture);
  return {};
}

void note_gaps(const std::vector<CaptureCamera>& cameras, const Moments& moments, CaptureTalk& talk) {
  std::map<double, std::string> all;  // with what a picture of the moment is called
  for (std::size_t c = 0; c < cameras.size(); ++c)
    for (std::size_t i = 0; i < moments[c].size(); ++i)
      all.emplace(moments[c][i], name_of(cameras[c].pictures[i]));
  std::size_t missing = 0;
  std::string first;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    for (const auto& [moment, name] : all)
      if (!std::binary_search(moments[c].begin(), moments[c].end(), moment) && ++missing == 1)
        first = cameras[c].name + "/" + name;
  if (missing > 0)
    talk.note(fmt::format(
        "pictures are missing of moments that other cameras saw: {} of {}, such as {}; there these cameras "
        "have gaps",
        missing, cameras.size() * all.size(), data::in_quotes(first)));
}

/// Seconds from the first moment on. @pre there is one
Moments seconds_of(Moments moments, double fps, CaptureTalk& talk) {
  std::set<double> all;
  for (const std::vector<double>& camera : moments) all.insert(camera.begin(), camera.end());
  const double first = *all.begin();
  std::vector<double> steps;
  for (auto it = std::next(all.begin()); it != all.end(); ++it) steps.push_back(*it - *std::prev(it));
  double usual = 1;
  if (!steps.empty()) {
    const auto middle = steps.begin() + std::ptrdiff_t((steps.size() - 1) / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    usual = *middle;
  }
  const auto uneven = std::count_if(steps.begin(), steps.end(),
                                    [&](double step) { return std::abs(step - usual) > 1e-6 * usual; });
  if (uneven > 0)
    talk.note(fmt::format(
        "the numbers in names of pictures grow unevenly, {} of {} times by another step than the usual: "
        "times are by these numbers, --fps usual steps a second",
        uneven, steps.size()));
  for (std::vector<double>& camera : moments)
    for (double& time : camera) {
      const double usuals = (time - first) / usual;
      time = (uneven > 0 ? usuals : std::round(usuals)) / fps;
    }
  return moments;
}

}  // namespace

std::vector<double> ordered_times(std::size_t count, double fps) {
  std::vector<double> times;
  for (std::size_t i = 0; i < count; ++i) times.push_back(double(i) / fps);
  return times;
}

PictureTimes picture_times(const std::vector<CaptureCamera>& cameras, double fps, CaptureTalk& talk) {
  const bool several = cameras.size() > 1;
  std::optional<Moments> moments = moments_by_numbers(cameras);
  if (several && !moments) moments = moments_by_names(cameras);
  if (moments) {
    if (several) note_gaps(cameras, *moments, talk);
    return {seconds_of(std::move(*moments), fps, talk), true};
  }
  if (several) {
    if (const std::string name = name_in_common(cameras); !name.empty())
      fail({data::printable(cameras[0].pictures.at(0).parent_path().string()),
            "the names of pictures do not tell which cameras took at the same moment",
            "the same names in all folders for the same moments; or no name in common, where the order tells",
            data::in_quotes(name) + " is in two folders, most names are in one alone", "rename them"});
    talk.note(
        "cameras have no names of pictures in common: the first picture of each is taken for one moment, and "
        "so are the second, the third ...");
  }
  PictureTimes in_order;
  for (const CaptureCamera& camera : cameras)
    in_order.times.push_back(ordered_times(camera.pictures.size(), fps));
  return in_order;
}

std::vector<FrameGroup> frame_groups(const std::vector<double>& times, double from, double to, int every,
                                     int most) {
  constexpr double kSlack = 1e-6;  // seconds: what a person writes is rounded
  const auto begin = std::lower_bound(times.begin(), times.end(), from - kSlack);
  const int first = int(begin - times.begin()),
            count = int(std::upper_bound(begin, times.end(), to + kSlack) - begin);
  std::vector<FrameGroup> groups;
  if (every > 0) {
    for (int i = 0; i < count; i += every) groups.emplace_back(first + i, first + std::min(i + every, count));
    return groups;
  }
  const int number = most > 0 ? std::min(most, count) : count;
  const auto border = [&](int g) { return first + int(std::int64_t(g) * count / number); };
  for (int g = 0; g < number; ++g) groups.emplace_back(border(g), border(g + 1));
  return groups;
}

std::vector<FrameGroup> frames_at(const std::vector<double>& times, const std::vector<double>& moments) {
  std::vector<FrameGroup> groups;
  for (const double moment : moments) {
    auto at = std::lower_bound(times.begin(), times.end(), moment);
    if (at == times.end() || (at != times.begin() && moment - at[-1] < *at - moment)) --at;
    const int i = int(at - times.begin());
    if (groups.empty() || groups.back().first < i) groups.emplace_back(i, i + 1);
  }
  return groups;
}

double sharpness(std::span<const std::uint8_t> rgb, int width, int height) {
  if (width < 3 || height < 3) return 0;
  std::vector<int> grey(std::size_t(width) * std::size_t(height));  // times 1000
  for (std::size_t p = 0; p < grey.size(); ++p)
    grey[p] = 299 * rgb[3 * p] + 587 * rgb[3 * p + 1] + 114 * rgb[3 * p + 2];
  double sum = 0, squares = 0;
  for (int y = 1; y + 1 < height; ++y)
    for (int x = 1; x + 1 < width; ++x) {
      const int* p = grey.data() + std::size_t(y) * std::size_t(width) + x;
      const double laplacian = (p[-1] + p[1] + p[-width] + p[width] - 4.0 * p[0]) / 1000;
      sum += laplacian;
      squares += laplacian * laplacian;
    }
  const double count = double(width - 2) * double(height - 2), mean = sum / count;
  return squares / count - mean * mean;
}

}  // namespace splinevox::run
