// SPDX-License-Identifier: Apache-2.0
#include "run/points_csv.hpp"

#include <doctest/doctest.h>

#include <fstream>

#include "splinevox/core/error.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;
using namespace splinevox::run;
using namespace splinevox::test;

TEST_SUITE("app/points") {
  TEST_CASE("columns in any order, others ignored, spaces, empty lines and remarks passed over") {
    const TempFolder folder;
    const std::string path = folder.str() + "/p.csv";
    std::ofstream(path) << "\xEF\xBB\xBF# made by hand\nname, z ,x,y,time,id\r\n\nball,3,1,2,0.25,a "
                           "1\r\nball, -3e-1 ,1.5,-2,1,b";
    const PointTable t = read_points(path);
    REQUIRE(t.position.size() == 2);
    CHECK(t.position[0] == Vec3{1, 2, 3});
    CHECK(t.position[1] == Vec3{1.5f, -2, -0.3f});
    CHECK(t.time == std::vector<double>{0.25, 1});
    CHECK(t.id == std::vector<std::string>{"a 1", "b"});
  }
  TEST_CASE("what is wrong is named with its line") {
    const TempFolder folder;
    const std::string path = folder.str() + "/p.csv";
    struct Row {
      const char *text, *says;
    };
    for (const Row& row : {Row{"", "not one point"},
                           {"x,y,z\n", "not one point"},
                           {"1,2,3\n", "does not name the columns"},
                           {"x,y\n1,2\n", "does not name the columns"},
                           {"x,y,z,x\n1,2,3,4\n", "two columns 'x'"},
                           {"x,y,z\n1,2\n", "line 2: there are too few fields"},
                           {"x,y,z\n1,2,3\n1,2,three\n", "line 3: 'z' is not a number"},
                           {"x,y,z\n1,nan,3\n", "'y' is not a number"},
                           {"x,y,z\n1,1e999,3\n", "'y' is not a number"},
                           {"x,y,z\n1,,3\n", "'y' is not a number"},
                           {"x,y,z,time\n1,2,3,1.5\n", "line 2: there is no such time"}}) {
      std::ofstream(path) << row.text;
      CHECK_THROWS_WITH_AS(read_points(path), doctest::Contains(row.says), Error);
    }
    CHECK_THROWS_WITH_AS(read_points(folder.str() + "/none.csv"), doctest::Contains("could not be read"),
                         Error);
  }
}
