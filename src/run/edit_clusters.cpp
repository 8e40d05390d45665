// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "run/edit_session.hpp"
#include "splinevox/field/edit.hpp"

namespace splinevox::run {
namespace {

constexpr int kMostClusters = 16;
constexpr double kMostDisturbed =
    0.02;  ///< share of other matter, or of the part, that an edit may do wrong before it is refused
constexpr double kMostShared =
    0.15;  ///< share of a part that may keep its old time, where it is joined to others

/// Colours of --paint, in the order of the clusters: the static one is grey.
constexpr Vec3 kPalette[] = {{0.6f, 0.6f, 0.6f},    {0.86f, 0.37f, 0.0f},  {0.0f, 0.45f, 0.70f},
                             {0.0f, 0.62f, 0.45f},  {0.94f, 0.89f, 0.26f}, {0.80f, 0.47f, 0.65f},
                             {0.34f, 0.71f, 0.91f}, {0.1f, 0.1f, 0.1f}};

}  // namespace

void paint_parts(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen) {
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    if (!chosen[c]) continue;
    ChosenClusters one(chosen.size(), false);
    one[c] = true;
    paint_clusters(model, clusters, one, kPalette[c % std::size(kPalette)]);
  }
}

VoxelModel painted(const VoxelModel& model, const MotionClusters& clusters) {
  VoxelModel out = model;
  paint_parts(out, clusters, ChosenClusters(clusters.clusters.size(), true));
  return out;
}

Vec3 part_colour(const VoxelModel& model, std::size_t cluster) {
  return paintable(model, kPalette[cluster % std::size(kPalette)]);
}

struct ClusterOperations {
  static const MotionClusters& known(EditSession& s, const char* name) {
    if (!s.clusters_)
      wrong_edit(name, "there are no clusters yet",
                 "--clusters before it, and again after an operation that moves matter", "none",
                 "--clusters auto");
    return *s.clusters_;
  }
  static const MotionClusters& chosen(EditSession& s, const char* name) {
    known(s, name);
    if (s.chosen_.empty())
      wrong_edit(name, "no cluster is chosen", "--cluster before it", "none", "--cluster moving");
    return *s.clusters_;
  }

  static Json clusters(EditSession& s, const std::string& v) {
    const int count = v == "auto" ? 0 : edit_whole("clusters", v, 2, kMostClusters);
    s.clusters_ = find_clusters(s.run_.model, count);
    s.chosen_.clear();
    Json table = Json::array();
    s.say_(fmt::format("{:<8} {:>9} {:>17}   {}", "cluster", "of matter", "moves by (voxels)", "around"));
    for (std::size_t c = 0; c < s.clusters_->clusters.size(); ++c) {
      const auto& k = s.clusters_->clusters[c];
      table.push_back({{"cluster", c},
                       {"share", k.share},
                       {"motion_voxels", k.motion},
                       {"center", {k.center.x, k.center.y, k.center.z}}});
      s.say_(fmt::format("{:<8} {:>8.1f}% {:>17.2f}   {:.3f},{:.3f},{:.3f}{}", c, 100 * k.share, k.motion,
                         k.center.x, k.center.y, k.center.z, c == 0 ? "   stands still" : ""));
    }
    return {{"clusters", table}, {"silhouette", s.clusters_->silhouette}};
  }

  static Json cluster(EditSession& s, const std::string& v) {
    const std::size_t count = known(s, "cluster").clusters.size();
    s.chosen_.assign(count, v == "moving");
    s.chosen_[0] = false;
    if (v == "moving") {
      if (count == 1)
        wrong_edit("cluster", "nothing moves in this run", "a cluster that moves", "one that stands still");
      return Json::object();
    }
    for (const std::string& part : split_list(v))
      s.chosen_[std::size_t(edit_whole("cluster", part, 0, int(count) - 1))] = true;
    if (std::find(s.chosen_.begin(), s.chosen_.end(), true) == s.chosen_.end())
      wrong_edit("cluster", "names no cluster", "numbers such as 1,2, or moving", v);
    return Json::object();
  }

  static Json hide(EditSession& s, const std::string&) {
    hide_clusters(s.run_.model, chosen(s, "hide"), s.chosen_);
    return Json::object();
  }
  static Json only(EditSession& s, const std::string&) {
    keep_clusters(s.run_.model, chosen(s, "only"), s.chosen_);
    return Json::object();
  }
  static Json paint(EditSession& s, const std::string&) {
    const ChosenClusters all(known(s, "paint").clusters.size(), true);
    paint_parts(s.run_.model, *s.clusters_, s.chosen_.empty() ? all : s.chosen_);
    return Json::object();
  }

