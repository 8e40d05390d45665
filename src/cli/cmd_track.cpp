// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "core/atomic_file.hpp"
#include "core/stopwatch.hpp"
#include "math/activation.hpp"
#include "run/points_csv.hpp"
#include "run/teller.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/run/run.hpp"

namespace splinevox::cli {
namespace {

struct TrackVerb {
  std::string run, points, to, out;
  double from = 0;
  int threads = 0;
  TalkWords talk;
};

std::string csv(const PointTable& table, const std::vector<std::string>& targets,
                const std::vector<std::vector<TrackedPoint>>& found, bool canonical) {
  std::string text = fmt::format("{}x,y,z,time,to_time,to_x,to_y,to_z,folded{}\n",
                                 table.id.empty() ? "" : "id,", canonical ? "" : ",density");
  for (std::size_t i = 0; i < table.position.size(); ++i)
    for (std::size_t k = 0; k < targets.size(); ++k) {
      const Vec3 &p = table.position[i], &q = found[k][i].position;
      if (!table.id.empty()) text += table.id[i] + ",";
      fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{},{}", p.x, p.y, p.z, table.time[i],
                     targets[k], q.x, q.y, q.z, int(found[k][i].folded));
      text += canonical ? "\n" : fmt::format(",{:.6g}\n", found[k][i].density);
    }
  return text;
}

/// @param times  to which; empty: to the canonical volume
std::string json(const PointTable& table, const std::vector<double>& times,
                 const std::vector<std::vector<TrackedPoint>>& found) {
  const bool canonical = times.empty();
  Json points = Json::array();
  for (std::size_t i = 0; i < table.position.size(); ++i) {
    const Vec3& p = table.position[i];
    Json point{{"from", {p.x, p.y, p.z}}, {"time", table.time[i]}, {"to", Json::array()}};
    if (!table.id.empty()) point["id"] = table.id[i];
    for (std::size_t k = 0; k < found.size(); ++k) {
      const Vec3& q = found[k][i].position;
      Json to{{"time", canonical ? Json("canonical") : Json(times[k])},
              {"position", {q.x, q.y, q.z}},
              {"folded", found[k][i].folded}};
      if (!canonical) to["density"] = found[k][i].density;
      point["to"].push_back(std::move(to));
    }
    points.push_back(std::move(point));
  }
  return json_text({{"points", points}}, 1) + "\n";
}

/// Whether a file begins as those that `track` writes.
bool is_tracks(std::string_view start) {
  constexpr std::string_view kColumns = "x,y,z,time,to_time,";
  return start.starts_with(kColumns) || start.starts_with("id," + std::string(kColumns)) ||
         start.starts_with("{\n \"points\": [");
}

int run_track(const TrackVerb& o) {
  const bool as_json = o.out.size() > 5 && o.out.substr(o.out.size() - 5) == ".json";
  probe_output_file(o.out, is_tracks);
  const bool canonical = o.to == "canonical";
  std::vector<double> times;
  if (!canonical) times = numbers(o.to, ',', "--to", "times in [0, 1] separated by commas, or canonical");
  for (const double t : times)
    if (!(t >= 0 && t <= 1))
      fail({"--to", "there is no such time in the model", "times in [0, 1], or canonical",
            fmt::format("{}", t), ""});
  PointTable table = read_points(o.points);
  if (table.time.empty()) table.time.assign(table.position.size(), o.from);
  const Run run = open_run(o.run);
  const Timer timer;
  const auto found =
      canonical ? std::vector<std::vector<TrackedPoint>>{to_canonical(run.model, table.position, table.time)}
                : track(run.model, table.position, table.time, times);
  const double seconds = timer.seconds();
  std::vector<std::string> targets = split_list(o.to);
  write_file(o.out, {as_json ? json(table, times, found) : csv(table, targets, found, canonical)},
             Named::by_user);
  constexpr float kFaint = 1e-2f;  // opacity over a voxel below which there is no matter
  const float voxel = run.model.radiance.raw.topology->lattice.spacing;
  std::size_t folded = 0, gone = 0;
  for (const auto& target : found)
    for (const TrackedPoint& p : target) {
      folded += p.folded;
      gone += one_minus_exp_neg(p.density * voxel) < kFaint;
    }
  const std::size_t points = table.position.size();
  Json figures{{"out", o.out},
               {"points", points},
               {"to", targets},
               {"seconds", seconds},
               {"tracks", points * targets.size()},
               {"folded", folded}};
  if (!canonical) figures["without_matter"] = gone;
  Teller(choose_talk(o.talk.quiet, o.talk.json))
      .result(figures,
              fmt::format("{} points to {} {}: {:.2f} s; {} of {} flagged as folded{}\n{}", points,
                          targets.size(), targets.size() == 1 ? "time" : "times", seconds, folded,
                          points * targets.size(),
                          canonical ? "" : fmt::format(", {} where there is no matter", gone), o.out));
  return 0;
}

}  // namespace

Action track_command(CLI::App& verb) {
  auto o = std::make_shared<TrackVerb>();
  verb.add_option("RUN", o->run, "the run whose motion is followed")->required();
  heading(verb, "Points");
  verb.add_option("--points", o->points,
                  "table of points: x,y,z and if wanted time,id (comma-separated, names in the first line)")
      ->required();
  verb.add_option("--from", o->from, "time of points without a column of times, in [0, 1]")
      ->check(decimals_in(0.0, 1.0))
      ->capture_default_str();
  verb.add_option("--to", o->to, "times in [0, 1] separated by commas, or canonical")->required();
  verb.add_option("--out", o->out, "the table to write; .json writes JSON")->required();
  add_talk(verb, o->talk);
  add_threads(verb, o->threads);
  return [o] { return with_threads(o->threads, [&] { return run_track(*o); }); };
}

}  // namespace splinevox::cli
