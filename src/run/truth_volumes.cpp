// SPDX-License-Identifier: Apache-2.0
#include "run/truth_volumes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/parallel.hpp"
#include "core/printable.hpp"
#include "data/json_file.hpp"
#include "data/npz_file.hpp"
#include "data/times/names.hpp"
#include "io/vdb/vdb_file.hpp"
#include "math/trilinear.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox::run {
namespace {

namespace fs = std::filesystem;

constexpr double kMostVoxels = double(1 << 28);  ///< of a volume
constexpr double kTimeSlack = 1e-6;              ///< by which a time may lie outside [0, 1]: rounding of text

/// Densities of one file, on the file's own lattice.
struct Stored {
  Vec3d origin{};
  double spacing = 1;
  Int3 size{};
  std::vector<float> values;

  float value(int x, int y, int z) const {
    if (x < 0 || y < 0 || z < 0 || x >= size.x || y >= size.y || z >= size.z) return 0;
    return values[(std::size_t(x) * size.y + y) * size.z + z];
  }
  /// Trilinear, towards 0 outside.
  float at(const Vec3d& place) const {
    int base[3];
    Vec3d share;
    for (int a = 0; a < 3; ++a) {
      const double at = std::clamp((place[a] - origin[a]) / spacing, -2.0, size[a] + 1.0);
      // On a voxel to rounding: that voxel's own number.
      const double near = std::round(at), place_of = std::abs(at - near) < 1e-6 ? near : at;
      base[a] = int(std::floor(place_of));
      share[a] = place_of - base[a];
    }
    double sum = 0, weights[kCorners];
    trilinear_weights(share, weights);
    for (int c = 0; c < kCorners; ++c)
      if (weights[c] > 0)
        sum += weights[c] * double(value(base[0] + (c >> 2), base[1] + (c >> 1 & 1), base[2] + (c & 1)));
    return float(sum);
  }
};

void check_count(const std::string& where, const Vec3d& size) {
  if (!(size.x >= 1 && size.y >= 1 && size.z >= 1 && size.x * size.y * size.z <= kMostVoxels))
    fail({where, "the volume has no usable size", fmt::format("1 to {:.0f} voxels", kMostVoxels),
          fmt::format("{:g} x {:g} x {:g}", size.x, size.y, size.z), ""});
}

Stored read_npz_volume(const std::string& path) {
  auto arrays = data::read_npz(path, path, {"density", "voxel", "origin"});
  const data::NpyArray &density = arrays["density"], &voxel = arrays["voxel"], &origin = arrays["origin"];
  if (density.shape.size() != 3 || voxel.values.size() != 1 || origin.values.size() != 3 ||
      !(voxel.values[0] > 0))
    fail({path, "its arrays have not the shapes of a volume",
          "density [x, y, z], voxel: one number above 0, origin: three",
          fmt::format("{} axes, {} and {} numbers", density.shape.size(), voxel.values.size(),
                      origin.values.size()),
          ""});
  const auto& n = density.shape;
  check_count(path, {double(n[0]), double(n[1]), double(n[2])});
  Stored out{{origin.values[0], origin.values[1], origin.values[2]},
             voxel.values[0],
             {int(n[0]), int(n[1]), int(n[2])},
             std::vector<float>(density.values.begin(), density.values.end())};
  return out;
}

[[noreturn]] void fail_no_grid(const std::string& path, const std::string& wanted,
                               const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + printable(name);
  fail({path, "there is no grid '" + printable(wanted) + "' in it", "a float grid of that name",
        all.empty() ? "no grid" : all, "the name of the grid as 'grid' in truth.json"});
}

/// Those voxels of a .vdb that lie in a box, and one around them.
Stored read_vdb_volume(const std::string& path, const std::string& name, const Vec3d& lo, const Vec3d& hi) {
  const VdbFile file = read_vdb(path);
  std::vector<std::string> names;
  for (const VdbGrid& grid : file.grids) {
    names.push_back(grid.name);
    if (grid.name != name || grid.width != 1) continue;
    Int3 first{}, last{};
    for (int a = 0; a < 3; ++a) {
      first[a] = int(std::floor(std::clamp((lo[a] - grid.origin[a]) / grid.spacing, -1e9, 1e9)));
      last[a] = int(std::ceil(std::clamp((hi[a] - grid.origin[a]) / grid.spacing, -1e9, 1e9)));
    }
    Stored out{
        grid.origin + grid.spacing * cast<double>(first), grid.spacing, last - first + Int3{1, 1, 1}, {}};
    check_count(path, cast<double>(last) - cast<double>(first) + Vec3d{1, 1, 1});
    out.values.assign(std::size_t(out.size.x) * out.size.y * out.size.z, grid.background.x);
    for (std::size_t l = 0; l < grid.leaves.size(); ++l)
      for (int i = 0; i < kBrickRows; ++i) {
        const Int3 v = grid.leaves[l] + Int3{i >> 6, i >> 3 & 7, i & 7} - first;
        if (v.x < 0 || v.y < 0 || v.z < 0 || v.x >= out.size.x || v.y >= out.size.y || v.z >= out.size.z)
          continue;
        out.values[(std::size_t(v.x) * out.size.y + v.y) * out.size.z + v.z] =
            grid.values[l * kBrickRows + std::size_t(i)];
      }
    return out;
  }
  names.insert(names.end(), file.skipped.begin(), file.skipped.end());
  fail_no_grid(path, name, names);
}

/// What truth.json says, read field by field.
class Fields {
 public:
  Fields(const nlohmann::json& json, std::string where) : json_(json), where_(std::move(where)) {}
  const nlohmann::json& at(const char* key, const char* expected) const {
    if (!json_.is_object() || !json_.contains(key)) wrong(key, expected, "nothing");
    return json_.at(key);
  }
  double number(const char* key) const {
    const nlohmann::json& v = at(key, "a number");
    if (!v.is_number()) wrong(key, "a number", v.type_name());
    return v.get<double>();
  }
  std::string text(const char* key) const {
    const nlohmann::json& v = at(key, "a text");
    if (!v.is_string()) wrong(key, "a text", v.type_name());
    return v.get<std::string>();
  }
  Vec3d three(const char* key) const {
    const nlohmann::json& v = at(key, "three numbers");
    if (!v.is_array() || v.size() != 3 ||
        !std::all_of(v.begin(), v.end(), [](const auto& n) { return n.is_number(); }))
      wrong(key, "three numbers", v.type_name());
    return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
  }
  [[noreturn]] void wrong(const char* key, const std::string& expected, const std::string& got) const {
    fail({where_, fmt::format("'{}' is absent or wrong", key), expected, got,
          "docs/formats.md says what it holds"});
  }

