#include "clients/gallery_server/secret_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "clients/web/keys.h"
#include "common/base/descriptor.h"
#include "common/base/own_folder.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;

bool is_secret(std::string_view text) {
  return text.size() == web::k_secret_digits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

/// Returns the file's secret, or "" if the file isn't ours or others can read it.
std::string secret_in(const fs::path& path) {
  const base::Descriptor file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  struct stat about {};
  if (file.get() < 0 || ::fstat(file.get(), &about) != 0) return {};
  const bool is_ours = S_ISREG(about.st_mode) && about.st_uid == ::geteuid() &&
                       (about.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  if (!is_ours) return {};
  std::string text(web::k_secret_digits, '\0');
  if (::read(file.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) return {};
  return is_secret(text) ? text : std::string();
}

}  // namespace

std::string kept_secret(std::uint16_t port) {
  const auto folder = base::own_folder("XDG_STATE_HOME", ".local/state", "gallery");
  if (!folder) return {};
  const fs::path path = *folder / fmt::format("{}.secret", port);
  if (std::string kept = secret_in(path); !kept.empty()) return kept;
  std::error_code failure;
  fs::create_directories(*folder, failure);
  fs::remove(path, failure);
  const std::string secret = web::new_secret();
  const base::Descriptor file(::open(
      path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR));
  const bool is_kept = file.get() >= 0 && ::write(file.get(), secret.data(), secret.size()) ==
                                              static_cast<ssize_t>(secret.size());
  return is_kept ? secret : std::string();
}

}  // namespace sleight::gallery
