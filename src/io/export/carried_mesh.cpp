// SPDX-License-Identifier: Apache-2.0
#include "io/export/carried_mesh.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "core/parallel.hpp"
#include "math/srgb.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox {
namespace {

using Json = nlohmann::ordered_json;

Json list_of(Json one) {
  Json list = Json::array();
  list.push_back(std::move(one));
  return list;
}

/// Vertices beside each vertex, by edges: those of v are list[begin[v]] to list[begin[v + 1]].
struct Neighbours {
  std::vector<std::size_t> begin;
  std::vector<std::uint32_t> list;

  explicit Neighbours(const ColorMesh& mesh) : begin(mesh.points.size() + 1, 0) {
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t v : t) begin[v + 1] += 2;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) begin[v + 1] += begin[v];
    list.resize(begin.back());
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (const auto& t : mesh.triangles)
      for (std::size_t c = 0; c < 3; ++c)
        for (const std::size_t other : {(c + 1) % 3, (c + 2) % 3}) list[next[t[c]]++] = t[other];
  }
  std::span<const std::uint32_t> of(std::uint32_t v) const {
    return {list.data() + begin[v], begin[v + 1] - begin[v]};
  }
};

constexpr int kFloat = 5126, kUnsigned = 5125, kUnsignedShort = 5123;  // glTF's component types
constexpr int kVertexData = 34962, kIndexData = 34963;                 // and targets of buffer views

/// The parts of a glTF file that grow with what is put into it.
class Glb {
 public:
  /// @return  the number of a view of these values
  template <class T>
  int view(const std::vector<T>& values, int target = 0) {
    const std::size_t bytes = values.size() * sizeof(T);
    Json view{{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes}};
    if (target) view["target"] = target;
    views_.push_back(view);
    bytes_.append(reinterpret_cast<const char*>(values.data()), bytes);
    bytes_.resize((bytes_.size() + 3) / 4 * 4, '\0');
    return int(views_.size()) - 1;
  }
  /// @return  the number of an accessor
  int accessor(Json what) {
    accessors_.push_back(std::move(what));
    return int(accessors_.size()) - 1;
  }
  int scalars(const std::vector<float>& values) {
    Json what{{"bufferView", view(values)},
              {"componentType", kFloat},
              {"count", values.size()},
              {"type", "SCALAR"}};
    const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
    what["min"] = Json::array({*lo});
    what["max"] = Json::array({*hi});
    return accessor(what);
  }
  /// All of it as a file. Throws Error if it is too large for one.
  std::string file(Json head) && {
    if (!bytes_.empty()) {
      head["accessors"] = std::move(accessors_);
      head["bufferViews"] = std::move(views_);
      head["buffers"] = list_of({{"byteLength", bytes_.size()}});
    }
    std::string text = head.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t whole = 12 + 8 + text.size() + (bytes_.empty() ? 0 : 8 + bytes_.size());
    if (whole > std::numeric_limits<std::uint32_t>::max())
      fail({.where = "--mesh-format",
            .what = "the moving mesh is too large for a glb file",
            .expected = "at most 4 GiB",
            .got = std::to_string(whole >> 20) + " MiB",
            .hint = "a larger --voxel-size, or fewer frames"});
    std::string out;
    out.reserve(whole);
    const auto word = [&](std::size_t value) {
      const auto w = std::uint32_t(value);
      out.append(reinterpret_cast<const char*>(&w), sizeof w);
    };
    out += "glTF";
    word(2);
    word(whole);
    word(text.size());
    out += "JSON";
    out += text;
    if (bytes_.empty()) return out;
    word(bytes_.size());
    out += std::string("BIN\0", 4);
    return out += bytes_;
  }

 private:
  Json accessors_ = Json::array(), views_ = Json::array();
  std::string bytes_;
};