 private:
  const nlohmann::json& json_;
  std::string where_;
};

/// A file that truth.json names: beside the folder or in it, since folders get other names.
std::string found(const fs::path& folder, const std::string& name, const std::string& where) {
  const fs::path beside = fs::absolute(folder / "").parent_path().parent_path() / name,
                 in = folder / fs::path(name).filename();
  std::error_code ignored;
  for (const fs::path& path : {in, beside})
    if (fs::is_regular_file(path, ignored)) return path.string();
  fail({where, "a volume is not there", in.string(), "no such file", "copy the folder again"});
}

TruthVolumes from_json(const std::string& folder, const std::string& path, const TimeMap& time_map,
                       bool part) {
  const nlohmann::json json = data::read_json(path, path);
  const Fields fields(json, path);
  TruthVolumes out;
  out.folder = folder;
  if (json.is_object() && json.contains("grid")) out.grid = fields.text("grid");
  out.spacing = fields.number("voxel");
  if (!(out.spacing > 0)) fields.wrong("voxel", "above 0", fmt::format("{:g}", out.spacing));
  const Vec3d shape = fields.three("shape");
  check_count(path, shape);
  out.size = cast<int>(shape);
  out.origin = fields.three("first_voxel_middle");
  const nlohmann::json& volumes = fields.at("volumes", "a list of volumes");
  if (!volumes.is_array() || volumes.empty())
    fields.wrong("volumes", "a list of volumes", volumes.type_name());
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const Fields volume(volumes[i], fmt::format("{}, volume {}", path, i));
    const double own = volume.number("time"), time = time_map.scale == 0 ? 0 : time_map(own);
    if (!(time >= -kTimeSlack && time <= 1 + kTimeSlack)) {
      const double end = time_map.raw(1);
      const bool one_is_left = i + 1 < volumes.size() || !out.moments.empty();
      if (part && one_is_left) continue;
      volume.wrong("time", fmt::format("within the run's time, {:g} to {:g}", time_map.origin, end),
                   fmt::format("{:g}", own));
    }
    out.moments.push_back({found(folder, volume.text("file"), path), std::clamp(time, 0.0, 1.0)});
  }
  if (out.moments.size() < volumes.size())
    out.notes.push_back(fmt::format("{} of {} true volumes lie in the run's part of the time",
                                    out.moments.size(), volumes.size()));
  std::stable_sort(out.moments.begin(), out.moments.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return out;
}

/// Where a file has voxels.
Stored extent_of(const std::string& path, const std::string& name) {
  if (fs::path(path).extension() == ".npz") {
    Stored out = read_npz_volume(path);
    out.values.clear();
    return out;
  }
  const VdbInfo info = inspect_vdb(path);
  std::vector<std::string> names;
  for (const GridInfo& grid : info.grids) {
    names.push_back(grid.name);
    if (grid.name != name) continue;
    const bool any = grid.lo.x <= grid.hi.x;
    return {grid.origin + mul(grid.voxel_size, cast<double>(any ? grid.lo : Int3{})),
            grid.voxel_size.x,
            any ? grid.hi - grid.lo + Int3{1, 1, 1} : Int3{},
            {}};
  }
  fail_no_grid(path, name, names);
}

TruthVolumes from_files(const std::string& folder, std::vector<std::string> files) {
  std::sort(files.begin(), files.end(), data::natural_less);  // 10 comes after 9
  TruthVolumes out;
  out.folder = folder;
  const double last = double(std::max<std::size_t>(1, files.size() - 1));
  for (std::size_t i = 0; i < files.size(); ++i) out.moments.push_back({files[i], double(i) / last});
  out.notes.push_back(fmt::format(
      "no truth.json in {}: its {} volumes are taken in the order of their names and evenly over all time",
      folder, files.size()));
  Vec3d lo{}, hi{};
  for (const std::string& file : files) {
    const Stored extent = extent_of(file, out.grid);
    if (extent.size == Int3{}) continue;  // nothing is there at that moment
    const Vec3d end = extent.origin + extent.spacing * cast<double>(extent.size - Int3{1, 1, 1});
    if (out.spacing == 0) {
      out.spacing = extent.spacing;
      out.origin = extent.origin;
      lo = extent.origin;
      hi = end;
    }
    lo = min(lo, extent.origin);
    hi = max(hi, end);
  }
  if (out.spacing == 0)
    fail({folder, "all volumes are empty", "densities above 0",
          fmt::format("{} files without any", files.size()), ""});
  Vec3d size{};
  for (int a = 0; a < 3; ++a) {
    const double before = std::ceil((out.origin[a] - lo[a]) / out.spacing - 1e-6);
    out.origin[a] -= before * out.spacing;
    size[a] = std::ceil((hi[a] - out.origin[a]) / out.spacing - 1e-6) + 1;
  }
  check_count(folder, size);
  out.size = cast<int>(size);
  return out;
}

}  // namespace

