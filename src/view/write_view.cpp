// SPDX-License-Identifier: Apache-2.0
#include "view/write_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "core/atomic_file.hpp"
#include "run/html.hpp"
#include "run/own_json.hpp"
#include "run/training_cameras.hpp"
#include "run/true_shots.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/run/cameras.hpp"
#include "splinevox/run/evaluate.hpp"
#include "splinevox/run/run.hpp"
#include "view/page.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {
namespace {

std::string about(const Run& run) {
  std::string text = folder_name(run.record.dataset) + ", preset " + run.config.preset;
  const std::string file = run.path + "/metrics.json";
  const Json metrics = read_metrics_if_there(file);
  if (metrics.contains("psnr") && metrics["psnr"].is_number() && metrics.contains("split"))
    text += fmt::format(", {:.1f} dB on the {} split", metrics["psnr"].get<double>(),
                        metrics["split"].get<std::string>());
  return text;
}

std::string described(const ViewQuality& q, const VoxelModel& model) {
  std::string text = fmt::format("density in {} bits, colour in {}", q.density_bits, q.colour_bits);
  if (model.radiance.sh_order >= 0)
    text += q.sh_bits ? fmt::format(", view dependence in {}", q.sh_bits) : ", no view dependence";
  if (!model.motion.levels.empty()) text += fmt::format(", motion in {}", q.motion_bits);
  if (q.halvings) text += fmt::format("; voxels {} times as large", 1 << q.halvings);
  return text;
}

}  // namespace

WrittenView write_view(const ViewRequest& o) {
  const auto check = [](const char* name, double value, double least, double most) {
    if (!(value >= least && value <= most))
      fail({name, "out of range", fmt::format("{:g} to {:g}", least, most), fmt::format("{:g}", value), ""});
  };
  check("views", o.views, 0, kMostTrueViews);
  check("view_size", o.view_size, kLeastViewSize, kMostViewSize);
  check("max_mb", o.max_mb, 0, kMostMb);  // what is too little for the model says so itself
  WrittenView out;
  probe_output_file(o.out, is_view);
  Run run = open_run(o.run);
  ViewPage page;
  page.model = model_mark(run.path);
  page.name = fs::weakly_canonical(run.path).filename().string();
  page.about = about(run);
  page.split = o.split;
  page.full_flow = kFullFlow * run.model.box.longest_edge();
  if (o.views > 0) try {
      page.shots =
          page_shots(*open_split(run, o.data, o.split).find(o.split), run.model, o.views, o.view_size);
    } catch (const Error& e) {
      out.lacks.push_back(fmt::format("the page is without true pictures: {}", e.what()));
    }
  const std::string outside = run.model.surroundings.any() ? "; without the surroundings" : "";
  if (!outside.empty()) {
    out.lacks.push_back("the page is without the surroundings: it shows the box, and one colour behind it");
    run.model.surroundings = {};
  }
  std::optional<TrainingCameras> train;
  try {
    train = training_cameras(run, o.data, CameraRequest().elevation);
    page.taken = taken_from(*train);
  } catch (const Error& e) {
    out.lacks.push_back(fmt::format("the page does not know where pictures were taken: {}", e.what()));
  }
  page.start = first_sight(run.model, page.shots, train ? &*train : nullptr, o.view_size);
  const std::optional<MotionClusters> clusters =
      run.model.motion.moves() ? std::optional(find_clusters(run.model, 0)) : std::nullopt;
  std::size_t smallest = 0;
  for (const ViewQuality& quality : view_qualities()) {
    page.note = described(quality, run.model) + outside;
    const std::string html = view_page(page, pack_scene(run.model, quality, clusters ? &*clusters : nullptr));
    smallest = html.size();
    if (double(smallest) > o.max_mb * 1e6) continue;
    write_file(o.out, {html}, Named::by_user);
    out.bytes = smallest;
    out.note = page.note;
    out.true_pictures = page.shots.size();
    return out;
  }
  fail({"--max-mb", "the page does not fit even with coarse voxels",
        fmt::format("at least {:.2f} MB for this run with {} true pictures", double(smallest) * 1e-6,
                    page.shots.size()),
        fmt::format("{:g}", o.max_mb), page.shots.empty() ? "" : "--views 0, or --view-size 200"});
}

}  // namespace splinevox::run
