// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

/// A server for one page and one user: loopback only, behind an address that nobody can guess.
namespace splinevox::run {

/// A request that was let in.
struct Ask {
  bool post = false;
  std::string path;                                      ///< behind the token: "", "state"
  std::function<std::string(const std::string&)> value;  ///< of a name behind the "?"; "" if it has none
};

struct Answer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::shared_ptr<const std::string> body = std::make_shared<const std::string>();
};

/// Serves http://127.0.0.1:PORT/TOKEN/ from threads of its own while it lives. The token has 128 random bits.
/// Requests without it, or whose Host or Origin is not 127.0.0.1 or localhost, get 403: a web page that is
/// open elsewhere in the browser knows no token, and cannot borrow our address by a name of its own.
class PageServer {
 public:
  /// @param port    0: a free one
  /// @param answer  called from any thread, from several at a time
  /// Throws Error (input) naming --live where the port cannot be had, or this build has no server.
  PageServer(int port, std::function<Answer(const Ask&)> answer);
  ~PageServer();

  const std::string& address() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace splinevox::run