TruthVolumes open_truth_volumes(const std::string& folder, const TimeMap& time_map, bool part) {
  std::error_code error;
  const char* const hint = "splinevox synth smoke makes such a folder";
  if (!fs::is_directory(folder, error))
    fail({folder, "there is no such folder", "a folder with truth.json and volumes, or with volumes alone",
          fs::exists(folder, error) ? "a file" : "nothing", hint});
  const fs::path json = fs::path(folder) / "truth.json";
  if (fs::exists(json, error)) return from_json(folder, json.string(), time_map, part);
  std::vector<std::string> vdb, npz;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".vdb") vdb.push_back(entry.path().string());
    if (entry.path().extension() == ".npz") npz.push_back(entry.path().string());
  }
  if (vdb.empty() && npz.empty())
    fail({folder, "there are no truth volumes in this folder", "truth.json, or .vdb or .npz files", "none",
          hint});
  if (part)
    fail({folder, "volumes without truth.json have no times, and the run is of a part of the time",
          "a truth.json beside them", "", "a run of all the time, or truth.json as docs/formats.md has it"});
  return from_files(folder, vdb.empty() ? std::move(npz) : std::move(vdb));
}

std::vector<float> read_truth_volume(const TruthVolumes& truth, std::size_t moment) {
  const std::string& path = truth.moments[moment].file;
  const Stored stored = fs::path(path).extension() == ".npz"
                            ? read_npz_volume(path)
                            : read_vdb_volume(path, truth.grid, truth.lo(), truth.hi());
  const auto bad = std::find_if(stored.values.begin(), stored.values.end(),
                                [](float v) { return !(v >= 0 && v <= std::numeric_limits<float>::max()); });
  if (bad != stored.values.end())
    fail({path, "a density is negative or not finite", "0 or more", fmt::format("{:g}", *bad), ""});
  std::vector<float> out(truth.voxels());
  parallel_for(truth.size.x, [&](int x) {
    std::size_t i = std::size_t(x) * truth.size.y * truth.size.z;
    for (int y = 0; y < truth.size.y; ++y)
      for (int z = 0; z < truth.size.z; ++z)
        out[i++] = stored.at(truth.origin + truth.spacing * cast<double>(Int3{x, y, z}));
  });
  return out;
}

}  // namespace splinevox::run
