// SPDX-License-Identifier: Apache-2.0
// The live page of a training, asked as a page asks it.
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <optional>
#include <thread>

#include "live/live_page.hpp"
#include "live_run.hpp"
#include "view/codec.hpp"

using namespace splinevox;
using namespace splinevox::test;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

/// A run that ends when it is told to.
std::vector<std::string> endless(const BallScene& scene, std::vector<std::string> more = {}) {
  more.insert(more.end(), {"--max-time", "600", "--set", "effects.steps=0", "--live"});
  std::vector<std::string> words = scene.train("run", "1", more);
  const auto steps = std::find(words.begin(), words.end(), "--max-steps");
  words.erase(steps, steps + 2);
  return words;
}

Json header_of(const std::string& model) {
  std::size_t length = 0;
  for (int i = 3; i >= 0; --i) length = length << 8 | std::uint8_t(model[std::size_t(i)]);
  REQUIRE(model.size() > 4 + length);
  Json header = Json::parse(model.substr(4, length));
  header["bytes"] = model.size() - 4 - length;
  return header;
}

std::vector<Json> metrics_lines(const std::string& run) {
  std::vector<Json> out;
  std::stringstream in(slurp(run + "/metrics.jsonl"));
  for (std::string line; std::getline(in, line);) out.push_back(Json::parse(line));
  return out;
}

/// The lines that say what was done by the page.
std::vector<std::string> done_by_page(const std::string& run) {
  std::vector<std::string> out;
  for (const Json& line : metrics_lines(run))
    if (line.contains("live")) out.push_back(line["live"]);
  return out;
}

}  // namespace

