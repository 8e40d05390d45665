// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace splinevox {

/// Calls work(i) for every i in [0, n) on the threads of the calling TBB arena, and finish(i) after it, one
/// at a time and in the order of i. At most `at_once` of them are begun and not finished, so that what they
/// hold in memory is bounded; a thread that waits inside one takes no part of another. Once finish returns
/// false nothing more is begun; what was begun is still worked and finished. After an exception from either
/// nothing more is begun or finished, what was begun is worked to its end, and it is rethrown here.
/// @param at_once  >= 1; 1 is a plain loop.
void in_order(int n, int at_once, const std::function<void(int i)>& work,
              const std::function<bool(int i)>& finish);

}  // namespace splinevox
