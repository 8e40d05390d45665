// SPDX-License-Identifier: Apache-2.0
#include "run/edit_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/nearest.hpp"
#include "io/export/what_changes.hpp"
#include "math/time_curve.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {

void wrong_edit(const char* operation, const std::string& what, const std::string& expected,
                const std::string& got, const std::string& hint) {
  fail({std::string("--") + operation, what, expected, got, hint});
}

double edit_number(const char* operation, const std::string& text, double lo, double hi,
                   const std::string& expected) {
  const std::vector<double> v = numbers(text, ',', std::string("--") + operation, expected);
  if (v.size() != 1 || !(v[0] >= lo && v[0] <= hi)) wrong_edit(operation, "is out of range", expected, text);
  return v[0];
}

int edit_whole(const char* operation, const std::string& text, int lo, int hi) {
  const std::string expected = fmt::format("a whole number from {} to {}", lo, hi);
  const double v = edit_number(operation, text, lo, hi, expected);
  if (v != std::floor(v)) wrong_edit(operation, "is not a whole number", expected, text);
  return int(v);
}

namespace {

constexpr int kMaxLoops = 1000;
constexpr double kMostAnchorError = 1;  ///< voxels in the mean square beyond which --anchor-first is refused

/// The motion field of a model in which something changes over time.
MotionField& changing(VoxelModel& model, const char* name) {
  if (model.motion.levels.empty())
    wrong_edit(name, "nothing changes over time in this run", "a run with motion, light or presence",
               "a static model", "splinevox info RUN shows what a model has");
  return model.motion;
}

/// That of a model in which matter moves.
MotionField& moving(VoxelModel& model, const char* name) {
  MotionField& motion = changing(model, name);
  if (!motion.displaces)
    wrong_edit(name, "nothing moves in this run, " + what_changes(motion), "a run with motion", "");
  return motion;
}

TimeCurve curve_of(const std::string& text) {
  const char* expected =
      "TIME:SHOWN pairs separated by commas, times from 0 to 1 in order, shown times in [0, 1]";
  std::vector<TimeCurve::Knot> knots;
  for (const std::string& pair : split_list(text)) {
    const std::vector<double> v = numbers(pair, ':', "--time-curve", expected);
    if (v.size() != 2)
      wrong_edit("time-curve", fmt::format("'{}' is not a pair", pair), expected, text,
                 "--time-curve 0:0,0.5:0.2,1:1");
    if (!(v[1] >= 0 && v[1] <= 1))
      wrong_edit("time-curve", "there is no such time in the model", expected, pair);
    if (!knots.empty() && !(v[0] >= knots.back().time))
      wrong_edit("time-curve", "times must not go back (the times they show may)", expected, pair);
    knots.push_back({v[0], v[1]});
  }
  if (knots.size() < 2 || knots.front().time != 0 || knots.back().time != 1)
    wrong_edit("time-curve", "a curve begins at time 0 and ends at time 1", expected, text,
               "--time-curve 0:0,0.5:0.2,1:1");
  return simplified(std::move(knots));
}

Json difference_json(const MotionDifference& d) {
  return {{"error_max_voxels", d.max}, {"error_rms_voxels", d.rms}};
}

}  // namespace

struct EditOperations {
  static VoxelModel& model(EditSession& s) { return s.run_.model; }
  static void forget_parts(EditSession& s) {
    s.clusters_.reset();
    s.chosen_.clear();
  }

  static Json floaters(EditSession& s, const std::string& v) {
    const double least = edit_number("remove-floaters", v, 0, 0.5, "a share from 0 to 0.5");
    forget_parts(s);  // of matter that is no longer there
    const RemovedFloaters removed = remove_floaters(model(s), least);
    return {{"pieces", removed.count}, {"share", removed.share}, {"left", removed.left}};
  }

