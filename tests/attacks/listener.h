// Parses a server's messages on a connection, to find which calls the server has answered, and how.
// Thread safety: one thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_set>

namespace sleight::attack {

class Listener {
 public:
  /// Receives bytes in pieces of any size.
  void hear(std::string_view bytes);

  bool has_answered(std::uint32_t question) const { return answered_.contains(question); }
  /// Whether the server has sent results for the question. A refusal is a result too.
  bool has_results(std::uint32_t question) const { return resulted_.contains(question); }
  std::uint64_t messages() const { return messages_; }
  std::uint64_t exceptions() const { return exceptions_; }
  std::uint64_t aborts() const { return aborts_; }
  /// Refusals of kind `bug`: the server failed during a call.
  std::uint64_t bugs() const { return bugs_; }
  /// Whether invalid frames arrived.
  bool is_garbled() const { return is_garbled_; }

 private:
  void hear_message(std::string_view frame);

  std::string pending_{};
  std::unordered_set<std::uint32_t> answered_{};
  std::unordered_set<std::uint32_t> resulted_{};
  std::uint64_t messages_ = 0;
  std::uint64_t exceptions_ = 0;
  std::uint64_t aborts_ = 0;
  std::uint64_t bugs_ = 0;
  bool is_garbled_ = false;
};

}  // namespace sleight::attack
