// Splits a query's text into words, numbers and signs.
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
    quoted,  ///< a name in double quotes, with \" and \\ as escapes
    number,
    sign,  ///< ( ) : , [ ] .. < <= > >= =
    end
  };
  Kind kind = Kind::end;
  std::size_t column = 0;
  std::string text{};  ///< a quoted name without its quotes
  double number = 0;   ///< value of a number
  /// Whether no space precedes the token, as for the unit in "20mm".
  bool is_joined = false;
};

/// Returns the tokens, followed by one of Kind::end.
base::Result<std::vector<Token>, QueryError> tokens_of(std::string_view text);

}  // namespace sleight::browse