  static Json retimed(EditSession& s, const char* name, const TimeCurve& change) {
    MotionField& motion = changing(model(s), name);
    retime(motion, change);
    if (const std::size_t knots = motion.time_curve.knots.size(); knots > TimeCurve::kMost)
      wrong_edit(name, "the time would have too many pieces",
                 std::to_string(TimeCurve::kMost) + " knots at most", std::to_string(knots), "fewer loops");
    return Json::object();
  }
  static Json reverse(EditSession& s, const std::string&) { return retimed(s, "reverse", reversed_time()); }
  static Json speed(EditSession& s, const std::string& v) {
    return retimed(s, "speed", speed_time(edit_number("speed", v, 1e-3, 1e3, "a factor from 0.001 to 1000")));
  }
  static Json time_curve(EditSession& s, const std::string& v) {
    return retimed(s, "time-curve", curve_of(v));
  }
  static Json loop(EditSession& s, const std::string& v) {
    return retimed(s, "loop", loop_time(edit_whole("loop", v, 1, kMaxLoops), false));
  }
  static Json ping_pong(EditSession& s, const std::string& v) {
    return retimed(s, "ping-pong", loop_time(edit_whole("ping-pong", v, 1, kMaxLoops), true));
  }
  static Json freeze(EditSession& s, const std::string& v) {
    return retimed(s, "freeze", frozen_time(edit_number("freeze", v, 0, 1, "a time in [0, 1]")));
  }

  static Json scale(EditSession& s, const std::string& v) {
    const double factor = edit_number("scale-motion", v, -100, 100, "a factor from -100 to 100");
    moving(model(s), "scale-motion");
    keep_emptied(model(s), [&](MotionField& m) { scale_motion(m, float(factor)); });
    return Json::object();
  }

  static void with_presence(EditSession& s, const char* name) {
    if (!changing(model(s), name).presence)
      wrong_edit(name, "no matter comes or goes in this run", "a run with presence", "",
                 "splinevox info RUN shows what a model has");
  }
  static Json scale_presence(EditSession& s, const std::string& v) {
    const double factor = edit_number("scale-presence", v, -100, 100, "a factor from -100 to 100");
    with_presence(s, "scale-presence");
    if (factor != 1)
      keep_emptied(model(s), [&](MotionField& m) { splinevox::scale_presence(m, float(factor)); });
    return Json::object();
  }
  static Json freeze_presence(EditSession& s, const std::string& v) {
    const double time = edit_number("freeze-presence", v, 0, 1, "a time in [0, 1]");
    with_presence(s, "freeze-presence");
    splinevox::freeze_presence(model(s), time);
    return Json::object();
  }

  static Json anchor(EditSession& s, const std::string&) {
    moving(model(s), "anchor-first");
    forget_parts(s);  // they lie in the canonical volume, which becomes another one
    VoxelModel next = model(s);
    const MotionDifference d = anchor_first(next);
    if (d.rms > kMostAnchorError)
      wrong_edit("anchor-first",
                 "the motion voxels are too coarse for the way back from the first moment: the scene would "
                 "not look as before",
                 fmt::format("an error of at most {:g} voxels in the mean square", kMostAnchorError),
                 fmt::format("{:.3g} voxels, {:.3g} at worst", d.rms, d.max));
    model(s) = std::move(next);
    return difference_json(d);
  }

  static Json elevate(EditSession& s, const std::string& v) {
    MotionField& m = changing(model(s), "elevate");
    const Basis& basis = basis_of(m.basis);
    if (!basis.elevates()) {
      const std::vector<std::string> names = basis_names([](const Basis& b) { return b.elevates(); });
      wrong_edit("elevate", "these curves have no degree to elevate",
                 fmt::format("a run of basis {}", fmt::join(names, " or ")), basis.name,
                 "--basis " + names[0] + " first");
    }
    const int room = basis.points.most - m.points;
    if (room < 1)
      wrong_edit("elevate", "the curves have the most points already",
                 fmt::format("fewer than {}", basis.points.most), std::to_string(m.points));
    m = elevated(m, edit_whole("elevate", v, 1, room));
    return {{"points", m.points}};
  }

