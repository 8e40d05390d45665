// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <doctest/doctest.h>
#include <httplib.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "ball_scene.hpp"

namespace splinevox::test {

/// A training with its live page.
class LiveRun {
 public:
  using Json = nlohmann::ordered_json;

  /// @param words  of `splinevox`, with --live
  explicit LiveRun(std::vector<std::string> words) : program_(with_program(std::move(words))) {
    const std::string start = "http://127.0.0.1:";
    REQUIRE(comes([&] {
      const std::string said = program_.err();
      const std::size_t at = said.find(start), end = said.find('\n', at);
      if (at == said.npos || end == said.npos) return false;
      address = said.substr(at, end - at);
      return true;
    }));
    const std::size_t slash = address.find('/', start.size());
    port = std::stoi(address.substr(start.size(), slash - start.size()));
    root = address.substr(slash);
  }

  httplib::Client client() const {
    httplib::Client c("127.0.0.1", port);
    c.set_read_timeout(60);
    return c;
  }
  httplib::Result get(const std::string& path) const { return client().Get(root + path); }
  /// The status of an action's answer.
  int post(const std::string& path) const {
    const httplib::Result r = client().Post(root + path);
    return r ? r->status : -1;
  }
  Json state(const std::string& query = "") const {
    const httplib::Result r = get("state" + query);
    return r && r->status == 200 ? Json::parse(r->body) : Json::object();
  }
  /// Steps that were made, by the lines.
  double steps() const {
    const Json lines = state().value("lines", Json::array());
    return lines.empty() ? 0 : lines.back().value("step", 0.0);
  }
  bool trains() const { return state().value("phase", "") == "training" && steps() > 0; }
  Ended wait() { return program_.wait(); }

  std::string address, root;
  int port = 0;

 private:
  static std::vector<std::string> with_program(std::vector<std::string> words) {
    words.insert(words.begin(), SPLINEVOX_PROGRAM);
    return words;
  }
  Started program_;
};

}  // namespace splinevox::test
