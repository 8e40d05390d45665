// SPDX-License-Identifier: Apache-2.0
#include "cli/eval_pictures.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "cli/scores_print.hpp"
#include "core/atomic_file.hpp"
#include "run/memory_needs.hpp"
#include "run/outer_metric.hpp"
#include "run/scores_json.hpp"
#include "run/train_options.hpp"
#include "splinevox/core/error.hpp"

namespace fs = std::filesystem;

namespace splinevox::cli {
namespace {

using namespace run;

/// What pictures are compared with.
struct Truth {
  Dataset data;
  Vec3 background;
  std::string of_run;    ///< empty: of no run
  std::string transfer;  ///< DatasetRules::transfer of the run
};

Truth truth_of(const EvalOptions& o) {
  if (!o.run.empty()) {
    Otherwise otherwise = o.otherwise;
    if (!o.masks.empty()) otherwise.masks = o.masks;
    const Run run = open_run(o.run, otherwise);
    return {open_split(run, o.data, o.split, o.room), run.background(), run.path, run.record.rules.transfer};
  }
  const std::vector<float> c = parse_background(o.otherwise.background.value_or("white"));
  LoadOptions load;
  load.downscale = o.otherwise.downscale.value_or(1);
  load.splits = {o.split};
  load.rules.masks = o.masks;
  load.inside = true;
  load.cache = o.room.cache;
  load.room = [bound = memory_bound(o.room.memory)](const Dataset&) { return bound; };
  return {load_dataset(o.data, load), {c[0], c[1], c[2]}, "", ""};
}

/// The order of a split's frames, as far as it takes to tell whether a program's pictures have the same.
std::string order_of(const Split& split) {
  constexpr std::size_t kNamed = 4;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(kNamed, split.frames.size()); ++i)
    names.push_back(split.frames[i].name);
  const bool more = split.frames.size() > kNamed;
  return fmt::format("the first pictures are taken for frames {}{}", fmt::join(names, ", "),
                     more ? ", ..." : "");
}

}  // namespace

bool are_figures(std::string_view start) {
  return start.starts_with("{") && start.find("\"psnr\"") != start.npos;
}

int eval_pictures(const EvalOptions& o) {
  if (o.run.empty() && o.data.empty())
    fail({"eval", "there is nothing to compare the pictures with", "a RUN, or --data DATASET", "", ""});
  OuterMetrics metrics(o.metrics);
  const Truth truth = truth_of(o);
  const Split& split = *truth.data.find(o.split);
  const OtherPictures pictures(o.pictures, split, o.match == "order" ? MatchBy::order : MatchBy::name,
                               truth.transfer);
  std::vector<std::string> notes = truth.data.notes;
  if (o.match == "order") notes.push_back(order_of(split));
  if (!o.json) print_scores_head(o.split, notes);
  std::size_t next = 0;
  const Scores scores = evaluate(
      split,
      [&](const Frame& frame) {
        return compare(pictures.read(next++, truth.background), frame, truth.background);
      },
      [&](const Frame& frame, const View& v) {
        frame.image.give_back();
        if (!o.json) print_view(frame, v);
        metrics.take(frame, v);
      });
  const auto whole = [](const std::string& path) { return whole_path(path).string(); };
  Json result = scores_json(scores);
  metrics.finish(result);
  for (std::size_t i = 0; i < split.frames.size(); ++i) result["frames"][i]["picture"] = pictures.name(i);
  result["pictures"] = whole(o.pictures);
  result["match"] = o.match;
  result["eval_data"] = whole(truth.data.path);
  if (!truth.of_run.empty()) result["truth_of_run"] = whole(truth.of_run);
  result["downscale"] = truth.data.downscale;
  result["background"] = triple(truth.background);
  if (o.json)
    tell_scores(result, notes);
  else
    print_means(scores, result);
  if (!o.out.empty()) write_file(o.out, {json_text(result, 2) + "\n"}, Named::by_user);
  return 0;
}

}  // namespace splinevox::cli
