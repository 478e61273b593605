// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lodestar::math {

/// Where a group of states lies in a state vector. Layouts are constants with a static_assert on
/// their total, so that no bare index is ever written:
///
///     inline constexpr Block kAttitude{0, 3};
///     inline constexpr Block kGyroBias = after(kAttitude, 3);
///     static_assert(end(kGyroBias) == kStates);
///     x.segment<kAttitude.size>(kAttitude.offset)
struct Block {
  int offset;
  int size;
};

constexpr int end(Block block) { return block.offset + block.size; }

constexpr Block after(Block previous, int size) { return Block{end(previous), size}; }

}  // namespace lodestar::math
