// SPDX-License-Identifier: Apache-2.0
#include "run/volume_score.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>

#include "data/expect_error.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/field/sample.hpp"
#include "support/blob_model.hpp"
#include "support/numpy_file.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;
using namespace splinevox::test;
using namespace splinevox::run;

namespace {

/// What a truth is made of.
struct Made {
  double factor = 1;                           ///< of the model's density
  Vec3d shift{};                               ///< of where it is said to be
  std::vector<double> gains{1, 1, 1};          ///< further factors, one a moment
  int coarser = 1;                             ///< voxels of so many of the model's, each a mean
  std::vector<double> times{0.25, 0.5, 0.75};  ///< of the data; the model's time_map makes 0 to 0.75 of them
};

/// A model's own density as truth volumes: .npz files and truth.json.
void write_truth(const TempFolder& folder, const VoxelModel& model, const Made& made) {
  const Lattice& own = model.radiance.raw.topology->lattice;
  const int n = made.coarser;
  const double h = n * double(own.spacing);
  Int3 size{};
  for (int a = 0; a < 3; ++a) size[a] = (own.size[a] + n - 1) / n;
  const Vec3d first = cast<double>(own.origin) + 0.5 * (n - 1) * double(own.spacing) * Vec3d{1, 1, 1};
  const Vec3d origin = first + made.shift;
  std::string volumes;
  for (std::size_t k = 0; k < made.times.size(); ++k) {
    const FrameSampler sampler(model, model.time_map(made.times[k]));
    std::vector<float> values;
    for (int x = 0; x < size.x; ++x)
      for (int y = 0; y < size.y; ++y)
        for (int z = 0; z < size.z; ++z) {
          double sum = 0;
          for (int i = 0; i < n * n * n; ++i)
            sum +=
                double(sampler.density(own.position(n * Int3{x, y, z} + Int3{i / n / n, i / n % n, i % n})));
          values.push_back(float(made.factor * made.gains[k] * sum / (n * n * n)));
        }
    const std::string name = fmt::format("v{}.npz", k);
    const std::string shape = fmt::format("({}, {}, {})", size.x, size.y, size.z);
    write_text(folder.path() / name,
               npz({{"density.npy", numpy("<f4", shape, bytes_of(values))},
                    {"voxel.npy", numpy("<f8", "()", bytes_of(std::vector<double>{h}))},
                    {"origin.npy",
                     numpy("<f8", "(3,)", bytes_of(std::vector<double>{origin.x, origin.y, origin.z}))}},
                   k % 2 == 1));
    volumes += fmt::format(R"({}{{"file": "truth/{}", "time": {}}})", k ? ", " : "", name, made.times[k]);
  }
  write_text(folder.path() / "truth.json",
             fmt::format(R"({{"volumes": [{}], "voxel": {}, "shape": [{}, {}, {}], )"
                         R"("first_voxel_middle": [{}, {}, {}]}})",
                         volumes, h, size.x, size.y, size.z, origin.x, origin.y, origin.z));
}

VolumeScore score(const VoxelModel& model, const Made& made) {
  const TempFolder folder;
  write_truth(folder, model, made);
  return score_volumes(model, open_truth_volumes(folder.str(), model.time_map));
}

}  // namespace

