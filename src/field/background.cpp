// SPDX-License-Identifier: Apache-2.0
#include "math/background_color.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

// Not in the header: whoever called it would compile it with flags of their own, and the linker may take
// that one for training too, with other last bits.
Vec3 Background::towards(const Vec3& direction) const {
  return learned() ? background_color(order, raw, direction).value : color;
}

}  // namespace splinevox
