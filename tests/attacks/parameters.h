// Parameters of the service's calls: of the right shape, with any values.
//
// Thread safety: pure functions of their Dice.
#pragma once

#include <capnp/any.h>

#include <cstddef>
#include <cstdint>

#include "tests/attacks/odd_values.h"

namespace sleight::attack {

/// What messages may hold.
struct Bounds {
  /// A text's, and so about a message's.
  std::size_t text_bytes_max = 1U << 20U;
  /// The service is the attacker's own, who may do anything: messages that would stop it, make
  /// tokens or touch its jobs are left out.
  bool is_owner = false;
};

/// As service.capnp numbers them.
enum Method : std::uint16_t {
  submit,
  list,
  status,
  watch,
  logs,
  fetch = 12,  // 5 to 11 are retired
  info,
  drain,
  stop,
  create_token,
  list_tokens,
  revoke_token,
  change
};
inline constexpr std::uint16_t k_methods = 20;

void fill_parameters(Dice& dice, const Bounds& bounds, Method method,
                     capnp::AnyPointer::Builder to);

}  // namespace sleight::attack
