// SPDX-License-Identifier: Apache-2.0
#include "data/tracks/follow_flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "core/in_order.hpp"
#include "core/parallel.hpp"
#include "data/message_text.hpp"
#include "data/pictures/pictures.hpp"
#include "data/tracks/flow_file.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

constexpr int kAcross = 48;                             ///< squares of the grid along the longer side
constexpr int kLongest = 32;                            ///< pictures of one point
constexpr double kShareBack = 0.01, kPixelsBack = 0.5;  ///< eq. 5, of squared pixels of the flow

/// Flow from a picture to the next, and back if there is any.
struct Between {
  FlowField forward;
  std::optional<FlowField> backward;
};

/// Where flow leads a point; none: it is lost.
std::optional<PixelPlace> next_place(const Between& flow, PixelPlace at) {
  const auto way = flow.forward.at(at);
  if (!way) return {};
  const PixelPlace next{at.u + way->u, at.v + way->v};
  if (!(next.u >= 0 && next.v >= 0 && next.u < flow.forward.size.width && next.v < flow.forward.size.height))
    return {};
  if (!flow.backward) return next;
  const auto back = flow.backward->at(next);
  if (!back) return {};
  const auto squared = [](double u, double v) { return u * u + v * v; };
  const double off = squared(way->u + back->u, way->v + back->v);
  const double ways = squared(way->u, way->v) + squared(back->u, back->v);
  if (off > kShareBack * ways + kPixelsBack) return {};
  return next;
}

/// The points that are in a picture, in pixels of its flow, at most one a square.
class PointsInPicture {
 public:
  explicit PointsInPicture(const PictureSize& size)
      : side_(double(std::max(size.width, size.height)) / kAcross),
        across_(std::max(1, int(size.width / side_))),
        down_(std::max(1, int(size.height / side_))),
        size_(size) {}

  /// A point of its own in every square that has none. Those of the first picture do not all end at once.
  void fill(std::size_t& points) {
    std::vector<char> taken(squares(), 0);
    for (const Point& p : points_) taken[square_of(p.at)] = 1;
    const bool first = points == 0;
    for (std::size_t s = 0; s < taken.size(); ++s)
      if (!taken[s])
        points_.push_back({int(points++), first ? 1 + int(s % (kLongest / 2)) : 1, center_of(s)});
  }
  /// Goes on to the next picture.
  void follow(const Between& flow) {
    std::vector<char> taken(squares(), 0);
    std::vector<Point> kept;
    for (const Point& p : points_) {  // older ones first
      const auto next = p.pictures < kLongest ? next_place(flow, p.at) : std::nullopt;
      if (!next || taken[square_of(*next)]) continue;
      taken[square_of(*next)] = 1;
      kept.push_back({p.point, p.pictures + 1, *next});
    }
    points_ = std::move(kept);
  }
  /// @param size  of the picture
  std::vector<VisiblePoint> seen(const PictureSize& size) const {
    std::vector<VisiblePoint> out;
    for (const Point& p : points_)
      out.push_back(
          {p.point, float(p.at.u * size.width / size_.width), float(p.at.v * size.height / size_.height)});
    return out;
  }

 private:
  struct Point {
    int point, pictures;
    PixelPlace at;
  };
  std::size_t squares() const { return std::size_t(across_) * std::size_t(down_); }
  std::size_t square_of(PixelPlace at) const {
    const int x = std::min(int(at.u / size_.width * across_), across_ - 1),
              y = std::min(int(at.v / size_.height * down_), down_ - 1);
    return std::size_t(y) * std::size_t(across_) + std::size_t(x);
  }
  PixelPlace center_of(std::size_t square) const {
    return {(double(square % std::size_t(across_)) + 0.5) * size_.width / across_,
            (double(square / std::size_t(across_)) + 0.5) * size_.height / down_};
  }

  double side_;
  int across_, down_;
  PictureSize size_;
  std::vector<Point> points_;  ///< in the order of their numbers
};

}  // namespace

FollowedPoints follow_flow(const std::filesystem::path& folder, const std::string& where,
                           const std::vector<std::size_t>& counts, const PictureSize& size,
                           std::vector<std::string>& notes) {
  const FlowFiles files = find_flow(folder, where);
  const std::size_t pairs = files.forward.size();
  if (std::find(counts.begin(), counts.end(), pairs + 1) == counts.end()) {
    std::vector<std::size_t> wanted;
    for (const std::size_t n : counts) wanted.push_back(n - 1);
    fail({where, "the flow is of other pictures",
          fmt::format("{} files forward, one from each picture to the next in the order of time",
                      fmt::join(wanted, " or ")),
          fmt::format("{}", pairs), kWithoutTracks});
  }
  const auto read = [&](const std::string& name) {
    const std::string file = where + "/" + printable(name);
    FlowField flow = read_flow(folder / name, file);
    if (!same_shape(flow.size, size))
      fail({file, "the flow is of another shape than the pictures", size_text(size), size_text(flow.size),
            "make flow of whole pictures, upright; " + std::string(kWithoutTracks)});
    return flow;
  };
  if (files.backward.empty())
    notes.push_back(
        "flow leads forward alone, so points go on where something hides them; files with 'bwd' in their "
        "names, "
        "from each picture to the one before, would tell");
  FollowedPoints out{0, std::vector<std::vector<VisiblePoint>>(pairs + 1)};
  std::optional<PointsInPicture> points;
  PictureSize flow_size;
  std::vector<Between> flows(pairs);
  in_order(
      int(pairs), 2 * thread_count(),
      [&](int k) {
        Between& flow = flows[std::size_t(k)];
        flow.forward = read(files.forward[std::size_t(k)]);
        if (!files.backward.empty()) flow.backward = read(files.backward[std::size_t(k)]);
      },
      [&](int i) {
        const std::size_t k = std::size_t(i);
        Between& flow = flows[k];
        if (!points) points.emplace(flow_size = flow.forward.size);
        for (const FlowField* field : {&flow.forward, flow.backward ? &*flow.backward : &flow.forward})
          if (field->size != flow_size)
            fail({where, "flow is not all of one size", size_text(flow_size), size_text(field->size),
                  kWithoutTracks});
        points->fill(out.points);
        out.seen[k] = points->seen(size);
        points->follow(flow);
        flow = {};
        return true;
      });
  out.seen[pairs] = points->seen(size);
  return out;
}

}  // namespace splinevox::data
