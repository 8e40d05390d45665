// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace splinevox {

/// Calls call.operator()<Sh>() for a harmonic order (-1..3) known only at run time.
template <class Call>
auto specialise(int sh_order, Call&& call) {
  switch (sh_order) {
    case -1:
      return call.template operator()<-1>();
    case 0:
      return call.template operator()<0>();
    case 1:
      return call.template operator()<1>();
    case 2:
      return call.template operator()<2>();
    default:
      return call.template operator()<3>();
  }
}

/// The same with whether anything changes over time, call.operator()<Sh, Moving>(): ray kernels are compiled
/// for each, so that what a scene does not call for is in no loop.
template <class Call>
auto specialise(int sh_order, bool moving, Call&& call) {
  return specialise(sh_order, [&]<int Sh>() {
    return moving ? call.template operator()<Sh, true>() : call.template operator()<Sh, false>();
  });
}

}  // namespace splinevox
