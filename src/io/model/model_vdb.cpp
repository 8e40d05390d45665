// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/model_vdb.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/process.hpp"
#include "io/model/model_grid.hpp"
#include "io/model/model_meta.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

constexpr std::string_view kNotePrefix = "note:";

const VdbGrid* find(const VdbFile& file, const std::string& name) {
  for (const VdbGrid& grid : file.grids)
    if (grid.name == name) return &grid;
  return nullptr;
}

/// Whether a grid holds points of a curve: those alone tell whether a file has motion.
bool is_curve(const std::string& grid) {
  for (const ColumnFacts& c : kColumns)
    if (c.repeat == Repeat::point && grid.starts_with(std::string(c.name) + "_")) return true;
  return false;
}

/// The grids of one field, in the order of its columns. A missing or misshapen one is an error.
std::vector<const VdbGrid*> find_all(const std::string& path, const VdbFile& file,
                                     const std::vector<Column>& columns) {
  std::vector<const VdbGrid*> grids;
  for (const Column& column : columns) {
    const VdbGrid* grid = find(file, column.grid);
    if (!grid || grid->width != column.width)
      fail({.where = path,
            .what = "has no grid '" + column.grid + "' of the right type",
            .expected = column.width == 1 ? "a float grid" : "a Vec3s grid",
            .got = grid ? "another type" : "no such grid",
            .hint = "is this the model.vdb of a run?"});
    grids.push_back(grid);
  }
  return grids;
}

/// Bricks that any of the grids stores: another program may have dropped constant leaves from some.
TopologyPtr read_topology(const std::string& path, const Lattice& lattice,
                          const std::vector<const VdbGrid*>& grids) {
  Int3 bricks{};
  for (int a = 0; a < 3; ++a) bricks[a] = (lattice.size[a] + kBrick - 1) / kBrick;
  std::vector<char> seen(std::size_t(bricks.x) * bricks.y * bricks.z, 0);
  std::vector<Int3> stored;
  for (const VdbGrid* grid : grids)
    for (const Int3& leaf : grid->leaves) {
      const Int3 b{leaf.x / kBrick, leaf.y / kBrick, leaf.z / kBrick};
      bool inside = true;
      for (int a = 0; a < 3; ++a) inside = inside && leaf[a] >= 0 && b[a] < bricks[a];
      if (!inside)
        fail({.where = path + ", grid '" + grid->name + "'",
              .what = "has voxels outside its lattice",
              .expected = "indices within " + std::to_string(lattice.size.x) + " x " +
                          std::to_string(lattice.size.y) + " x " + std::to_string(lattice.size.z),
              .got = std::to_string(leaf.x) + " " + std::to_string(leaf.y) + " " + std::to_string(leaf.z)});
      char& mark = seen[(std::size_t(b.x) * bricks.y + b.y) * bricks.z + b.z];
      if (!mark) stored.push_back(b);
      mark = 1;
    }
  return make_topology(lattice, std::move(stored));
}

/// A row has every column, also where only one grid stores a brick.
void check_room(const std::string& path, const Topology& topology, int width) {
  const double bytes = sizeof(float) * double(topology.rows()) * width, room = free_memory();
  if (room == 0 || bytes <= room) return;
  fail_memory({.where = path,
               .what = "not enough memory for this model",
               .expected = std::to_string(std::uint64_t(bytes) >> 20) + " MiB",
               .got = std::to_string(std::uint64_t(room) >> 20) + " MiB",
               .hint = "end other programs, or use a larger machine"});
}

Channels read_channels(const std::string& path, const VdbFile& file, const Lattice& lattice, int width,
                       const std::vector<Column>& columns) {
  const std::vector<const VdbGrid*> grids = find_all(path, file, columns);
  std::vector<float> background(std::size_t(width), 0.0f);
  for (std::size_t g = 0; g < grids.size(); ++g)
    for (int c = 0; c < columns[g].width; ++c)
      background[std::size_t(columns[g].first + c)] = grids[g]->background[c];
  TopologyPtr topology = read_topology(path, lattice, grids);
  check_room(path, *topology, width);
  Channels channels = make_channels(std::move(topology), width, background.data());
  for (std::size_t g = 0; g < grids.size(); ++g) {
    const VdbGrid& grid = *grids[g];
    const float* in = grid.values.data();
    for (const Int3& leaf : grid.leaves) {
      const Int3 brick{leaf.x / kBrick, leaf.y / kBrick, leaf.z / kBrick};
      const std::size_t first = std::size_t(channels.topology->brick_at(brick)) * kBrickRows;
      for (std::size_t r = first; r < first + kBrickRows; ++r)
        for (int c = 0; c < grid.width; ++c, ++in) {
          if (!std::isfinite(*in))
            fail({.where = path + ", grid '" + grid.name + "'",
                  .what = "holds a value that is not finite",
                  .expected = "finite numbers",
                  .got = std::to_string(*in),
                  .hint = ""});
          channels.row(r)[columns[g].first + c] = *in;
        }
    }
  }
  return channels;
}

}  // namespace

