// The Sink behind write_file: one open HDF5 file. See writer.h for its guarantees.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/archive/hdf5/handle.h"
#include "common/archive/hdf5/output_file.h"
#include "common/archive/model.h"

namespace sleight::archive::hdf5 {

class FileSink final : public Sink {
 public:
  /// Creates the HDF5 file in `output`. Both arguments must outlive the sink.
  FileSink(const Api& api, OutputFile& output);

  void create_group(std::string_view group) override;
  void set_attribute(std::string_view group, const Attribute& attribute) override;
  DatasetHandle create_dataset(std::string_view group, const DatasetSpec& spec) override;
  void append(DatasetHandle dataset, const ValuesView& values) override;
  /// Connects dimensions with their coordinates and closes the file.
  void finish() override;

 private:
  struct Dataset {
    std::string group;
    DatasetSpec spec;
    std::string path;
    Handle id{};
    std::vector<std::uint64_t> dims{};  ///< of the file's dataset, without the text width
    std::uint64_t position = 0;         ///< elements appended
    std::int32_t dimension_id = -1;     ///< if the dataset is a coordinate
  };
  /// A dimension scale for the width of one group's text arrays.
  struct Width {
    Handle id;
    std::int32_t dimension_id = -1;
  };

  hid_t group_id(std::string_view name) const;
  void put_text(hid_t object, const std::string& path, const char* name, const std::string& text);
  void put_attribute(hid_t object, const std::string& path, const Attribute& attribute);
  void put_integers(hid_t object, const std::string& path, const char* name,
                    const std::vector<std::int32_t>& values, bool scalar);
  Width& width_of(const std::string& group, std::size_t bytes);
  void grow(Dataset& dataset, std::uint64_t elements);
  void write_box(Dataset& dataset, const ValuesView& values, std::uint64_t offset,
                 std::uint64_t left, std::uint64_t& written);
  void make_scales();
  void attach_scales(const Dataset& dataset);
  const Dataset& coordinate_of(const std::string& group, const std::string& dim) const;

  const Api& api_;
  OutputFile& output_;
  Handle file_;
  std::map<std::string, Handle, std::less<>> groups_;
  std::vector<Dataset> datasets_;
  std::map<std::string, Width> widths_;  ///< by path
  std::int32_t next_dimension_id_ = 0;
};

}  // namespace sleight::archive::hdf5
