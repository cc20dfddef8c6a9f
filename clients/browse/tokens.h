// The words, numbers and signs of a query's text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clients/browse/query.h"
#include "common/base/result.h"

namespace sleight::browse {

struct Token {
  enum class Kind : std::uint8_t {
    word,    ///< letters, digits and _, beginning with a letter
    quoted,  ///< a name in double quotes; \" and \\ stand for the signs
    number,
    sign,  ///< ( ) : , [ ] .. < <= > >= =
    end
  };
  Kind kind = Kind::end;
  std::size_t column = 0;
  std::string text{};  ///< of a quoted one what is between the quotes
  double number = 0;   ///< of a number
  /// Directly behind the one before: the unit in "20mm".
  bool is_joined = false;
};

/// The tokens, with one of Kind::end behind them.
base::Result<std::vector<Token>, QueryError> tokens_of(std::string_view text);

}  // namespace sleight::browse
