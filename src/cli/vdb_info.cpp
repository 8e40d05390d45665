// SPDX-License-Identifier: Apache-2.0
#include "cli/vdb_info.hpp"

#include <fmt/format.h>

#include <array>

#include "run/support.hpp"
#include "splinevox/io/inspect.hpp"

namespace splinevox::cli {
namespace {

/// The digits a grid's name ends in.
std::string number_of(const std::string& name) {
  return name.substr(name.find_last_not_of("0123456789") + 1);
}

/// Whether two grids have names that differ in their last number only, and the same shape.
bool same_family(const Json& a, const Json& b) {
  const std::string x = a["name"].get<std::string>(), y = b["name"].get<std::string>();
  const std::string p = number_of(x), q = number_of(y);
  if (p.empty() || q.empty() || x.substr(0, x.size() - p.size()) != y.substr(0, y.size() - q.size()))
    return false;
  for (const char* key : {"type", "class", "active_voxels", "leaves", "voxel_size", "half", "bounds"})
    if (a[key] != b[key]) return false;
  return true;
}

/// How large voxels are and where voxel (0, 0, 0) is.
std::string transform_text(const Json& grid) {
  if (!grid["linear"].get<bool>()) return "not linear";
  const auto v = grid["voxel_size"].get<std::array<double, 3>>(),
             o = grid["origin"].get<std::array<double, 3>>();
  const std::string size = v[0] == v[1] && v[1] == v[2]
                               ? fmt::format("{:.6g}", v[0])
                               : fmt::format("{:.6g} x {:.6g} x {:.6g}", v[0], v[1], v[2]);
  return fmt::format("{} from ({:.5g}, {:.5g}, {:.5g})", size, o[0], o[1], o[2]);
}

}  // namespace

Json vdb_json(const std::string& path) {
  const VdbInfo info = inspect_vdb(path);
  Json grids = Json::array();
  for (const GridInfo& g : info.grids)
    grids.push_back({{"name", g.name},
                     {"type", g.type},
                     {"class", g.grid_class},
                     {"active_voxels", g.active_voxels},
                     {"leaves", g.leaves},
                     {"memory_bytes", g.memory_bytes},
                     {"half", g.half},
                     {"linear", g.linear},
                     {"voxel_size", triple(g.voxel_size)},
                     {"origin", triple(g.origin)},
                     {"bounds", {triple(g.lo), triple(g.hi)}},
                     {"meta", g.meta}});
  return {{"file", path},          {"bytes", info.file_bytes}, {"version", info.version},
          {"sealed", info.sealed}, {"meta", info.meta},        {"grids", grids}};
}

void print_vdb(const Json& j) {
  fmt::print("{}: {:.2f} MB, {}{}\n", j["file"].get<std::string>(), j["bytes"].get<double>() / 1e6,
             j["version"].get<std::string>(), j["sealed"].get<bool>() ? ", checksum right" : "");
  print_grids(j["grids"]);
  for (const auto& [key, value] : j["meta"].items())
    if (!key.empty()) fmt::print("  {} = {}\n", key, value.get<std::string>());
}

void print_grids(const Json& grids) {
  fmt::print("  {:<14} {:<7} {:<11} {:>11} {:>9} {:>10}           {:<44}voxels\n", "grid", "type", "class",
             "active", "leaves", "memory", "voxel size and origin");
  for (std::size_t i = 0; i < grids.size();) {
    const Json& g = grids[i];
    std::size_t next = i + 1;  // sh0, sh1, ... or control_0, control_1, ... of one shape share a line
    while (next < grids.size() && same_family(g, grids[next])) ++next;
    std::string name = g["name"].get<std::string>();
    const bool several = next > i + 1;
    if (several) name += ".." + number_of(grids[next - 1]["name"].get<std::string>());
    i = next;
    const Json &lo = g["bounds"][0], &hi = g["bounds"][1];
    fmt::print("  {:<14} {:<7} {:<11} {:>11} {:>9} {:>7.1f} MB{:5} {:4} {:<44}", name,
               g["type"].get<std::string>(), g["class"].get<std::string>(),
               g["active_voxels"].get<std::uint64_t>(), g["leaves"].get<std::uint64_t>(),
               g["memory_bytes"].get<double>() / 1e6, several ? " each" : "",
               g["half"].get<bool>() ? "half" : "", transform_text(g));
    if (lo[0] <= hi[0])
      fmt::print("[{} {} {}] to [{} {} {}]", json_text(lo[0]), json_text(lo[1]), json_text(lo[2]),
                 json_text(hi[0]), json_text(hi[1]), json_text(hi[2]));
    fmt::print("\n");
  }
}

}  // namespace splinevox::cli
