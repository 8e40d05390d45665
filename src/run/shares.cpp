// SPDX-License-Identifier: Apache-2.0
#include "run/shares.hpp"

#include <cmath>
#include <cstdlib>
#include <utility>

#include "run/support.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {

Share chosen_share(const std::string& text) {
  if (text.empty()) return launched_share();
  const char* expected = "K/N, whole numbers, 1 <= K <= N";
  const std::vector<double> v = numbers(text, '/', "--share", expected);
  if (v.size() != 2 || v[0] != std::floor(v[0]) || v[1] != std::floor(v[1]) || v[0] < 1 || v[0] > v[1] ||
      v[1] > 1e6)
    fail({"--share", "this is not a share", expected, text, "--share 1/4 is the first of four"});
  return {int(v[0]) - 1, int(v[1])};
}

Share launched_share() {
  for (const auto& [rank, count] :
       {std::pair{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"}, {"PMI_RANK", "PMI_SIZE"}}) {
    const char *r = std::getenv(rank), *n = std::getenv(count);
    if (r && n && std::atoi(n) > 1) return {std::atoi(r), std::atoi(n)};
  }
  return {};
}

}  // namespace splinevox::run
