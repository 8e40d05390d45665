// SPDX-License-Identifier: Apache-2.0
// What people write by hand: settings, camera paths, tables of points.
#include "fuzz/seeds.hpp"
#include "fuzz/targets.hpp"
#include "run/points_csv.hpp"
#include "splinevox/run/cameras.hpp"
#include "support/tiny_dataset.hpp"

namespace splinevox::fuzz {

int config_toml(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("config.toml", data, size);
  return verdict([&] {
    Config config;
    read_config(config, path);
    validate(config);
  });
}

std::vector<std::string> config_seeds() {
  return {write_config(preset("draft")),
          "# caf\xC3\xA9\npreset = \"paper\"\n[loss]\noffset = 1e-3\n[grid]\nradiance = [40, "
          "64]\nradiance_start = [0, 0.5]\n"};
}

int camera_path(const std::uint8_t* data, std::size_t size) {
  static const run::Run run;
  run::CameraRequest request;
  request.camera = put("path.json", data, size);
  return verdict([&] { run::plan_shots(run, request); });
}

std::vector<std::string> camera_seeds() {
  const std::string matrix = test::matrix_text(test::orbit_matrix(0.4));
  const std::vector<std::string> frames = {
      test::frame_text("a", "0.25", matrix),
      "{\"w\": 64, \"h\": 48, \"fl_x\": 50.5, \"transform_matrix\": " + matrix + "}"};
  return {test::transforms_text(frames),
          test::transforms_text({frames[0]}, "\"fl_x\": 300, \"cx\": 12.5, \"w\": 640, \"h\": 480,")};
}

int points_csv(const std::uint8_t* data, std::size_t size) {
  const std::string path = put("points.csv", data, size);
  return verdict([&] { run::read_points(path); });
}

std::vector<std::string> points_seeds() {
  return {"x,y,z\n0.1,-0.2,3e-1\n1,2,3\n",
          "# marks\nid, time ,x,y,z,note\r\na,0.5,1,2,3,hello\r\n\r\nb,1e-3,-1,+2,3.25,\r\n",
          "z,y,x,time\n1,2,3,1\n"};
}

}  // namespace splinevox::fuzz