TEST_SUITE("app/volume_score") {
  const VoxelModel model = blob_model(24);

  TEST_CASE("a truth that is the model itself: no error, correlation 1, the same mass at every moment") {
    const VolumeScore s = score(model, {});
    CHECK(s.scale == doctest::Approx(1).epsilon(1e-5));
    CHECK(s.l1 < 1e-3);  // what an export leaves out is not in the model's figure
    CHECK(s.l1_unscaled < 1e-3);
    CHECK(s.correlation > 0.99999);
    CHECK(s.correlation_per_moment > 0.99999);
    CHECK(s.iou > 0.999);
    CHECK(s.mass_curve < 1e-3);
    CHECK(s.outside == doctest::Approx(0));
    CHECK(s.samples == 1);
    REQUIRE(s.moments.size() == 3);
    CHECK(s.moments[1].time == doctest::Approx(0.375));
    for (const run::VolumeMoment& m : s.moments) {
      CHECK(m.mass == doctest::Approx(m.mass_truth).epsilon(1e-3));
      CHECK(m.l1 < 1e-3);
    }
  }

  TEST_CASE("a truth of half the density: scale 0.5, L1 0 after it and 1 without") {
    const VolumeScore s = score(model, {.factor = 0.5});
    CHECK(s.scale == doctest::Approx(0.5).epsilon(1e-4));
    CHECK(s.l1 < 1e-3);
    CHECK(s.l1_unscaled == doctest::Approx(1).epsilon(1e-3));
    CHECK(s.mass_curve < 1e-3);
    CHECK(s.mass_unscaled == doctest::Approx(1).epsilon(1e-3));
  }

  TEST_CASE("a truth beside by one voxel has an error, the more the farther, and the same mass") {
    const auto beside = [&](double voxels) {
      return score(model, {.shift = {voxels * double(model.radiance.raw.topology->lattice.spacing), 0, 0}});
    };
    const VolumeScore one = beside(1), two = beside(2);
    CHECK(one.l1 > 0.05);
    CHECK(two.l1 > one.l1);
    CHECK(one.correlation < 0.99);
    CHECK(two.correlation < one.correlation);
    CHECK(two.iou < one.iou);
    CHECK(one.mass_unscaled < 1e-3);
  }

  TEST_CASE("a truth whose mass doubles for a moment: the error of the course of mass is known") {
    const VolumeScore s = score(model, {.gains = {1, 2, 1}});
    // Of 1, 2, 1 the shares are 3/4, 3/2, 3/4; the model's are nearly 1 each: it only moves.
    CHECK(s.mass_curve == doctest::Approx(1.0 / 3).epsilon(0.03));
    CHECK(s.moments[1].correlation > 0.9999);
  }

  TEST_CASE("a moment without matter has no figures, and counts for none") {
    const VolumeScore s = score(model, {.gains = {0, 1, 1}});
    CHECK(std::isnan(s.moments[0].correlation));
    CHECK(std::isnan(s.moments[0].l1));
    CHECK(s.moments[1].correlation > 0.9999);
    CHECK(s.correlation_per_moment > 0.9999);
  }

  TEST_CASE("a truth of coarser voxels is compared with the model's mean over each") {
    const VolumeScore s = score(model, {.coarser = 2});
    CHECK(s.samples == 2);
    CHECK(s.l1 < 1e-3);
    CHECK(s.correlation > 0.9999);
    CHECK(s.scale == doctest::Approx(1).epsilon(1e-4));
  }

  TEST_CASE("a truth of another time is another volume") {
    CHECK(score(model, {.times = {0.25, 0.3, 0.35}}).l1 < 1e-3);
    const TempFolder folder;
    write_truth(folder, model, {});
    VoxelModel late = model;
    late.time_map.origin -= 0.1;
    CHECK(score_volumes(late, open_truth_volumes(folder.str(), late.time_map)).l1 > 0.05);
  }

  TEST_CASE("volumes without truth.json are taken evenly over time, which a note says") {
    const TempFolder folder;
    write_truth(folder, model, {.times = {0.25, 0.25 + 0.5 / 1.5, 0.25 + 1 / 1.5}});
    std::filesystem::remove(folder.path() / "truth.json");
    const TruthVolumes truth = open_truth_volumes(folder.str(), model.time_map);
    REQUIRE(truth.moments.size() == 3);
    CHECK(truth.moments[1].time == 0.5);
    REQUIRE(truth.notes.size() == 1);
    CHECK(truth.notes[0].find("evenly") != std::string::npos);
    CHECK(score_volumes(model, truth).l1 < 1e-3);
    // By numbers as people count them: without padding 10 comes after 9.
    const char* numbers[] = {"s.9.npz", "s.10.npz", "s.11.npz"};
    for (std::size_t i = 0; i < 3; ++i)
      std::filesystem::rename(truth.moments[i].file, folder.path() / numbers[i]);
    const TruthVolumes counted = open_truth_volumes(folder.str(), model.time_map);
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(std::filesystem::path(counted.moments[i].file).filename().string() == numbers[i]);
  }

  TEST_CASE("synth's own volumes come back voxel by voxel, also as a sequence alone") {
    const TempFolder folder;
    const std::string path = folder.str() + "/truth_volume";
    const SynthScene scene = SynthScene::open("smoke");
    write_truth_volumes(path, scene, {0, 0.5, 1});
    const TruthVolumes truth = open_truth_volumes(path, {});
    REQUIRE(truth.moments.size() == 3);
    const SynthMoment moment = scene.at(0.5);
    CHECK(truth.size == moment.gas()->size);
    CHECK(read_truth_volume(truth, 1) == moment.gas()->density);
    std::filesystem::remove(path + "/truth.json");
    const TruthVolumes alone = open_truth_volumes(path, {});
    const std::vector<float> values = read_truth_volume(alone, 1);
    double all = 0, had = 0;
    for (const float v : values) all += double(v);
    for (const float v : moment.gas()->density) had += double(v);
    CHECK(all == doctest::Approx(had));
  }

  TEST_CASE("errors name what is wrong with a truth") {
    const TempFolder folder;
    const std::string path = folder.str();
    const auto opened = [&] { open_truth_volumes(path, model.time_map); };
    expect_error([&] { open_truth_volumes(path + "/none", {}); }, {"there is no such folder", "none"});
    expect_error(opened, {"there are no truth volumes in this folder"});
    write_truth(folder, model, {});
    const auto scored = [&] { score_volumes(model, open_truth_volumes(path, model.time_map)); };
    CHECK_NOTHROW(scored());
    expect_error([&] { open_truth_volumes(path, {0, 3}); }, {"'time'", "within the run's time", "0.5"});
    const TruthVolumes part = open_truth_volumes(path, {0, 3}, true);
    CHECK(part.moments.size() == 1);
    CHECK(part.notes.back() == "1 of 3 true volumes lie in the run's part of the time");
    expect_error([&] { open_truth_volumes(path, {5, 3}, true); }, {"'time'", "within the run's time"});
    std::filesystem::remove(folder.path() / "v1.npz");
    expect_error(opened, {"a volume is not there", "v1.npz"});
    write_text(folder.path() / "v1.npz", "PK and no more");
    expect_error(scored, {"v1.npz", "damaged"});
    write_text(folder.path() / "v1.npz",
               npz({{"voxel.npy", numpy("<f8", "()", std::string(8, '\0'))}}, false));
    expect_error(scored, {"there is no array 'density' in it", "voxel"});
    write_text(folder.path() / "truth.json", "{\"voxel\": 1}");
    expect_error(opened, {"'shape' is absent or wrong"});

    const TempFolder away;
    write_truth(away, model, {.shift = {100, 0, 0}});
    expect_error([&] { score_volumes(model, open_truth_volumes(away.str(), model.time_map)); },
                 {"beside the model's box"});
    const TempFolder empty;
    write_truth(empty, model, {.factor = 0});
    expect_error([&] { score_volumes(model, open_truth_volumes(empty.str(), model.time_map)); },
                 {"there is no matter in the truth volumes"});
    const TempFolder other;
    VdbFile file;
    file.grids.emplace_back().name = "heat";
    write_vdb(other.str() + "/a.vdb", file);
    expect_error([&] { open_truth_volumes(other.str(), {}); }, {"there is no grid 'density' in it", "heat"});
  }
}
