// SPDX-License-Identifier: Apache-2.0
#include "backend/march_impl.hpp"
#include "splinevox/backend/executor_host.hpp"

namespace splinevox {

template void run_march<HostExecutor, -1>(HostExecutor&, const MarchJob&);
template void run_march<HostExecutor, 0>(HostExecutor&, const MarchJob&);
template void run_march<HostExecutor, 1>(HostExecutor&, const MarchJob&);
template void run_march<HostExecutor, 2>(HostExecutor&, const MarchJob&);
template void run_march<HostExecutor, 3>(HostExecutor&, const MarchJob&);

}  // namespace splinevox
