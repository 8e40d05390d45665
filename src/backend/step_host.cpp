// SPDX-License-Identifier: Apache-2.0
#include "backend/executor_host.hpp"
#include "backend/peers_host.hpp"
#include "backend/step_impl.hpp"

namespace splinevox {

std::unique_ptr<StepBackend> make_host_step(bool deterministic, Ranks* ranks) {
  return std::make_unique<Steps<HostExecutor, HostPeers>>(deterministic, ranks);
}

}  // namespace splinevox
