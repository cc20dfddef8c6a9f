// In-memory archive: a Sink that can be read back as a Source.
//
// Use it only for small archives, because it stores every value in memory. Not thread-safe.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive {

class MemoryArchive final : public Sink, public Source {
 public:
  MemoryArchive();

  void create_group(std::string_view group) override;
  void set_attribute(std::string_view group, const Attribute& attribute) override;
  DatasetHandle create_dataset(std::string_view group, const DatasetSpec& spec) override;
  void append(DatasetHandle dataset, const ValuesView& values) override;
  void finish() override;

  std::string name() const override { return "archive in memory"; }
  const std::vector<Group>& groups() const override { return groups_; }
  Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
              std::uint64_t count) const override;

  /// Returns a mutable reference, so that a test can store values that a real writer never stores.
  Values& values(std::string_view group, std::string_view dataset);
  Group& group(std::string_view name);

 private:
  struct Place {
    std::string group;
    std::string dataset;
  };
  std::vector<Group> groups_;
  std::vector<Place> places_;             ///< by handle
  std::map<std::string, Values> values_;  ///< by path
};

}  // namespace sleight::archive
