// SPDX-License-Identifier: Apache-2.0
#include "data/tracks/follow_flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/in_order.hpp"
#include "core/parallel.hpp"
#include "data/message_text.hpp"
#include "data/pictures/pictures.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

constexpr int kAcross = 48;                             ///< squares of the grid along the longer side
constexpr int kCrowded = 4;                             ///< times as many, each with at most one point
constexpr int kLongest = 32;                            ///< pictures of one point
constexpr double kShareBack = 0.01, kPixelsBack = 0.5;  ///< eq. 5, of squared pixels of the flow

/// Flow from a picture to the next, and back if there is any.
struct Between {
  FlowField forward;
  std::optional<FlowField> backward;
};

bool inside(PixelPlace at, const PictureSize& size) {
  return at.u >= 0 && at.v >= 0 && at.u < size.width && at.v < size.height;
}

/// Where flow leads a point; none: it is lost.
std::optional<PixelPlace> next_place(const Between& flow, PixelPlace at) {
  const auto way = flow.forward.at(at);
  if (!way) return {};
  const PixelPlace next{at.u + way->u, at.v + way->v};
  if (!inside(next, flow.forward.size)) return {};
  if (!flow.backward) return next;
  const auto back = flow.backward->at(next);
  if (!back) return {};
  const auto squared = [](double u, double v) { return u * u + v * v; };
  const double off = squared(way->u + back->u, way->v + back->v);
  const double ways = squared(way->u, way->v) + squared(back->u, back->v);
  if (off > kShareBack * ways + kPixelsBack) return {};
  return next;
}

/// Squares of a picture, and which have a point.
class Squares {
 public:
  /// @param across  along the longer side
  Squares(const PictureSize& size, int across)
      : size_(size),
        side_(double(std::max(size.width, size.height)) / across),
        across_(int(std::ceil(size.width / side_))),
        down_(int(std::ceil(size.height / side_))),
        taken_(std::size_t(across_) * std::size_t(down_), 0) {}

  /// Whether the square of a place in the picture was free until now.
  bool take(PixelPlace at) {
    const int x = std::min(int(at.u / side_), across_ - 1), y = std::min(int(at.v / side_), down_ - 1);
    return !std::exchange(taken_[std::size_t(y) * std::size_t(across_) + std::size_t(x)], 1);
  }
  /// Centres of squares that are free, inside the picture.
  std::vector<PixelPlace> free() const {
    std::vector<PixelPlace> out;
    for (int y = 0; y < down_; ++y)
      for (int x = 0; x < across_; ++x) {
        const PixelPlace center{(x + 0.5) * side_, (y + 0.5) * side_};
        if (!taken_[std::size_t(y) * std::size_t(across_) + std::size_t(x)] && inside(center, size_))
          out.push_back(center);
      }
    return out;
  }

 private:
  PictureSize size_;
  double side_;
  int across_, down_;
  std::vector<char> taken_;
};

struct Followed {
  int point, pictures;  ///< in which it was seen
  PixelPlace at;
};

/// A point of its own in every square that has none. Those of the first picture do not all end at once.
void fill(std::vector<Followed>& points, const PictureSize& size, std::size_t& count) {
  Squares squares(size, kAcross);
  for (const Followed& p : points) squares.take(p.at);
  const bool first = count == 0;
  for (const PixelPlace& at : squares.free()) {
    points.push_back({int(count), first ? 1 + int(count % (kLongest / 2)) : 1, at});
    ++count;
  }
}

/// Those that are in the next picture, the older ones first.
std::vector<Followed> follow(const std::vector<Followed>& points, const Between& flow) {
  Squares squares(flow.forward.size, kCrowded * kAcross);
  std::vector<Followed> out;
  for (const Followed& p : points)
    if (const auto next = p.pictures < kLongest ? next_place(flow, p.at) : std::nullopt)
      if (squares.take(*next)) out.push_back({p.point, p.pictures + 1, *next});
  return out;
}

}  // namespace

FollowedPoints follow_flow(const std::filesystem::path& folder, const FlowFiles& files,
                           const std::string& where, const std::vector<std::size_t>& counts,
                           const PictureSize& size, std::vector<std::string>& notes) {
  const std::size_t pairs = files.forward.size();
  if (std::find(counts.begin(), counts.end(), pairs + 1) == counts.end()) {
    std::vector<std::size_t> wanted;
    for (const std::size_t n : counts) wanted.push_back(n - 1);
    fail({where, "the flow is of other pictures",
          fmt::format("{} files forward, one from each picture to the next in the order of time",
                      fmt::join(wanted, " or ")),
          fmt::format("{}", pairs), kWithoutTracks});
  }
  const auto read = [&](const std::string& name, FlowWay way) {
    const std::string file = where + "/" + printable(name);
    FlowField flow = read_flow(folder / name, file, way);
    if (!same_shape(flow.size, size))
      fail({file, "the flow is of another shape than the pictures", size_text(size), size_text(flow.size),
            "make flow of whole pictures, upright; " + std::string(kWithoutTracks)});
    return flow;
  };
  if (files.backward.empty())
    notes.push_back(
        "flow leads forward alone, so points go on where something hides them; files with 'bwd' in their "
        "names, from each picture to the one before, would tell");
  FollowedPoints out{0, std::vector<std::vector<VisiblePoint>>(pairs + 1)};
  std::vector<Followed> points;
  PictureSize flow_size;
  const auto check_size = [&](const FlowField& field) {
    if (field.size != flow_size)
      fail({where, "flow is not all of one size", size_text(flow_size), size_text(field.size),
            kWithoutTracks});
  };
  const auto seen = [&] {
    std::vector<VisiblePoint> places;
    for (const auto& [point, pictures, at] : points)
      places.push_back(
          {point, float(at.u * size.width / flow_size.width), float(at.v * size.height / flow_size.height)});
    return places;
  };
  std::vector<Between> flows(pairs);
  in_order(
      int(pairs), 2 * thread_count(),
      [&](int k) {
        Between& flow = flows[std::size_t(k)];
        flow.forward = read(files.forward[std::size_t(k)], FlowWay::forward);
        if (!files.backward.empty()) flow.backward = read(files.backward[std::size_t(k)], FlowWay::backward);
      },
      [&](int k) {
        Between& flow = flows[std::size_t(k)];
        if (k == 0) flow_size = flow.forward.size;
        check_size(flow.forward);
        if (flow.backward) check_size(*flow.backward);
        fill(points, flow_size, out.points);
        out.seen[std::size_t(k)] = seen();
        points = follow(points, flow);
        flow = {};
        return true;
      });
  out.seen[pairs] = seen();
  return out;
}

}  // namespace splinevox::data