/// The least and the largest of each coordinate, 0 among them if `zero`.
void add_bounds(Json& accessor, const std::vector<Vec3>& values, bool zero) {
  Vec3 lo = zero ? Vec3{} : values[0], hi = lo;
  for (const Vec3& v : values)
    for (int a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], v[a]);
      hi[a] = std::max(hi[a], v[a]);
    }
  accessor["min"] = {lo.x, lo.y, lo.z};
  accessor["max"] = {hi.x, hi.y, hi.z};
}

int places_of(Glb& glb, const std::vector<Vec3>& points) {
  Json what{{"bufferView", glb.view(points, kVertexData)},
            {"componentType", kFloat},
            {"count", points.size()},
            {"type", "VEC3"}};
  add_bounds(what, points, false);
  return glb.accessor(what);
}

/// Colours are linear in glTF; 16 bits keep the dark ones apart.
int colors_of(Glb& glb, const ColorMesh& mesh) {
  std::vector<std::array<std::uint16_t, 4>> colors(mesh.colors.size());
  for (std::size_t i = 0; i < colors.size(); ++i) {
    for (std::size_t a = 0; a < 3; ++a)
      colors[i][a] = std::uint16_t(std::lround(65535 * srgb_to_linear(float(mesh.colors[i][a]) / 255)));
    colors[i][3] = 65535;
  }
  return glb.accessor({{"bufferView", glb.view(colors, kVertexData)},
                       {"componentType", kUnsignedShort},
                       {"normalized", true},
                       {"count", colors.size()},
                       {"type", "VEC4"}});
}

/// What a frame adds to the places, only where it is more than `still`.
int target_of(Glb& glb, const ColorMesh& mesh, const std::vector<Vec3>& places, float still) {
  std::vector<std::uint32_t> moved;
  std::vector<Vec3> by;
  for (std::uint32_t v = 0; v < places.size(); ++v)
    if (const Vec3 d = places[v] - mesh.points[v]; !(length(d) <= still)) {
      moved.push_back(v);
      by.push_back(d);
    }
  if (moved.empty()) {  // a sparse accessor has at least one value
    moved = {0};
    by = {{}};
  }
  Json what{{"componentType", kFloat}, {"count", places.size()}, {"type", "VEC3"}};
  add_bounds(what, by, moved.size() < places.size());
  what["sparse"] = {{"count", moved.size()},
                    {"indices", {{"bufferView", glb.view(moved)}, {"componentType", kUnsigned}}},
                    {"values", {{"bufferView", glb.view(by)}}}};
  return glb.accessor(what);
}

/// Gives values that are not `known` the mean of their known neighbours, from those outwards.
void fill(const Neighbours& beside, std::vector<bool> known, std::vector<Vec3>& values) {
  std::vector<std::uint32_t> open;
  for (std::uint32_t v = 0; v < values.size(); ++v)
    if (!known[v]) open.push_back(v);
  while (!open.empty()) {
    std::vector<std::uint32_t> filled, left;
    for (const std::uint32_t v : open) {
      Vec3d sum{};
      int count = 0;
      for (const std::uint32_t n : beside.of(v))
        if (known[n]) {
          sum = sum + cast<double>(values[n]);
          ++count;
        }
      (count > 0 ? filled : left).push_back(v);
      if (count > 0) values[v] = cast<float>((1.0 / count) * sum);
    }
    if (filled.empty()) return;
    for (const std::uint32_t v : filled) known[v] = true;
    open = std::move(left);
  }
}

/// follow_neighbours, with the neighbours found once for all frames.
void follow(const Neighbours& beside, const ColorMesh& mesh, const std::vector<bool>& known,
            std::vector<Vec3>& places) {
  std::vector<Vec3> by(places.size());
  for (std::size_t v = 0; v < by.size(); ++v) by[v] = places[v] - mesh.points[v];
  fill(beside, known, by);
  for (std::size_t v = 0; v < by.size(); ++v)
    if (!known[v]) places[v] = mesh.points[v] + by[v];
}

}  // namespace

void follow_neighbours(const ColorMesh& mesh, const std::vector<bool>& known, std::vector<Vec3>& places) {
  follow(Neighbours(mesh), mesh, known, places);
}