  static Json basis(EditSession& s, const std::string& v) {
    const MotionField& m = changing(model(s), "basis");
    const std::vector<std::string> parts = split_list(v, ':');
    const std::vector<std::string> names = basis_names();
    const Basis* const to = parts.empty() ? nullptr : find_basis(parts[0]);
    if (!to || parts.size() > 2)
      wrong_edit("basis", "there is no such basis",
                 fmt::format("NAME or NAME:POINTS, NAME one of {}", fmt::join(names, ", ")), v,
                 parts.empty() ? "" : "--basis " + nearest(parts[0], names));
    const int points = parts.size() > 1 ? edit_whole("basis", parts[1], kMinPoints, kMaxPoints)
                                        : points_to_hold(basis_of(m.basis), m.points, *to);
    if (!to->points.allows(points))
      wrong_edit("basis", fmt::format("{} points do not suit {}", points, to->name), to->points.text(),
                 std::to_string(points));
    VoxelModel next = model(s);
    keep_emptied(next, [&](MotionField& motion) { motion = converted(m, to->kind, points); });
    const MotionDifference d = motion_difference(model(s), next);
    Json result{{"points", points}};
    result.update(difference_json(d));
    if (m.light) result["error_light"] = d.light;
    if (m.presence) result["error_opacity"] = d.opacity;
    model(s) = std::move(next);
    return result;
  }
};

void EditSession::apply(const std::string& operation, const std::string& value) {
  const auto& all = edit_operations();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const EditOperation& o) { return operation == o.name; });
  if (found == all.end()) {
    std::vector<std::string> known;
    for (const EditOperation& o : all) known.push_back(o.name);
    fail({"edit", "there is no such operation", fmt::format("{}", fmt::join(known, ", ")), operation,
          nearest(operation, known)});
  }
  if (!found->value && !value.empty())
    fail({"edit, " + operation, "this operation has no value", "its name alone", value, ""});
  const Json result = found->apply(*this, value);
  Json entry{{"operation", operation}};
  if (found->value) entry["value"] = value;
  entry.update(result);
  done_.push_back(entry);
  std::string line = fmt::format("{}{}{}", operation, value.empty() ? "" : " ", value);
  for (const auto& [key, figure] : result.items())
    if (figure.is_number_float())
      line += fmt::format(", {} {:.3g}", key, figure.get<double>());
    else if (figure.is_primitive())
      line += fmt::format(", {} {}", key, figure.is_string() ? figure.get<std::string>() : json_text(figure));
  say_(line);
}

const std::vector<EditOperation>& edit_operations() {
  using Do = EditOperations;
  static const std::string bases =
      fmt::format("curves of another kind with K points: {}; says the error", fmt::join(basis_names(), ", "));
  static const std::vector<EditOperation> all = [] {
    std::vector<EditOperation> list = {
        {"reverse", nullptr, "backwards; twice is the original, bit for bit", "Time", Do::reverse},
        {"speed", "F", "F times as fast: 0.5 shows the first half only, 2 holds the end from the middle on",
         "Time", Do::speed},
        {"time-curve", "T:S,...", "at time T show time S, straight in between; equal times T are a jump",
         "Time", Do::time_curve},
        {"loop", "N", "all of it N times", "Time", Do::loop},
        {"ping-pong", "N", "there and back N times", "Time", Do::ping_pong},
        {"freeze", "T", "the moment T for ever", "Time", Do::freeze},
        {"scale-motion", "F", "every displacement from the canonical place times F; light stays", "Motion",
         Do::scale},
        {"scale-presence", "F", "what comes and goes does so F times as much: 0 shows its mean over time",
         "Motion", Do::scale_presence},
        {"freeze-presence", "T",
         "what is there at the moment T stays, moves and is lit; nothing comes or goes", "Motion",
         Do::freeze_presence},
        {"anchor-first", nullptr,
         "make the moment at time 0 the canonical one: no displacement there; says the error", "Motion",
         Do::anchor},
        {"elevate", "N", "N more control points on Bezier curves that stay the same", "Motion", Do::elevate},
        {"basis", "NAME[:K]", bases.c_str(), "Motion", Do::basis},
        {"remove-floaters", "SHARE",
         "take away pieces that hang in the air and have less than this share of all matter, such as 0.001",
         "Parts", Do::floaters},
    };
    for (const EditOperation& o : cluster_operations()) list.push_back(o);
    return list;
  }();
  return all;
}

}  // namespace splinevox::run
