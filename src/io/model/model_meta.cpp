// SPDX-License-Identifier: Apache-2.0
#include "io/model/model_meta.hpp"

#include <algorithm>
#include <cmath>

#include "field/columns.hpp"
#include "io/model/exact_text.hpp"
#include "math/sh.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/math/basis.hpp"

namespace splinevox {
namespace {

constexpr int kMaxWidth = widest_motion(kMaxPoints);  // floats per row
constexpr double kMostSteps = 1 << 20;                // of a ray through the box

[[noreturn]] void bad(const NamedMeta& in, const std::string& key, std::string expected, std::string got) {
  fail({.where = in.where,
        .what = "metadata '" + key + "' is missing or wrong",
        .expected = std::move(expected),
        .got = got.substr(0, 200),
        .hint = "is this the model.vdb of a run?"});
}

std::string text_of(const NamedMeta& in, const std::string& key) {
  const auto at = in.meta.find(key);
  if (at == in.meta.end()) bad(in, key, "a text", "nothing");
  if (!std::holds_alternative<std::string>(at->second)) bad(in, key, "a text", "a number");
  return std::get<std::string>(at->second);
}

/// The text as an error shows it. Appends, because g++ 12 sees an overlap in "'" + text + "'" that is not
/// there.
std::string quoted(const NamedMeta& in, const std::string& key) {
  std::string out = "'";
  out += text_of(in, key);
  return out += "'";
}

int integer(const NamedMeta& in, const std::string& key, int lo, int hi) {
  const auto at = in.meta.find(key);
  const std::string expected = "an integer from " + std::to_string(lo) + " to " + std::to_string(hi);
  if (at == in.meta.end() || !std::holds_alternative<std::int64_t>(at->second))
    bad(in, key, expected, "nothing of that type");
  const std::int64_t v = std::get<std::int64_t>(at->second);
  if (v < lo || v > hi) bad(in, key, expected, std::to_string(v));
  return int(v);
}

template <class T>
std::vector<T> numbers(const NamedMeta& in, const std::string& key, std::size_t count) {
  const std::string text = text_of(in, key);
  std::vector<T> values = parse_exact<T>(text, count);
  if (values.size() != count) bad(in, key, std::to_string(count) + " finite numbers", "'" + text + "'");
  return values;
}

std::string listed(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

/// Position of a text in a list of names.
template <std::size_t N>
std::size_t choice(const NamedMeta& in, const std::string& key, const char* const (&names)[N]) {
  const std::string text = text_of(in, key);
  for (std::size_t i = 0; i < N; ++i)
    if (text == names[i]) return i;
  bad(in, key, "one of: " + listed({names, names + N}), quoted(in, key));
}

constexpr const char* kFirstPoints[] = {"zero", "free"};
constexpr const char* kActivations[] = {kDensityActivation};
constexpr const char* kSwitch[] = {"off", "on"};

void put_shape(VdbMeta& meta, const Channels& channels) {
  const Lattice& l = channels.topology->lattice;
  meta["lattice"] = exact_text<float>(
      {l.origin.x, l.origin.y, l.origin.z, l.spacing, float(l.size.x), float(l.size.y), float(l.size.z)});
  meta["row_width"] = std::int64_t(channels.width);
}

/// The first format that can hold a model: programs that would show it wrongly are to refuse it.
int format_of(const VoxelModel& model) {
  const MotionField& m = model.motion;
  int format = m.time_curve.identity() && basis_of(m.basis).trained ? kModelFormat : kEditedFormat;
  if (model.background.learned()) format = kBackgroundFormat;
  if (model.surroundings.any()) format = kSurroundingsFormat;
  for (const ColumnFacts& c : kColumns)
    if (!columns_of(model, c.kind).empty()) format = std::max(format, c.format);
  return format;
}

TimeCurve parse_time_curve(const NamedMeta& in) {
  if (!in.meta.count("time_curve")) return {};
  const std::string text = text_of(in, "time_curve");
  const std::size_t count = std::size_t(std::count(text.begin(), text.end(), ' ')) + 1;
  const std::vector<double> v = parse_exact<double>(text, count);
  bool ok = v.size() == count && count >= 4 && count % 2 == 0 && count <= 2 * TimeCurve::kMost;
  TimeCurve curve;
  for (std::size_t i = 0; ok && i < count; i += 2) {
    ok = v[i] >= (i ? v[i - 2] : 0.0) && v[i + 1] >= 0 && v[i + 1] <= 1;
    curve.knots.push_back({v[i], v[i + 1]});
  }
  if (!ok || v[0] != 0 || v[count - 2] != 1)
    bad(in, "time_curve",
        "pairs of time and parameter in [0, 1], times from 0 to 1 and none below the one before",
        quoted(in, "time_curve"));
  return curve;
}

FieldShape parse_shape(const NamedMeta& in, const std::vector<Column>& columns) {
  const std::vector<float> v = numbers<float>(in, "lattice", 7);
  FieldShape shape;
  shape.lattice.origin = {v[0], v[1], v[2]};
  shape.lattice.spacing = v[3];
  double table = 1;
  bool ok = v[3] > 0;
  for (int a = 0; a < 3; ++a) {
    const float n = v[std::size_t(4 + a)];
    ok = ok && n >= 2 && n <= float(kMostVertices) && n == std::floor(n);
    shape.lattice.size[a] = ok ? int(n) : 2;
    table *= n / kBrick + 3;
  }
  if (!ok || table > kMostBricks)
    bad(in, "lattice",
        "origin (3), spacing > 0, vertices per axis (3) from 2 to " + std::to_string(kMostVertices) +
            ", at most 2^25 bricks in all",
        quoted(in, "lattice"));
  const int least = padded_width(columns);
  shape.width = integer(in, "row_width", least, kMaxWidth);
  if (shape.width % 8 != 0) bad(in, "row_width", "a multiple of 8", std::to_string(shape.width));
  return shape;
}

}  // namespace

VdbMeta model_meta(const VoxelModel& m) {
  VdbMeta meta;
  meta["creator"] = std::string("splinevox");
  meta["splinevox_model"] = std::int64_t(format_of(m));
  meta["box"] = exact_text<float>({m.box.lo.x, m.box.lo.y, m.box.lo.z, m.box.hi.x, m.box.hi.y, m.box.hi.z});
  const Background& b = m.background;
  meta["background"] = exact_text<float>({b.color.x, b.color.y, b.color.z});
  if (b.learned()) {
    std::vector<float> raw;
    for (int j = 0; j < b.count(); ++j) raw.insert(raw.end(), {b.raw[j].x, b.raw[j].y, b.raw[j].z});
    meta["background_order"] = std::int64_t(b.order);
    meta["background_harmonics"] = exact_text(raw);
  }
  meta["march_step"] = exact_text<float>({m.step});
  meta["time_map"] = exact_text<double>({m.time_map.origin, m.time_map.scale});
  return meta;
}

VdbMeta radiance_meta(const RadianceField& radiance) {
  VdbMeta meta;
  put_shape(meta, radiance.raw);
  meta["activation"] = std::string(kActivations[0]);
  meta["activation_scale"] = exact_text<float>({radiance.activation.scale});
  meta["activation_shift"] = exact_text<float>({radiance.activation.shift});
  meta["sh_order"] = std::int64_t(radiance.sh_order);
  return meta;
}

VdbMeta surroundings_meta(const Surroundings& around) {
  VdbMeta meta;
  put_shape(meta, around.raw);
  const Box& b = around.box;
  meta["surrounds"] = exact_text<float>({b.lo.x, b.lo.y, b.lo.z, b.hi.x, b.hi.y, b.hi.z});
  meta["activation"] = std::string(kActivations[0]);
  meta["activation_scale"] = exact_text<float>({1.0f});
  meta["activation_shift"] = exact_text<float>({around.shift});
  return meta;
}

FieldShape parse_surroundings_meta(const NamedMeta& in, Surroundings& around) {
  const auto b = numbers<float>(in, "surrounds", 6);
  around.box = {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
  for (int a = 0; a < 3; ++a)
    if (!(b[std::size_t(a)] < b[std::size_t(a + 3)]))
      bad(in, "surrounds", "lo.xyz below hi.xyz", quoted(in, "surrounds"));
  around.shift = numbers<float>(in, "activation_shift", 1)[0];
  return parse_shape(in, surroundings_columns());
}

std::vector<Column> surroundings_columns() {
  std::vector<Column> columns;
  for (const ColumnKind kind : {ColumnKind::density, ColumnKind::color}) {
    const ColumnFacts& facts = facts_of(kind);
    Column c;
    c.kind = kind;
    c.grid = std::string("surroundings_") + facts.name;
    c.first = kind == ColumnKind::density ? 0 : 1;
    c.width = facts.width;
    c.activation = facts.activation;
    c.role = std::string("around the box, in contracted space: ") + facts.role;
    columns.push_back(std::move(c));
  }
  return columns;
}

VdbMeta motion_meta(const MotionField& motion) {
  VdbMeta meta;
  put_shape(meta, motion.levels[0]);
  meta["basis"] = std::string(basis_of(motion.basis).name);
  meta["points"] = std::int64_t(motion.points);
  meta["first_point"] = std::string(kFirstPoints[std::size_t(motion.first_point)]);
  for (const ColumnFacts& c : kColumns)
    if (c.of_motion() && c.unsaid != motion.*c.stored)
      meta[c.file_switch] = std::string(kSwitch[motion.*c.stored]);
  meta["rigidity_offset"] = exact_text<float>({motion.rigidity_offset});
  if (!motion.time_curve.identity()) {
    std::vector<double> numbers;
    for (const TimeCurve::Knot& k : motion.time_curve.knots) {
      numbers.push_back(k.time);
      numbers.push_back(k.value);
    }
    meta["time_curve"] = exact_text(numbers);
  }
  return meta;
}

void parse_model_meta(const NamedMeta& in, VoxelModel& m) {
  const auto at = in.meta.find("splinevox_model");
  if (at == in.meta.end())
    fail({.where = in.where,
          .what = "is a VDB file, but not a model of splinevox",
          .expected = "metadata 'splinevox_model'",
          .got = "none",
          .hint = "give the model.vdb of a run"});
  if (const auto* version = std::get_if<std::int64_t>(&at->second);
      version && (*version < kModelFormat || *version > kNewestFormat))
    fail({.where = in.where,
          .what = *version > kNewestFormat ? "was written by a newer version of splinevox"
                                           : "was written by an older version of splinevox",
          .expected = "model format " + std::to_string(kModelFormat) + " to " + std::to_string(kNewestFormat),
          .got = std::to_string(*version),
          .hint = *version > kNewestFormat ? "" : "train the scene again"});
  integer(in, "splinevox_model", kModelFormat, kNewestFormat);
  const auto box = numbers<float>(in, "box", 6);
  m.box = {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
  for (int a = 0; a < 3; ++a)
    if (!(m.box.lo[a] < m.box.hi[a])) bad(in, "box", "lo.xyz below hi.xyz", quoted(in, "box"));
  const auto color = numbers<float>(in, "background", 3);
  m.background = {.color = {color[0], color[1], color[2]}};
  if (in.meta.count("background_order")) {
    m.background.order = integer(in, "background_order", 0, kMaxShOrder);
    const auto raw = numbers<float>(in, "background_harmonics", 3 * std::size_t(m.background.count()));
    for (int j = 0; j < m.background.count(); ++j)
      m.background.raw[j] = {raw[3 * j], raw[3 * j + 1], raw[3 * j + 2]};
  }
  m.step = numbers<float>(in, "march_step", 1)[0];
  const double diagonal = length(cast<double>(m.box.hi) - cast<double>(m.box.lo));
  if (!(m.step > 0) || !(diagonal <= kMostSteps * double(m.step)))
    bad(in, "march_step", "a number > 0, and at most 2^20 steps through the box", quoted(in, "march_step"));
  const auto time = numbers<double>(in, "time_map", 2);
  m.time_map = {time[0], time[1]};
}

FieldShape parse_radiance_meta(const NamedMeta& in, RadianceField& radiance) {
  choice(in, "activation", kActivations);
  radiance.activation.scale = numbers<float>(in, "activation_scale", 1)[0];
  if (!(radiance.activation.scale > 0))
    bad(in, "activation_scale", "a number > 0", text_of(in, "activation_scale"));
  radiance.activation.shift = numbers<float>(in, "activation_shift", 1)[0];
  radiance.sh_order = integer(in, "sh_order", -1, kMaxShOrder);
  return parse_shape(in, radiance_columns(radiance));
}

FieldShape parse_motion_meta(const NamedMeta& in, MotionField& motion) {
  const Basis* const basis = find_basis(text_of(in, "basis"));
  if (!basis) bad(in, "basis", "one of: " + listed(basis_names()), quoted(in, "basis"));
  motion.basis = basis->kind;
  motion.points = integer(in, "points", kMinPoints, kMaxPoints);
  if (!basis->points.allows(motion.points))
    bad(in, "points", basis->points.text(), std::to_string(motion.points));
  motion.first_point = FirstPoint(choice(in, "first_point", kFirstPoints));
  if (!basis->pinnable && motion.first_point == FirstPoint::zero)
    bad(in, "first_point", "free for " + std::string(basis->name), quoted(in, "first_point"));
  motion.time_curve = parse_time_curve(in);
  for (const ColumnFacts& c : kColumns)
    if (c.of_motion())
      motion.*c.stored =
          c.unsaid && !in.meta.count(c.file_switch) ? *c.unsaid : choice(in, c.file_switch, kSwitch) == 1;
  if (!motion.displaces && (motion.rigidity || motion.stride() == 0))
    bad(in, "displacement_switch",
        "on, or off with light_switch or presence_switch on and rigidity_switch off",
        quoted(in, "displacement_switch"));
  if (motion.presence && motion.first_point == FirstPoint::zero)
    bad(in, "presence_switch", "off where first_point is zero", quoted(in, "presence_switch"));
  motion.rigidity_offset = numbers<float>(in, "rigidity_offset", 1)[0];
  // Without light the contraction of a row reads one float past its last control point.
  FieldShape shape = parse_shape(in, motion_columns(motion));
  if (shape.width <= motion.rigidity_column())
    bad(in, "row_width", "more than " + std::to_string(motion.rigidity_column()),
        std::to_string(shape.width));
  return shape;
}

}  // namespace splinevox