CarriedMesh carry_mesh(const VoxelModel& model, ColorMesh mesh, double from, const FrameTimes& frames) {
  const std::vector<double>& times = frames.times;
  const auto tracks = track(model, mesh.points, from, times);
  CarriedMesh out{std::move(mesh),
                  std::vector(times.size(), std::vector<Vec3>(tracks.empty() ? 0 : tracks[0].size())),
                  std::vector(times.size(), std::vector<Vec3>())};
  const Neighbours beside(out.mesh);
  std::vector<std::size_t> lost(times.size(), 0);
  parallel_for(int(times.size()), [&](int frame) {
    const auto f = std::size_t(frame);
    std::vector<bool> known(tracks[f].size());
    for (std::size_t v = 0; v < tracks[f].size(); ++v) {
      out.places[f][v] = tracks[f][v].position;
      known[v] = !tracks[f][v].folded;
      lost[f] += !known[v];
    }
    follow(beside, out.mesh, known, out.places[f]);
    if (frames.rates.empty()) return;
    out.velocities[f] = velocities_at(model, times[f], frames.rates[f], out.places[f]);
    fill(beside, known, out.velocities[f]);
  });
  std::size_t all = 0;
  for (const std::size_t n : lost) all += n;
  if (all > 0) out.untracked = double(all) / (double(times.size()) * double(out.mesh.points.size()));
  return out;
}

std::string glb_bytes(const CarriedMesh& carried, const MeshPlay& play) {
  static_assert(std::endian::native == std::endian::little && sizeof(Vec3) == 12);
  const ColorMesh& mesh = carried.mesh;
  Json head{{"asset", {{"version", "2.0"}, {"generator", "splinevox"}}}, {"scene", 0}};
  // glTF has Y up where scenes have Z.
  const double half = std::sqrt(0.5);
  Json node{{"name", play.name}, {"rotation", {-half, 0.0, 0.0, half}}};
  head["scenes"] = list_of({{"nodes", list_of(0)}});
  if (mesh.triangles.empty()) {
    head["nodes"] = list_of(node);
    return Glb().file(std::move(head));
  }
  Glb glb;
  Json primitive{
      {"attributes", {{"POSITION", places_of(glb, mesh.points)}, {"COLOR_0", colors_of(glb, mesh)}}}};
  primitive["indices"] = glb.accessor({{"bufferView", glb.view(mesh.triangles, kIndexData)},
                                       {"componentType", kUnsigned},
                                       {"count", 3 * mesh.triangles.size()},
                                       {"type", "SCALAR"}});
  primitive["material"] = 0;
  const std::size_t frames = carried.places.size();
  for (const auto& places : carried.places)
    primitive["targets"].push_back({{"POSITION", target_of(glb, mesh, places, play.still)}});
  std::vector<float> seconds(play.seconds.begin(), play.seconds.end()), weights(frames * frames, 0.0f);
  for (std::size_t f = 0; f < frames; ++f) weights[f * frames + f] = 1;
  Json sampler{
      {"input", glb.scalars(seconds)}, {"interpolation", "LINEAR"}, {"output", glb.scalars(weights)}};
  Json channel{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}};
  std::vector<float> first(frames, 0.0f);
  if (frames > 0) first[0] = 1;
  node["mesh"] = 0;
  head["nodes"] = list_of(node);
  head["meshes"] = list_of({{"name", play.name},
                            {"primitives", list_of(primitive)},
                            {"weights", first},
                            {"extras", {{"targetNames", play.frames}}}});
  head["materials"] = list_of({{"name", "radiance"},
                               {"doubleSided", true},  // where matter leaves the box the surface is open
                               {"extensions", {{"KHR_materials_unlit", Json::object()}}}});
  head["extensionsUsed"] = list_of("KHR_materials_unlit");
  head["animations"] =
      list_of({{"name", "motion"}, {"samplers", list_of(sampler)}, {"channels", list_of(channel)}});
  return std::move(glb).file(std::move(head));
}

}  // namespace splinevox
