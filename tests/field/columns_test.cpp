// SPDX-License-Identifier: Apache-2.0
#include "field/columns.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "field/lattice/level_kernels.hpp"
#include "field/lattice/slice.hpp"
#include "splinevox/field/sample.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;

namespace {

/// Motions of every make-up that a model can have, without rows.
std::vector<MotionField> motions() {
  std::vector<MotionField> out;
  for (const bool displaces : {false, true})
    for (const bool rigidity : {false, true})
      for (const bool light : {false, true})
        for (const bool presence : {false, true})
          for (const FirstPoint first : {FirstPoint::zero, FirstPoint::free}) {
            if (displaces ? false : rigidity || !(light || presence)) continue;
            MotionField& m = out.emplace_back();
            m.points = 6;
            m.first_point = first;
            m.displaces = displaces;
            m.rigidity = rigidity;
            m.light = light;
            m.presence = presence;
          }
  return out;
}

/// Columns that are taken, in order of their place: each number once.
std::vector<int> places(const std::vector<Column>& columns) {
  std::multiset<int> taken;
  for (const Column& c : columns)
    for (int a = 0; a < c.width; ++a) taken.insert(c.first + a);
  return {taken.begin(), taken.end()};
}

std::vector<int> up_to(std::size_t n) {
  std::vector<int> out(n);
  for (std::size_t i = 0; i < n; ++i) out[i] = int(i);
  return out;
}

/// One brick of rows that are 0 but for one column, which is 1 in all.
Channels one_column(int width, int column) {
  const Box box{{0, 0, 0}, {1, 1, 1}};
  Channels rows = make_channels(make_dense_topology(make_lattice(box, 7)), width,
                                std::vector<float>(std::size_t(width), 0.0f).data());
  for (std::size_t r = kBrickRows; r < rows.topology->rows(); ++r) rows.row(r)[column] = 1;
  return rows;
}

}  // namespace