VdbGrid to_grid(const Channels& channels, const Column& column, const VdbMeta& meta, bool half) {
  const Topology& topology = *channels.topology;
  const Lattice& lattice = topology.lattice;
  VdbGrid grid;
  grid.name = column.grid;
  grid.width = column.width;
  grid.origin = cast<double>(lattice.origin);
  grid.spacing = lattice.spacing;
  grid.vector = column.width == 3 ? VdbVector::invariant : VdbVector::none;
  grid.half = half;
  grid.meta = meta;
  grid.meta["role"] = column.role;
  grid.meta["activation"] = column.activation;
  if (column.activation != kDensityActivation) {
    grid.meta.erase("activation_scale");
    grid.meta.erase("activation_shift");
  }
  for (int c = 0; c < column.width; ++c) grid.background[c] = channels.row(0)[column.first + c];
  grid.leaves.reserve(std::size_t(topology.brick_count()));
  for (int b = 1; b <= topology.brick_count(); ++b) grid.leaves.push_back(kBrick * topology.bricks[b]);
  grid.values.resize(grid.leaves.size() * kBrickRows * std::size_t(column.width));
  float* out = grid.values.data();
  for (std::size_t r = kBrickRows; r < topology.rows(); ++r, out += column.width)
    std::memcpy(out, channels.row(r) + column.first, sizeof(float) * std::size_t(column.width));
  return grid;
}

namespace {

/// What readers refuse is not written.
void check_writable(const std::string& path, const VdbFile& file) {
  if (const int most = VdbLimits().max_grids; file.grids.size() > std::size_t(most))
    fail_output({.where = path,
                 .what = "a model file cannot hold so many grids",
                 .expected = "at most " + std::to_string(most),
                 .got = std::to_string(file.grids.size()),
                 .hint = "fewer control points"});
  for (const VdbGrid& grid : file.grids) {
    const auto finite = [](float v) { return std::isfinite(v); };
    const auto wrong = std::find_if_not(grid.values.begin(), grid.values.end(), finite);
    if (wrong != grid.values.end() || !finite(float(length(grid.background))))
      throw Error(
          {.where = path,
           .what = "is not written: the model has values that are not finite",
           .expected = "finite numbers",
           .got = "others in grid '" + grid.name + "'",
           .hint =
               "smaller steps (optimiser.lr_*) or a larger optimiser.epsilon; smaller factors in an edit"},
          Fault::numeric);
  }
}

}  // namespace

FileDigest save_model(const std::string& path, const VoxelModel& model, const ModelNotes& notes, bool half) {
  if (model.motion.levels.size() > 1)
    fail_output({.where = path,
                 .what = "a model file holds one motion level",
                 .expected = "collapse(motion) before saving",
                 .got = std::to_string(model.motion.levels.size()) + " levels",
                 .hint = ""});
  VdbFile file;
  file.meta = model_meta(model);
  VoxelModel probe;  // what the reader would refuse is not written
  parse_model_meta({path, file.meta}, probe);
  for (const auto& [key, value] : notes) file.meta[std::string(kNotePrefix) + key] = value;
  const VdbMeta radiance = radiance_meta(model.radiance);
  parse_radiance_meta({path, radiance}, probe.radiance);
  for (const Column& column : radiance_columns(model.radiance))
    file.grids.push_back(to_grid(model.radiance.raw, column, radiance, half));
  if (!model.motion.levels.empty()) {
    const VdbMeta motion = motion_meta(model.motion);
    parse_motion_meta({path, motion}, probe.motion);
    for (const Column& column : motion_columns(model.motion))
      file.grids.push_back(to_grid(model.motion.levels[0], column, motion, half));
  }
  if (model.surroundings.any()) {
    const VdbMeta around = surroundings_meta(model.surroundings);
    parse_surroundings_meta({path, around}, probe.surroundings);
    for (const Column& column : surroundings_columns())
      file.grids.push_back(to_grid(model.surroundings.raw, column, around, half));
  }
  check_writable(path, file);
  for (VdbGrid& grid : file.grids)  // for programs that keep grids and not the file's own table
    for (const char* key : {"splinevox_model", "time_map", "background"}) grid.meta[key] = file.meta[key];
  return write_vdb(path, std::move(file));
}

VoxelModel load_model(const std::string& path, ModelNotes* notes) {
  const VdbFile file = read_vdb(path);
  VoxelModel model;
  parse_model_meta({path, file.meta}, model);
  if (notes)
    for (const auto& [key, value] : file.meta)
      if (key.starts_with(kNotePrefix) && std::holds_alternative<std::string>(value))
        (*notes)[key.substr(kNotePrefix.size())] = std::get<std::string>(value);

  const std::string name = facts_of(ColumnKind::density).name;
  const VdbGrid* density = find(file, name);
  if (!density)
    fail({.where = path,
          .what = "has no grid '" + name + "'",
          .expected = "the model.vdb of a run",
          .got = "",
          .hint = ""});
  const FieldShape radiance =
      parse_radiance_meta({path + ", grid '" + name + "'", density->meta}, model.radiance);
  model.radiance.raw =
      read_channels(path, file, radiance.lattice, radiance.width, radiance_columns(model.radiance));
  for (const VdbGrid& grid : file.grids) {
    if (!is_curve(grid.name)) continue;
    const FieldShape motion =
        parse_motion_meta({path + ", grid '" + grid.name + "'", grid.meta}, model.motion);
    model.motion.levels.push_back(
        read_channels(path, file, motion.lattice, motion.width, motion_columns(model.motion)));
    break;
  }
  const std::vector<Column> around = surroundings_columns();
  if (const VdbGrid* grid = find(file, around[0].grid)) {
    const FieldShape shape =
        parse_surroundings_meta({path + ", grid '" + grid->name + "'", grid->meta}, model.surroundings);
    model.surroundings.raw = read_channels(path, file, shape.lattice, shape.width, around);
  }
  return model;
}

}  // namespace splinevox
