// SPDX-License-Identifier: Apache-2.0
#include "backend/executor_host.hpp"
#include "backend/march_impl.hpp"

namespace splinevox {

template void run_march<HostExecutor, -1>(HostExecutor&, const MarchJob&);
template void run_march<HostExecutor, 0>(HostExecutor&, const MarchJob&);
template void run_march<HostExecutor, 1>(HostExecutor&, const MarchJob&);
template void run_march<HostExecutor, 2>(HostExecutor&, const MarchJob&);
template void run_march<HostExecutor, 3>(HostExecutor&, const MarchJob&);

}  // namespace splinevox