TEST_SUITE("field/columns") {
  TEST_CASE("every column has all its facts, and no two share a name, a view, a place or a switch") {
    std::set<std::string> names, arrays, switches;
    std::set<int> lanes;
    for (const ColumnFacts& c : kColumns) {
      CAPTURE(c.name);
      for (const char* text : {c.name, c.array, c.activation, c.role, c.about}) {
        REQUIRE(text);
        CHECK(std::string(text).size() > 1);
      }
      CHECK((c.width == 1 || c.width == 3));
      CHECK(std::isfinite(c.first));
      CHECK(c.format >= 2);
      CHECK(&facts_of(c.kind) == &c);
      CHECK(names.insert(c.name).second);
      CHECK(arrays.insert(c.array).second);
      // What Python calls an array begins with what the file calls its grids.
      CHECK(std::string(c.array).starts_with(c.name));
      CHECK(c.of_motion() == (c.slice >= 0));
      CHECK(c.of_motion() == (c.file_switch != nullptr));
      if (!c.of_motion()) continue;
      CHECK(switches.insert(c.file_switch).second);
      for (int a = 0; a < c.width; ++a) {
        CHECK(c.slice + a < kSliceWidth);
        CHECK(lanes.insert(c.slice + a).second);
      }
    }
  }

  TEST_CASE("columns cover a row from its first float on, each once, and padding follows") {
    for (int order = -1; order <= 3; ++order) {
      RadianceField radiance;
      radiance.sh_order = order;
      const std::vector<int> taken = places(radiance_columns(radiance));
      CHECK(taken == up_to(taken.size()));
      CHECK(int(taken.size()) == 4 + radiance.sh_count());
      CHECK(padded_width(radiance_columns(radiance)) == radiance_width(order));
    }
    for (const MotionField& m : motions()) {
      CAPTURE(m.displaces);
      CAPTURE(m.rigidity);
      CAPTURE(m.light);
      const std::vector<int> taken = places(motion_columns(m));
      CHECK(taken == up_to(taken.size()));
      CHECK(int(taken.size()) == m.rigidity_column() + m.rigidity);
      CHECK(m.width() % 8 == 0);
      CHECK(m.width() > m.rigidity_column());  // a register reads one float past the last point
      CHECK(m.width() <= widest_motion(m.points));
      const MotionLayout layout(m);
      for (const Column& c : motion_columns(m))
        if (is_scalar(facts_of(c.kind)))
          CHECK(c.first % layout.stride == layout.scalar[scalar_index(c.kind)]);
    }
  }

  TEST_CASE("what is sampled of a canonical volume is what the table says of its columns") {
    VoxelModel model;
    model.radiance.sh_order = 2;
    model.radiance.activation = {2, 1};
    const auto sampled = [&](int column) {
      model.radiance.raw = one_column(radiance_width(2), column);
      return FrameSampler(model, 0).radiance({0.4f, 0.5f, 0.6f});
    };
    const FrameSampler::Radiance none = sampled(radiance_width(2) - 1);  // padding
    int harmonic = 0;
    for (const Column& c : radiance_columns(model.radiance))
      for (int a = 0; a < c.width; ++a) {
        CAPTURE(c.grid);
        const FrameSampler::Radiance found = sampled(c.first + a);
        CHECK((found.density != none.density) == (c.kind == ColumnKind::density));
        for (int b = 0; b < 3; ++b)
          CHECK((found.color[b] != none.color[b]) == (c.kind == ColumnKind::color && a == b));
        for (int j = 0; j < 9; ++j) CHECK((found.sh[j] != 0) == (c.kind == ColumnKind::sh && j == harmonic));
        harmonic += c.kind == ColumnKind::sh;
      }
    CHECK(harmonic == 9);
  }

  TEST_CASE("both contractions and their adjoints take each column to its place in a slice and back") {
    for (MotionField m : motions()) {
      m.basis = BasisKind::bezier;
      const MotionLayout layout(m);
      const BasisWeights<float> w = stored_weights(m, 0.4), mean = mean_weights(m);
      for (const Column& c : motion_columns(m))
        for (int a = 0; a < c.width; ++a) {
          CAPTURE(c.grid);
          const ColumnFacts& facts = facts_of(c.kind);
          const int point = facts.repeat == Repeat::point ? c.first / layout.stride : -1;
          const auto weight = [&](int k) {
            return w[std::size_t(k)] - (c.kind == ColumnKind::presence ? mean[std::size_t(k)] : 0);
          };
          const float share = point < 0 ? 1 : weight(point);
          m.levels = {one_column(m.width(), c.first + a)};
          const std::size_t rows = m.levels[0].topology->rows();
          std::vector<float> expected(kSliceWidth, 0.0f);
          expected[std::size_t(facts.slice + a)] = share;

          const MotionSlice slice = make_slice(m, w);
          std::vector<float> other(rows * kSliceWidth, 0.0f);
          const std::vector<std::uint64_t> all(rows / 64, ~std::uint64_t(0));
          const SlotWeights slot{w, 0, m.stored_points()};
          const float* const centred = m.presence ? mean.data() : nullptr;
          const int points = m.stored_points();
          const ContractKernel contract{
              layout, m.levels[0].values.data(), all.data(), &slot, centred, points, 1, rows, other.data()};
          contract(kBrickRows);
          for (int k = 0; k < kSliceWidth; ++k) {
            CHECK(slice.values[std::size_t(kBrickRows) * kSliceWidth + k] == expected[std::size_t(k)]);
            CHECK(other[std::size_t(kBrickRows) * kSliceWidth + k] == expected[std::size_t(k)]);
          }

          // A gradient of 1 at that place of the slice reaches the column times its weight, and those of the
          // same curve theirs.
          AlignedVector<float> back(std::size_t(kBrickRows) * kSliceWidth, 0.0f);
          back[std::size_t(facts.slice + a)] = 1;
          std::vector<float> again(rows * kSliceWidth, 0.0f), from_kernel(rows * m.width(), 0.0f);
          again[std::size_t(kBrickRows) * kSliceWidth + std::size_t(facts.slice + a)] = 1;
          Channels gradient = one_column(m.width(), 0);
          std::fill(gradient.values.begin(), gradient.values.end(), 0.0f);
          expand_brick(m, w, RowMask::all(), back.data(), 1, gradient);
          const bool whole = points == m.points;  // weights of all points sum to 1
          if (whole) centre_brick(m, RowMask::all(), 1, gradient);
          const ExpandKernel expand{layout, all.data(), all.data(), &slot,        centred,
                                    points, 1,          rows,       again.data(), from_kernel.data()};
          expand(kBrickRows);
          for (int k = 0; k < m.width(); ++k) {
            const bool same =
                point < 0 ? k == c.first
                          : k < layout.rigidity_column && k % layout.stride == (c.first + a) % layout.stride;
            const float wanted = !same ? 0 : point < 0 ? 1 : weight(k / layout.stride);
            CHECK(from_kernel[std::size_t(kBrickRows) * m.width() + std::size_t(k)] == wanted);
            if (whole || c.kind != ColumnKind::presence)
              CHECK(gradient.row(kBrickRows)[k] == doctest::Approx(wanted).epsilon(1e-6));
          }
        }
    }
  }

  TEST_CASE("columns of a kind are all of it that a model has") {
    const VoxelModel model = test::noisy_model(1, 5, FirstPoint::free, BasisKind::bspline, 1, true, true);
    const auto grids = [&](ColumnKind kind) {
      std::vector<std::string> out;
      for (const Column& c : columns_of(model, kind)) out.push_back(c.grid);
      return out;
    };
    CHECK(grids(ColumnKind::density) == std::vector<std::string>{"density"});
    CHECK(grids(ColumnKind::sh) == std::vector<std::string>{"sh0", "sh1", "sh2", "sh3"});
    CHECK(grids(ColumnKind::rigidity) == std::vector<std::string>{"rigidity"});
    CHECK(grids(ColumnKind::light) ==
          std::vector<std::string>{"light_0", "light_1", "light_2", "light_3", "light_4"});
    const VoxelModel still = test::blob_model(16, {.moves = false}, -1);
    for (const ColumnFacts& c : kColumns)
      CHECK(columns_of(still, c.kind).empty() == (c.of_motion() || c.kind == ColumnKind::sh));
  }
}
