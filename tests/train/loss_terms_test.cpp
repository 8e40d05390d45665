// SPDX-License-Identifier: Apache-2.0
#include "train/config/loss_terms.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>
#include <string>
#include <type_traits>

#include "splinevox/train/config_keys.hpp"
#include "train/start.hpp"

using namespace splinevox;

namespace {

/// Every weight 0.
LossConfig no_loss() {
  LossConfig loss;
  for (const LossTerm& term : kLossTerms) loss.*term.weight = 0;
  return loss;
}

}  // namespace

TEST_SUITE("train/loss_terms") {
  TEST_CASE("every weight of the configuration has one row, which names its member") {
    Config config;
    std::set<std::string> keys;
    visit_config(config, [&](const std::string& key, auto& member, const char*, double lo, double hi) {
      // A weight has no upper bound; what has one is a share.
      if constexpr (std::is_same_v<std::decay_t<decltype(member)>, float>) {
        if (key.rfind("loss.", 0) != 0 || lo != 0 || hi < 1e30) return;
        CAPTURE(key);
        keys.insert(key);
        const auto row = std::find_if(std::begin(kLossTerms), std::end(kLossTerms),
                                      [&](const LossTerm& term) { return term.key == key; });
        REQUIRE(row != std::end(kLossTerms));
        CHECK(&(config.loss.*row->weight) == &member);
      }
    });
    CHECK(keys.size() == std::size(kLossTerms));
  }

  TEST_CASE("a weight is scaled, guarded and off in trial fits as its row says") {
    for (const LossTerm& term : kLossTerms) {
      CAPTURE(term.key);
      Config config;
      config.loss = no_loss();
      config.loss.*term.weight = 3;
      const float powers[] = {1, 0.25f, 0.0625f};
      CHECK(in_units_of(0.25f, config).loss.*term.weight == 3 * powers[term.brightness]);
      CHECK(in_scene_units(config.loss, 4).*term.weight == 3 * powers[term.edges]);
      CHECK(for_trials(config.loss).*term.weight == (term.in_trials ? 3 : 0));
      CHECK_FALSE(can_spoil_gradients(config.loss));
      config.loss.*term.weight = 1e30f;
      CHECK(can_spoil_gradients(config.loss) == term.guarded);
    }
  }

  TEST_CASE("the fewer bricks a step visits, the larger a weight counts") {
    LossConfig loss = no_loss();
    loss.tv_color = 1e10f;
    loss.tv_share = 1;
    CHECK_FALSE(can_spoil_gradients(loss));
    loss.tv_share = 1e-3f;
    CHECK(can_spoil_gradients(loss));
  }
}
