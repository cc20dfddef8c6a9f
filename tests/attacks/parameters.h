// Parameters of the service's calls: structurally valid, with any values. Thread safety: functions
// change only their Dice.
#pragma once

#include <capnp/any.h>

#include <cstddef>
#include <cstdint>

#include "tests/attacks/odd_values.h"

namespace sleight::attack {

/// Limits of message contents.
struct Bounds {
  /// Maximum size of a text. The maximum size of a message is roughly the same.
  std::size_t text_bytes_max = 1U << 20U;
  /// Whether the attacker is the service's own user, who may do anything. Such an attacker sends no
  /// message that would stop the service, create tokens or change jobs.
  bool is_owner = false;
};

/// Method numbers of service.capnp.
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
