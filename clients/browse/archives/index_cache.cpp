#include "clients/browse/archives/index_cache.h"

#include <utility>

#include "clients/browse/index_bytes.h"
#include "common/base/cores.h"
#include "common/base/version.h"

namespace sleight::browse {
namespace {

bool is_worth_keeping(const browse::Index& index) {
  std::size_t pieces = 0;
  for (const browse::Entry& entry : index.entries)
    pieces += entry.pieces.size();
  return pieces >= k_pieces_worth_keeping;
}

}  // namespace

std::optional<KeptIndex> kept_index(const std::string& archive) {
  const auto bytes = cached(archive, k_index_ending);
  if (!bytes) return std::nullopt;
  auto index = browse::index_of(bytes->content(), base::cores_here());
  if (!index) return std::nullopt;
  return KeptIndex{.index = *std::move(index), .of = bytes->of};
}

void keep_index(const std::string& archive, const FileState& of, const browse::Index& index) {
  if (is_worth_keeping(index)) keep_cached(archive, k_index_ending, of, browse::bytes_of(index));
}

std::optional<browse::Outline> kept_outline(const std::string& archive, const FileState& of) {
  const auto bytes = cached(archive, k_outline_ending);
  if (!bytes || !(bytes->of == of)) return std::nullopt;
  return browse::outline_of_bytes(bytes->content(), base::version());
}

void keep_outline(const std::string& archive, const FileState& of, const browse::Index& index,
                  const browse::Groups& groups) {
  if (!is_worth_keeping(index)) return;
  keep_cached(archive, k_outline_ending, of,
              browse::bytes_of(browse::outline_of(index, groups), base::version()));
}

}  // namespace sleight::browse
