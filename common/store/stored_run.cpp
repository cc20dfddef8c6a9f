#include "common/store/stored_run.h"

#include <fmt/format.h>

#include <cstring>
#include <vector>

#include "common/store/checksum.h"
#include "common/store/run_store.h"

namespace sleight::store {
namespace {

template <class T>
void assign(std::vector<T>& values, base::BytesView bytes) {
  // A length that does not fit shows in the checksum.
  values.resize(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
}

}  // namespace

StoredRun::StoredRun(const std::string& folder, std::uint32_t chains, std::uint64_t scans)
    : database_(RunStore::database_path(folder), Access::read_only),
      chains_(chains),
      scans_(scans) {
  Statement identity = database_.prepare("SELECT value FROM run WHERE key='identity'");
  if (!identity.step()) refuse_damaged(database_.path(), "it has no identity");
  salt_ = salt_of(identity.text(0));
}

void StoredRun::for_each_scan(
    base::ChainId chain,
    const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const {
  Statement select = database_.prepare(
      "SELECT log_prior, log_constraint, satisfied, lineage, proposed, accepted, outcome, state, "
      "checksum "
      "FROM scan WHERE chain=?1 AND replica=0 AND scan<?2 ORDER BY scan");
  select.bind(1, std::int64_t{chain.value}).bind(2, static_cast<std::int64_t>(scans_));
  plan::ScanRecord record;
  std::uint64_t scan = 0;
  for (; select.step(); ++scan) {
    record.log_prior = select.real(0);
    record.log_constraint = select.real(1);
    record.satisfied = select.integer(2) != 0;
    record.lineage = static_cast<std::uint64_t>(select.integer(3));
    assign(record.proposed, select.blob(4));
    assign(record.accepted, select.blob(5));
    assign(record.outcome, select.blob(6));
    assign(record.state, select.blob(7));
    if (checksum_of(salt_, {chain, base::ReplicaId{0}}, scan, record) != select.integer(8)) {
      refuse_damaged(database_.path(), fmt::format("scan {} of chain {}", scan, chain.value));
    }
    visit(base::ScanIndex{scan}, record);
  }
  if (scan != scans_) {
    refuse_damaged(database_.path(),
                   fmt::format("scan {} of chain {} is missing", scan, chain.value));
  }
}

}  // namespace sleight::store