TEST_SUITE("app/live") {
  TEST_CASE("who has no token, or comes by another name, is sent away and stops nothing") {
    const BallScene scene;
    LiveRun run(endless(scene));
    REQUIRE(comes([&] { return run.trains(); }));
    httplib::Client c = run.client();
    const std::string other(run.root.size() - 2, '0');
    for (const std::string& path : {std::string("/"), std::string("/state"), "/" + other + "/",
                                    "/" + other + "/state", run.root.substr(0, run.root.size() - 1)}) {
      CAPTURE(path);
      CHECK(c.Get(path)->status == 403);
      CHECK(c.Post(path)->status == 403);
    }
    CHECK(c.Post("/stop")->status == 403);
    const auto named = [&](const char* header, const std::string& value) {
      const httplib::Headers headers{{header, value}};
      CAPTURE(value);
      CHECK(c.Get(run.root + "state", headers)->status == 403);
      CHECK(c.Post(run.root + "stop", headers)->status == 403);
      CHECK(c.Put(run.root + "stop", headers, "", "text/plain")->status == 403);
    };
    for (const char* host :
         {"evil.example", "evil.example:80", "127.0.0.1.evil.example", "localhost:evil", "10.0.0.1"})
      named("Host", host);
    for (const char* origin : {"http://evil.example", "https://127.0.0.1", "null"}) named("Origin", origin);
    CHECK(c.Get(run.root, {{"Host", "localhost:9999"}})->status == 200);  // as behind a tunnel
    for (const char* action : {"stop", "pause", "go", "more"}) CHECK(run.get(action)->status == 404);
    CHECK(run.get("preview/../config.toml")->status == 404);
    CHECK(run.get("preview/step_..%2f..%2fconfig.png")->status == 404);
    const double before = run.steps();
    CHECK(comes([&] { return run.steps() > before; }));
    CHECK(run.state()["paused"] == false);
    const httplib::Result page = run.get("");
    CHECK(contains(page->get_header_value("Content-Security-Policy"), "default-src 'none'"));
    CHECK(page->get_header_value("Referrer-Policy") == "no-referrer");
    CHECK(run.post("stop") == 200);
    CHECK(run.wait().code == 130);
  }

  TEST_CASE("a stop while effects are tried out counts after the fit, and nothing is saved") {
    const TempFolder temp;
    const std::string data = temp.str() + "/ball", out = temp.str() + "/run";
    write_moving_ball(data, {24, 0, 2, 12, 0.8});
    LiveRun run({"train", data, "--out", out, "--preset", "draft", "--max-steps", "100000", "--set",
                 "effects.steps=400", "--set", "sampling.rays=128", "--live"});
    REQUIRE(comes([&] { return contains(run.state().dump(), "trying out"); }));
    CHECK(run.post("stop") == 200);
    const Ended e = run.wait();
    CAPTURE(e.err);
    CHECK(e.code == 130);
    CHECK(contains(e.err, "interrupted before the first step; nothing is saved"));
    CHECK_FALSE(fs::exists(out));
  }

  TEST_CASE("a pause holds the run and its clock, the model can be read, more time is kept, and stop saves") {
    const BallScene scene;
    LiveRun run(endless(scene));
    REQUIRE(comes([&] { return run.trains(); }));
    CHECK(run.post("pause") == 200);
    REQUIRE(comes([&] { return done_by_page(scene.path("run")).size() == 1; }));
    const Json held = run.state();
    CHECK(held["paused"] == true);
    CHECK(held["about"]["effects"]["used"].contains("motion"));

    REQUIRE(comes([&] { return run.state("?follow=1")["model"] == held["lines"].back()["step"]; }));
    const std::string model = run.get("model")->body;
    const Json header = header_of(model);
    CHECK(header["step_of_training"] == held["lines"].back()["step"]);
    CHECK(header["views"].size() == 2);  // those of the split val
    const Json& density = header["radiance"]["columns"][0]["plane"];
    const std::size_t count = density["count"], at = model.size() - header["bytes"].get<std::size_t>();
    CHECK(count == 512 * header["radiance"]["bricks"].get<std::size_t>());
    const auto* bytes =
        reinterpret_cast<const std::uint8_t*>(model.data()) + at + density["offset"].get<std::size_t>();
    const std::vector<std::uint16_t> values = run::read_plane({bytes, 2 * count}, count, density["bits"]);
    CHECK(*std::max_element(values.begin(), values.end()) > 0);

    CHECK(run.post("more?seconds=90") == 200);
    for (const char* wrong :
         {"more", "more?seconds=x", "more?seconds=-5", "more?seconds=1e9", "more?seconds=nan"})
      CHECK(run.post(wrong) == 400);
    CHECK(run.post("dance") == 404);
    REQUIRE(comes([&] { return run.state()["max_time"] == 690; }));
    CHECK(contains(slurp(scene.path("run") + "/config.toml"), "max_time = 690"));
    CHECK(run.steps() == held["lines"].back()["step"].get<double>());
    CHECK(run.post("go") == 200);
    CHECK(comes([&] { return run.steps() > held["lines"].back()["step"].get<double>(); }));

    CHECK(run.post("stop") == 200);
    CHECK(comes([&] { return run.state()["phase"] == "saved"; }));
    const Ended e = run.wait();
    CAPTURE(e.err);
    CHECK(e.code == 130);
    CHECK(contains(e.err, "live page: pause at step"));
    CHECK(done_by_page(scene.path("run")) == std::vector<std::string>{"pause", "more time", "go on", "stop"});
    double paused = 0, went = 0;
    for (const Json& line : metrics_lines(scene.path("run"))) {
      if (line.value("live", "") == "go on") paused = line["paused_seconds"];
      went = line["seconds"];
    }
    const Json figures = Json::parse(slurp(scene.path("run") + "/metrics.json"));
    CHECK(figures["ended"] == "page");
    CHECK(went >= held["lines"].back()["seconds"].get<double>());
    CHECK(paused > 0);
    CHECK(program({"verify", scene.path("run")}).code == 0);
    // It goes on with the time that it was given.
    std::vector<std::string> same = endless(scene);
    same.push_back("--resume");
    for (const auto& on :
         {std::vector<std::string>{"train", scene.data, "--out", scene.path("run"), "--resume", "--live"},
          same}) {
      LiveRun again(on);
      REQUIRE(comes([&] { return again.trains(); }));
      CHECK(again.state()["max_time"] == 690);
      CHECK(again.steps() >= figures["steps"].get<double>());
      CHECK(again.post("stop") == 200);
      CHECK(again.wait().code == 130);
    }
  }

  TEST_CASE("whoever sends a request and does not end it keeps no training from ending") {
    const BallScene scene;
    LiveRun run(endless(scene));
    REQUIRE(comes([&] { return run.trains(); }));
    const int slow = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(std::uint16_t(run.port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::connect(slow, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
    const std::string begin = "GET / HTTP/1.1\r\nX: ";
    REQUIRE(::send(slow, begin.data(), begin.size(), MSG_NOSIGNAL) == ssize_t(begin.size()));
    std::atomic<bool> ended = false;
    std::thread drips([&] {  // more often than the server's patience with silence
      while (!ended && ::send(slow, "x", 1, MSG_NOSIGNAL) == 1)
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
    });
    CHECK(run.post("stop") == 200);
    CHECK(run.wait().code == 130);
    ended = true;
    drips.join();
    ::close(slow);
  }

  TEST_CASE("what is wished for after the last step is refused") {
    run::LivePage page(0, "run");
    run::Watcher& watcher = page;
    const std::string start = "http://127.0.0.1:", address = page.address();
    const std::size_t slash = address.find('/', start.size());
    httplib::Client c("127.0.0.1", std::stoi(address.substr(start.size(), slash - start.size())));
    const std::string root = address.substr(slash);
    CHECK(watcher.close(false));
    for (const char* wish : {"pause", "stop", "more?seconds=60"}) {
      const httplib::Result r = c.Post(root + wish);
      REQUIRE(r);
      CHECK(r->status == 409);
    }
    CHECK(Json::parse(c.Get(root + "state")->body)["phase"] == "saving");
  }

  TEST_CASE("a page that looks on changes no bit; a run that counts steps is given no time") {
    const BallScene scene;
    REQUIRE(program(scene.train("alone", "300", {"--quiet"})).code == 0);
    LiveRun run(scene.train("watched", "300", {"--quiet", "--live"}));
    REQUIRE(comes([&] { return run.state("?follow=1").value("model", 0.0) > 0 && run.trains(); }));
    CHECK(run.post("more?seconds=60") == 409);
    std::optional<double> first;  // of the models that were got
    double shown = -1;
    CHECK(comes([&] {
      const Json state = run.state("?follow=1");
      if (state.empty()) return true;
      if (state["model"].get<double>() > shown) {
        const httplib::Result model = run.get("model");
        if (model && model->status == 200 && !first) first = state["model"].get<double>();
      }
      shown = std::max(shown, state["model"].get<double>());
      return state["phase"] == "finished" && state["model"] == 300;
    }));
    CHECK(run.wait().code == 0);
    REQUIRE(first);
    CHECK(*first < 300);
    CHECK(slurp(scene.path("watched") + "/model.vdb") == slurp(scene.path("alone") + "/model.vdb"));
    CHECK(done_by_page(scene.path("watched")).empty());
  }

  TEST_CASE("ports that cannot be had are refused by name, and nothing is left behind") {
    const BallScene scene;
    LiveRun run(endless(scene));
    const Ended taken = program(scene.train("other", "5", {"--live", std::to_string(run.port)}));
    CHECK(taken.code == 2);
    CHECK(contains(taken.err, "--live: port " + std::to_string(run.port) + " cannot be had"));
    CHECK(contains(taken.err, "Address already in use"));
    for (const char* port : {"70000", "0", "-1", "80x"}) {
      const Ended e = program(scene.train("other", "5", {std::string("--live=") + port}));
      CAPTURE(e.err);
      CHECK(e.code == 2);
      CHECK(contains(e.err, "--live: this is no port"));
    }
    CHECK_FALSE(std::filesystem::exists(scene.path("other")));
    LiveRun beside(scene.train("beside", "20", {"--live"}));  // each takes a port of its own
    CHECK(beside.port != run.port);
    CHECK(beside.root != run.root);
    CHECK(beside.wait().code == 0);
    CHECK(run.post("stop") == 200);
    CHECK(run.wait().code == 130);
    // The word behind --live may be the data set.
    LiveRun natural({"train", "--live", scene.data, "--out", scene.path("natural"), "--preset", "draft",
                     "--max-steps", "5", "--quiet", "--set", "grid.radiance=8,12,16", "--set",
                     "motion.points=4"});
    CHECK(natural.wait().code == 0);
  }
}
