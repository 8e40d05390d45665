// SPDX-License-Identifier: Apache-2.0
#include "live/server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "core/system.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

constexpr const char* kHost = "127.0.0.1";
constexpr std::size_t kThreads = 4;         // one page asks, now and then two
constexpr int kLastRequests = 20;           // tenths of a second that requests have when the page ends
constexpr int kLastAnswers = 600;           // and answers, such as the last model by a tunnel
constexpr std::size_t kLongestBody = 1024;  // of a request: none has one

std::string random_token() {
  std::array<std::uint8_t, 16> bytes{};
  if (!fill_random(bytes.data(), bytes.size()))
    fail({"--live", "the system has no random numbers, so anybody could guess the page's address", "", "",
          ""});
  std::string text;
  for (const std::uint8_t b : bytes) text += fmt::format("{:02x}", b);
  return text;
}

/// Whether a text is 127.0.0.1 or localhost, with a port or without: behind a tunnel it is another one.
bool is_here(std::string host) {
  if (const std::size_t colon = host.find(':'); colon != host.npos) {
    if (host.find_first_not_of("0123456789", colon + 1) != host.npos) return false;
    host.resize(colon);
  }
  return host == kHost || host == "localhost";
}

bool may_come(const httplib::Request& request) {
  if (!is_here(request.get_header_value("Host"))) return false;
  constexpr const char* kScheme = "http://";
  const std::string origin = request.get_header_value("Origin");
  return origin.empty() || (origin.starts_with(kScheme) && is_here(origin.substr(std::strlen(kScheme))));
}

/// Why a port cannot be had, as the system says.
std::string why_not(int port) {
  const int probe = ::socket(AF_INET, SOCK_STREAM, 0);
  ::fcntl(probe, F_SETFD, FD_CLOEXEC);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(std::uint16_t(port));
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool bound = ::bind(probe, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0;
  const int code = errno;
  ::close(probe);
  return bound ? "" : std::strerror(code);
}

/// The library would share a port with whoever else listens there: two runs at one address.
void alone(socket_t socket) {
  const int yes = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

/// Ends what connections to the port are still open. The library waits for each to be through with its
/// request, and whoever sends one slowly would keep a training from ending.
void hang_up(int port) {
  const int most = int(std::clamp(::sysconf(_SC_OPEN_MAX), 256L, 65536L));
  for (int fd = 3; fd < most; ++fd) {
    sockaddr_in own{}, other{};
    socklen_t own_size = sizeof own, other_size = sizeof other;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&own), &own_size) == 0 && own.sin_family == AF_INET &&
        ntohs(own.sin_port) == port &&
        ::getpeername(fd, reinterpret_cast<sockaddr*>(&other), &other_size) == 0)
      ::shutdown(fd, SHUT_RDWR);
  }
}

}  // namespace

struct PageServer::Impl {
  httplib::Server server;
  std::string token = random_token(), address;
  int port = 0;
  std::atomic<bool> ended = false;
  std::atomic<int> sending = 0;  ///< answers on their way
  std::thread listening;
};

PageServer::PageServer(int port, std::function<Answer(const Ask&)> answer) : impl_(std::make_unique<Impl>()) {
  httplib::Server& server = impl_->server;
  const std::string root = "/" + impl_->token + "/";
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server.set_socket_options(alone);
  server.set_payload_max_length(kLongestBody);
  server.set_keep_alive_max_count(1);  // else every open page would hold threads
  server.set_default_headers({{"Cache-Control", "no-store"},
                              {"Referrer-Policy", "no-referrer"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"Cross-Origin-Resource-Policy", "same-origin"},
                              {"Content-Security-Policy",
                               "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                               "img-src 'self' data:; connect-src 'self'; frame-ancestors 'none'"}});
  server.set_pre_routing_handler([root](const httplib::Request& request, httplib::Response& response) {
    if (may_come(request) && request.path.starts_with(root))
      return httplib::Server::HandlerResponse::Unhandled;
    response.status = 403;
    return httplib::Server::HandlerResponse::Handled;
  });
  const auto handle = [root, answer = std::move(answer), sending = &impl_->sending](
                          const httplib::Request& request, httplib::Response& response) {
    const Answer said = answer({request.method == "POST", request.path.substr(root.size()),
                                [&](const std::string& name) { return request.get_param_value(name); }});
    response.status = said.status;
    if (said.body->empty()) return;
    ++*sending;
    // By a provider, because a body as such would be compressed, which takes longer than it saves here.
    response.set_content_provider(
        said.body->size(), said.type,
        [body = said.body](std::size_t at, std::size_t size, httplib::DataSink& to) {
          return to.write(body->data() + at, size);
        },
        [sending](bool) { --*sending; });
  };
  server.Get(".*", handle);
  // With a reader that is not used: no action has a body, and none is waited for.
  server.Post(".*", [handle](const httplib::Request& request, httplib::Response& response,
                             const httplib::ContentReader&) { handle(request, response); });
  if (port == 0)
    port = server.bind_to_any_port(kHost);
  else if (!server.bind_to_port(kHost, port))
    fail({"--live", fmt::format("port {} cannot be had on {}", port, kHost),
          "a port that is free; without one --live takes any", why_not(port), "--live without a port"});
  if (port < 0) fail({"--live", fmt::format("there is no port to be had on {}", kHost), "", why_not(0), ""});
  impl_->port = port;
  impl_->address = fmt::format("http://{}:{}{}", kHost, port, root);
  impl_->listening = std::thread([impl = impl_.get()] {
    impl->server.listen_after_bind();
    impl->ended = true;
  });
}

PageServer::~PageServer() {
  while (!impl_->server.is_running() && !impl_->ended)  // what has not begun cannot be stopped
    std::this_thread::yield();
  impl_->server.stop();
  for (int waited = 0; !impl_->ended; ++waited) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (waited >= (impl_->sending > 0 ? kLastAnswers : kLastRequests)) hang_up(impl_->port);
  }
  impl_->listening.join();
}

const std::string& PageServer::address() const { return impl_->address; }

}  // namespace splinevox::run
