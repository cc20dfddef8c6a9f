// An archive's content, whatever its file format: groups that have attributes and datasets.
//
// A Sink receives an archive in one pass. A Source returns the parts of an archive. HDF5 files
// (archive/hdf5) and archives in memory (tests/archive) implement both interfaces, so the layout,
// the digest, the checks and the CSV export are written and tested without files.
//
// Invariants of a finished archive, checked by DigestingSink during writing:
//  1. The root group is "/"; every other group is "/name", directly below the root. Group and
//     dataset names are unique and are plain words (format.h).
//  2. Every dimension of a dataset has a coordinate. The coordinate is a dataset of the same group.
//     Its name is the dimension's name, and its only dimension is this one. So a dimension's name
//     has one size within a group.
//  3. Values are in row-major order. A dataset has exactly as many elements as its dimensions
//     require. While the archive is being written, the first dimension may have an open size
//     (k_growing).
//  4. Text contains no NUL character and has at most text_bytes bytes.
//
// Not thread-safe: only one thread at a time may use a Sink or Source.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/archive/world_layout.h"

namespace sleight::archive {

enum class ElementType : std::uint8_t { f64, i64, i32, boolean, text };

/// Returns "f64", "i64", "i32", "bool" or "text", as in the digest's manifest.
std::string_view name_of(ElementType type);

/// Elements in memory. The alternatives follow the order of ElementType. A boolean is one byte: 0
/// or 1 in our own data, and any value in a file.
using Values =
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::int32_t>,
                 std::vector<std::int8_t>, std::vector<std::string>>;
using ValuesView = std::variant<std::span<const double>, std::span<const std::int64_t>,
                                std::span<const std::int32_t>, std::span<const std::int8_t>,
                                std::span<const std::string>>;

ElementType type_of(const ValuesView& values);
std::size_t count_of(const ValuesView& values);
ValuesView view_of(const Values& values);

struct Attribute {
  std::string name;
  std::variant<std::int64_t, double, std::string> value;
  friend bool operator==(const Attribute&, const Attribute&) = default;
};

/// Size of a first dimension that is unknown until the archive is finished.
inline constexpr std::size_t k_growing = std::numeric_limits<std::size_t>::max();

struct DatasetSpec {
  std::string name{};
  ElementType type = ElementType::f64;
  std::vector<Dimension> dims{};  ///< empty for a scalar
  std::vector<Attribute> attributes{};
  std::size_t text_bytes = 0;  ///< only for text: size of the longest element
};

struct Group {
  std::string name{};  ///< such as "/" or "/posterior"
  std::vector<Attribute> attributes{};
  std::vector<DatasetSpec> datasets{};  ///< no dimension is k_growing once finished
};

/// Returns the product of the dimensions. REQUIRES: no k_growing dimension, and no overflow.
std::uint64_t element_count(const DatasetSpec& spec);

/// Returns a dataset's path, such as "/posterior/draw". Example for the root group: "/request".
std::string path_of(std::string_view group, std::string_view dataset);

/// Returns whether a dataset, a dimension, an attribute, or a group after its '/' may have this
/// name (format.h).
bool is_plain_name(std::string_view name);

const Attribute* find_attribute(const std::vector<Attribute>& attributes, std::string_view name);
const DatasetSpec* find_dataset(const Group& group, std::string_view name);

/// Receives an archive. Functions throw base::Error if the medium fails (a full disk). Afterwards
/// the archive is lost and the sink may only be destroyed.
class Sink {
 public:
  /// Datasets are numbered 0, 1, ... in order of creation, over all groups.
  using DatasetHandle = std::size_t;

  virtual ~Sink() = default;
  /// REQUIRES: a new name "/word". The root group always exists.
  virtual void create_group(std::string_view group) = 0;
  /// REQUIRES: the group exists and lacks this attribute.
  virtual void set_attribute(std::string_view group, const Attribute& attribute) = 0;
  /// REQUIRES: the group exists, and the invariants hold.
  virtual DatasetHandle create_dataset(std::string_view group, const DatasetSpec& spec) = 0;
  /// Appends elements in row-major order. REQUIRES: the elements fit the dataset's type and size.
  virtual void append(DatasetHandle dataset, const ValuesView& values) = 0;
  /// Ends the archive. REQUIRES: every dataset is complete, and no call follows.
  virtual void finish() = 0;
};

/// Returns an archive's content. Functions throw base::Error(bad_archive) if the data are damaged.
class Source {
 public:
  virtual ~Source() = default;
  /// Returns the file's path, for messages.
  virtual std::string name() const = 0;
  /// Returns all groups, root first. Datasets are in order of creation if that order is known.
  virtual const std::vector<Group>& groups() const = 0;
  /// Returns elements first .. first+count-1 of a dataset, in row-major order. REQUIRES: the
  /// dataset exists and contains the range.
  virtual Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
                      std::uint64_t count) const = 0;
};

const Group* find_group(const Source& source, std::string_view name);

/// Throws base::Error with ExitCode::bad_archive, the source's name and the reason.
[[noreturn]] void refuse_archive(const Source& source, const std::string& reason);

}  // namespace sleight::archive
