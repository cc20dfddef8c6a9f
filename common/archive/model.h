// What an archive consists of, free of any file format: groups that hold attributes and datasets.
//
// A Sink takes an archive in one pass, a Source gives one back. The HDF5 files (archive/hdf5) and
// an archive in memory (tests/archive) stand behind the same two interfaces, so the layout, the
// digest, the checks and the CSV export are written and tested without files.
//
// Invariants of a finished archive, which DigestingSink checks while one is written:
//  1. The root group is "/"; every other group is "/name", directly below it. Group and dataset
//     names are unique and are plain words (format.h).
//  2. Every dimension of a dataset has a coordinate: a dataset of the same name in the same group
//     whose only dimension is itself. So one name has one size within a group.
//  3. Values lie in row-major order and a dataset is complete: as many elements as its dimensions
//     say. Only the first dimension may be left open (k_growing) until the archive is finished.
//  4. Text holds no NUL character and is at most text_bytes long.
//
// Not thread-safe: one thread at a time uses a Sink or Source.
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

/// "f64", "i64", "i32", "bool", "text": the words of the digest's manifest.
std::string_view name_of(ElementType type);

/// Elements in memory; alternatives in the order of ElementType. A boolean is one byte, 0 or 1 in
/// what we write, anything in a file that we merely read.
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

/// Size of a first dimension that is known only when the archive is finished.
inline constexpr std::size_t k_growing = std::numeric_limits<std::size_t>::max();

struct DatasetSpec {
  std::string name{};
  ElementType type = ElementType::f64;
  std::vector<Dimension> dims{};  ///< none for a scalar
  std::vector<Attribute> attributes{};
  std::size_t text_bytes = 0;  ///< for text alone: room for the longest element
};

struct Group {
  std::string name{};  ///< "/" or "/posterior"
  std::vector<Attribute> attributes{};
  std::vector<DatasetSpec> datasets{};  ///< no dimension is k_growing once finished
};

/// The product of the dimensions. REQUIRES: no dimension is k_growing and the product fits.
std::uint64_t element_count(const DatasetSpec& spec);

/// "/posterior/draw"; "/request" in the root group.
std::string path_of(std::string_view group, std::string_view dataset);

/// True for what may name a group (after its '/'), dataset, dimension or attribute: format.h.
bool is_plain_name(std::string_view name);

const Attribute* find_attribute(const std::vector<Attribute>& attributes, std::string_view name);
const DatasetSpec* find_dataset(const Group& group, std::string_view name);

/// Takes an archive. Functions throw base::Error when the medium fails (a full disk); after that
/// the archive is lost and only destruction is allowed.
class Sink {
 public:
  /// Datasets are numbered 0, 1, ... in the order of their creation, over all groups.
  using DatasetHandle = std::size_t;

  virtual ~Sink() = default;
  /// REQUIRES: a new name "/word"; the root group is there from the start.
  virtual void create_group(std::string_view group) = 0;
  /// REQUIRES: the group exists and has no such attribute yet.
  virtual void set_attribute(std::string_view group, const Attribute& attribute) = 0;
  /// REQUIRES: the group exists, the invariants above.
  virtual DatasetHandle create_dataset(std::string_view group, const DatasetSpec& spec) = 0;
  /// The next elements in row-major order. REQUIRES: the dataset's type; not past its end.
  virtual void append(DatasetHandle dataset, const ValuesView& values) = 0;
  /// Ends the archive. REQUIRES: every dataset is complete; nothing is called afterwards.
  virtual void finish() = 0;
};

/// Gives an archive. Functions throw base::Error with ExitCode::bad_archive when what they read is
/// damaged.
class Source {
 public:
  virtual ~Source() = default;
  /// For messages: the file's path.
  virtual std::string name() const = 0;
  /// All groups, the root first; datasets in the order of their creation as far as known.
  virtual const std::vector<Group>& groups() const = 0;
  /// Elements first .. first+count-1 of a dataset, in row-major order.
  /// REQUIRES: the dataset exists and the range lies within it.
  virtual Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
                      std::uint64_t count) const = 0;
};

const Group* find_group(const Source& source, std::string_view name);

/// Throws base::Error with ExitCode::bad_archive: the source's name and the reason.
[[noreturn]] void refuse_archive(const Source& source, const std::string& reason);

}  // namespace sleight::archive
