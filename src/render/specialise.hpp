// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace splinevox {

/// Calls call.operator()<Sh, Moving>() for a harmonic order (-1..3) and whether anything changes over time,
/// known only at run time: the ray kernels are compiled for each, so that what a scene does not call for is
/// in no loop.
template <class Call>
auto specialise(int sh_order, bool moving, Call&& call) {
  const auto for_order = [&]<bool Moving>() {
    switch (sh_order) {
      case -1:
        return call.template operator()<-1, Moving>();
      case 0:
        return call.template operator()<0, Moving>();
      case 1:
        return call.template operator()<1, Moving>();
      case 2:
        return call.template operator()<2, Moving>();
      default:
        return call.template operator()<3, Moving>();
    }
  };
  return moving ? for_order.template operator()<true>() : for_order.template operator()<false>();
}

}  // namespace splinevox
