// The exact source version of this build, for `--version`, run stores and archives.
#pragma once

#include <string_view>

namespace sleight::base {

/// Returns `release+g<commit>`. If the source tree was changed, `.dirty.<hash>` follows. Outside
/// git, returns `release+src.<hash>` (deploy/version). Builds with equal versions give the same
/// bits for the same request.
std::string_view version();

}  // namespace sleight::base
