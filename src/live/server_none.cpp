// SPDX-License-Identifier: Apache-2.0
// In builds without cpp-httplib.
#include "live/server.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {

struct PageServer::Impl {
  std::string address;
};

PageServer::PageServer(int, std::function<Answer(const Ask&)>) {
  fail({"--live", "this build has no live page", "a build with cpp-httplib", "",
        "apt-get install libcpp-httplib-dev, and build anew"});
}
PageServer::~PageServer() = default;
const std::string& PageServer::address() const { return impl_->address; }

}  // namespace splinevox::run
