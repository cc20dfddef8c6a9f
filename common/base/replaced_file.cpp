#include "common/base/replaced_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/base/descriptor.h"
#include "common/base/error.h"

namespace sleight::base {

void replace_text_file(FileSystem& files, const std::string& path, std::string_view text,
                       Readers readers) {
  const std::string beside = path + ".new";
  if (readers == Readers::owner) {
    static_cast<void>(::unlink(beside.c_str()));
    const Descriptor made(
        ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (!made) {
      throw Error(
          fmt::format("{}: can't create: {}", beside, std::system_category().message(errno)));
    }
  }
  write_text_file(files, beside, text);
  files.sync_file(beside);
  files.rename(beside, path);
  files.sync_directory_of(path);
}

}  // namespace sleight::base