  /// Figures of a part that was carried, or the reason why it was not.
  static Json carry(EditSession& s, const char* name, const RigidMotion& g) {
    const PartEdit e = carry_clusters(s.run_.model, *s.clusters_, s.chosen_, g, kMostDisturbed);
    const std::string most = fmt::format("at most {:.0f}%", 100 * kMostDisturbed);
    if (e.disturbed > kMostDisturbed)
      wrong_edit(name,
                 "other matter is shown, at some time, from the motion voxels that the part would come to, "
                 "and would move with it",
                 most + " of that matter", fmt::format("{:.1f}%", 100 * e.disturbed),
                 "another place, or --clusters with another number");
    if (e.ghosts > kMostDisturbed)
      wrong_edit(
          name,
          "pieces of the part would still be seen where it was, because other matter needs the motion there",
          most + " of the part", fmt::format("{:.1f}%", 100 * e.ghosts), "move it further");
    if (e.covered > kMostDisturbed)
      wrong_edit(name, "the canonical volume has other matter where the part would come to",
                 most + " of the part", fmt::format("{:.1f}%", 100 * e.covered), "move it further");
    s.clusters_.reset();  // they say where the matter was
    s.chosen_.clear();
    return {{"disturbed_share", e.disturbed},
            {"ghost_share", e.ghosts},
            {"error_max_voxels", e.error_max},
            {"error_rms_voxels", e.error_rms}};
  }

  static Json move(EditSession& s, const std::string& v) {
    chosen(s, "move");
    const std::vector<double> d = numbers(v, ',', "--move", "x,y,z in scene units");
    if (d.size() != 3) wrong_edit("move", "this is not an offset", "x,y,z in scene units", v);
    RigidMotion g;
    g.offset = {d[0], d[1], d[2]};
    return carry(s, "move", g);
  }

  static Json rotate(EditSession& s, const std::string& v) {
    const MotionClusters& c = chosen(s, "rotate");
    const char* expected =
        "AXIS,DEGREES or AXIS,DEGREES,X,Y,Z: the axis x, y or z, then the pivot (default: the part's middle)";
    const std::size_t comma = v.find(',');
    if (comma != 1 || v[0] < 'x' || v[0] > 'z')
      wrong_edit("rotate", "this is not a rotation", expected, v, "--rotate z,30");
    const std::vector<double> d = numbers(v.substr(2), ',', "--rotate", expected);
    if (d.size() != 1 && d.size() != 4)
      wrong_edit("rotate", "this is not a rotation", expected, v, "--rotate z,30");
    Vec3d pivot{}, axis{};
    axis[v[0] - 'x'] = 1;
    double share = 0;
    for (std::size_t k = 0; k < s.chosen_.size(); ++k)
      if (s.chosen_[k]) {
        pivot += c.clusters[k].share * cast<double>(c.clusters[k].center);
        share += c.clusters[k].share;
      }
    pivot = share > 0 ? pivot * (1 / share) : pivot;
    if (d.size() == 4) pivot = {d[1], d[2], d[3]};
    return carry(s, "rotate", rotation(axis, d[0], pivot));
  }

  static Json slow(EditSession& s, const std::string& v) {
    chosen(s, "slow");
    const double factor = edit_number("slow", v, 0.01, 100, "a factor from 0.01 to 100");
    const MotionField& m = s.run_.model.motion;
    if (!m.time_curve.identity())
      wrong_edit("slow", "the time of this model was changed already", "a run in its own time",
                 "a time curve", "slow the part first, then change the time of all");
    const PartEdit e = slow_clusters(s.run_.model, *s.clusters_, s.chosen_, factor, kMostShared);
    if (e.disturbed > kMostShared)
      wrong_edit("slow",
                 "the part shares motion voxels with other matter and cannot have a time of its own there",
                 fmt::format("at most {:.0f}% of the part", 100 * kMostShared),
                 fmt::format("{:.1f}%", 100 * e.disturbed), "--clusters with another number");
    return {{"kept_old_time_share", e.disturbed},
            {"error_max_voxels", e.error_max},
            {"error_rms_voxels", e.error_rms}};
  }
};

std::vector<EditOperation> cluster_operations() {
  using Do = ClusterOperations;
  return {
      {"clusters", "N|auto",
       "group matter by how it moves: 0 stands still, then the more it moves the later; prints a table",
       "Parts", Do::clusters},
      {"cluster", "I,...|moving", "which of them the following operations are about", "Parts", Do::cluster},
      {"hide", nullptr, "take the part away", "Parts", Do::hide},
      {"only", nullptr, "take everything else away, to export the part alone", "Parts", Do::only},
      {"paint", nullptr, "give every cluster (or the chosen ones) a colour, to see which is which", "Parts",
       Do::paint},
      {"move", "X,Y,Z",
       "move the part, its motion with it; refused where other matter shares the motion voxels", "Parts",
       Do::move},
      {"rotate", "AXIS,DEG[,X,Y,Z]", "turn the part about an axis (x, y, z) through a pivot, as move",
       "Parts", Do::rotate},
      {"slow", "F", "the part at F times the speed; refused where it shares motion voxels with other matter",
       "Parts", Do::slow},
  };
}

}  // namespace splinevox::run
