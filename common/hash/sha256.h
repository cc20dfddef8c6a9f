// SHA-256 (OpenSSL) of content that arrives in pieces. Run identities and archive digests use it.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace sleight::hash {

/// Movable, not copyable. Not thread-safe.
class Sha256 {
 public:
  using Value = std::array<std::byte, 32>;

  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void update(std::span<const std::byte> bytes);
  void update(std::string_view text);
  /// REQUIRES: the function was not called before on this object.
  Value finish();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

Sha256::Value sha256_of(std::span<const std::byte> bytes);

/// Returns 64 lower-case hexadecimal digits.
std::string to_hex(const Sha256::Value& value);

/// Returns the hexadecimal SHA-256 of a text.
std::string sha256_hex(std::string_view text);

}  // namespace sleight::hash
