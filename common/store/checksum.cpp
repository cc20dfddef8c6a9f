#include "common/store/checksum.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <span>

#include "common/base/error.h"
#include "common/store/damage.h"

namespace sleight::store {
namespace {

/// Collects fields, and hashes all of them together.
class Checksum {
 public:
  template <class T>
  void add(T value) {
    bytes(base::bytes_of(std::span<const T>(&value, 1)));
  }
  /// Adds the length before the elements. So the checksum changes if an element moves to a
  /// neighbouring array.
  void array(base::BytesView values) {
    add(std::uint64_t{values.size()});
    bytes(values);
  }
  std::int64_t value() const {
    return static_cast<std::int64_t>(XXH3_64bits(gathered_.data(), gathered_.size()));
  }

 private:
  void bytes(base::BytesView values) {
    gathered_.append(reinterpret_cast<const char*>(values.data()), values.size());
  }
  std::string gathered_;
};

}  // namespace

std::uint64_t salt_of(std::string_view identity_text) {
  return XXH3_64bits(identity_text.data(), identity_text.size());
}

std::int64_t checksum_of(std::uint64_t salt, const plan::ReplicaKey& replica, std::uint64_t scan,
                         const plan::ScanRecord& record) {
  Checksum sum;
  sum.add(salt);
  sum.add(replica.chain.value);
  sum.add(replica.replica.value);
  sum.add(scan);
  sum.add(record.log_prior);
  sum.add(record.log_constraint);
  sum.add(std::uint8_t{record.satisfied});
  sum.add(record.lineage);
  sum.add(record.inverse_temperature);
  sum.array(base::bytes_of(std::span(record.proposed)));
  sum.array(base::bytes_of(std::span(record.accepted)));
  sum.array(base::bytes_of(std::span(record.outcome)));
  sum.array(base::bytes_of(std::span<const std::uint64_t>(record.failures.by_kind)));
  sum.add(record.overlapping_starts);
  sum.array(base::bytes_of(std::span(record.method_values)));
  sum.array(record.state);
  return sum.value();
}

std::int64_t checksum_of(std::uint64_t salt, const plan::ReplicaKey& replica,
                         std::uint64_t next_scan, base::BytesView state) {
  Checksum sum;
  sum.add(salt);
  sum.add(replica.chain.value);
  sum.add(replica.replica.value);
  sum.add(next_scan);
  sum.array(state);
  return sum.value();
}

std::int64_t checksum_of(const SessionKey& session, std::string_view program_version,
                         std::uint64_t scans_before, std::string_view end) {
  Checksum sum;
  sum.add(session.salt);
  sum.add(session.epoch);
  sum.array(base::bytes_of(std::span<const char>(program_version)));
  sum.add(scans_before);
  sum.array(base::bytes_of(std::span<const char>(end)));
  return sum.value();
}

std::int64_t checksum_of_event(std::uint64_t salt, std::uint64_t number, std::string_view line) {
  Checksum sum;
  sum.add(salt);
  sum.add(number);
  sum.array(base::bytes_of(std::span<const char>(line)));
  return sum.value();
}

std::int64_t checksum_of(std::uint64_t salt, const ToldFrontier& told) {
  Checksum sum;
  sum.add(salt);
  for (const std::uint64_t count :
       {told.scans, told.starts, told.solutions, told.finds, told.failures})
    sum.add(count);
  return sum.value();
}

std::int64_t checksum_of_motion(std::uint64_t salt, base::BytesView state, std::int64_t ends,
                                std::uint64_t columns, base::BytesView numbers) {
  Checksum sum;
  sum.add(salt);
  sum.array(state);
  sum.add(ends);
  sum.add(columns);
  sum.array(numbers);
  return sum.value();
}

std::int64_t checksum_of_text(std::string_view place, std::string_view text) {
  Checksum sum;
  sum.array(base::bytes_of(std::span<const char>(place)));
  sum.array(base::bytes_of(std::span<const char>(text)));
  return sum.value();
}

void refuse_damaged(const std::string& path, const std::string& what) {
  throw base::Error(
      fmt::format("{}{}{}; restore the file from a backup, or start over with --fresh", path,
                  k_damaged_words, what));
}

}  // namespace sleight::store
