// Goal: if Sleight can't have written a file, the file is refused. The error names the file and the
// object. Method: let the HDF5 library change a sound archive, for example by adding a foreign
// object.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <hdf5_hl.h>

#include <functional>

#include "common/archive/hdf5/reader.h"
#include "common/archive/hdf5/writer.h"
#include "common/base/error.h"
#include "tests/support/facts.h"
#include "tests/unit/common/archive/fake_world.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::archive::hdf5 {
namespace {

using ::testing::HasSubstr;

class Hostile : public archive::testing::Scratch {
 protected:
  Hostile() {
    base::PosixFileSystem files;
    write_file(path("whole.h5"), files, archive::testing::filler({}));
  }

  /// Copies the sound archive, calls `change` with the copy's HDF5 id, and returns the copy's path.
  std::string changed(const std::function<void(hid_t)>& change) const {
    const std::string file = path("changed.h5");
    put_bytes(file, bytes_of(path("whole.h5")));
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    EXPECT_GE(id, 0);
    change(id);
    EXPECT_EQ(H5Fget_obj_count(id, H5F_OBJ_ALL), 1) << "the test left something open";
    EXPECT_GE(H5Fclose(id), 0);
    return file;
  }

  static void expect_refused(const std::string& file, const std::string& object,
                             const std::string& reason,
                             base::ExitCode code = base::ExitCode::bad_archive) {
    try {
      open_file(file);
      FAIL() << "not refused: " << object << " " << reason;
    } catch (const base::Error& error) {
      EXPECT_EQ(static_cast<int>(error.exit_code()), static_cast<int>(code));
      EXPECT_THAT(error.what(), HasSubstr(file));
      EXPECT_THAT(error.what(), HasSubstr(object));
      EXPECT_THAT(error.what(), ::testing::AnyOf(HasSubstr(reason), tests::HasFacts(reason)));
    }
  }

  static void add_dataset(hid_t file, hid_t type, std::vector<hsize_t> dims, hid_t list) {
    const hid_t space = dims.empty()
                            ? H5Screate(H5S_SCALAR)
                            : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr);
    const hid_t id =
        H5Dcreate2(file, "posterior/added", type, space, H5P_DEFAULT, list, H5P_DEFAULT);
    EXPECT_GE(id, 0);
    H5Dclose(id);
    H5Sclose(space);
  }

  static hid_t chunked(std::vector<hsize_t> chunk) {
    const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(list, static_cast<int>(chunk.size()), chunk.data());
    return list;
  }
};

TEST_F(Hostile, UnchangedCopiesAreRead) {
  EXPECT_EQ(open_file(changed([](hid_t) {}))->groups().size(), 8U);
}

TEST_F(Hostile, OtherFiles) {
  expect_refused(path("none.h5"), "", "No such file", base::ExitCode::environment);
  put_bytes(path("text.h5"), "hello");
  expect_refused(path("text.h5"), "", "not an HDF5 file");
  put_bytes(path("empty.h5"), "");
  expect_refused(path("empty.h5"), "", "not an HDF5 file");
  expect_refused("/tmp", "", "not a regular file");
  expect_refused("/dev/zero", "", "not a regular file");
  const hid_t id = H5Fcreate(path("other.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Fclose(id);
  expect_refused(path("other.h5"), "", "not a Sleight archive");
}

TEST_F(Hostile, OtherFormats) {
  // Goal: if an archive has another format version, the error names both format versions and the
  // version of the program that wrote the archive. Method: write older, newer and invalid format
  // versions into a sound archive.
  const auto of_format = [&](std::int64_t version) {
    return changed([version](hid_t id) {
      const hid_t attribute = H5Aopen(id, "format_version", H5P_DEFAULT);
      H5Awrite(attribute, H5T_NATIVE_INT64, &version);
      H5Aclose(attribute);
    });
  };
  for (const std::int64_t format : {1, 2, 4}) {
    expect_refused(of_format(format), "",
                   fmt::format("sleight 0.0.0+test|format {}|only|format 3", format));
  }
  expect_refused(of_format(0), "", "format_version is missing");
}

TEST_F(Hostile, Links) {
  expect_refused(changed([](hid_t id) {
                   H5Lcreate_soft("/posterior/draw", id, "posterior/added", H5P_DEFAULT,
                                  H5P_DEFAULT);
                 }),
                 "/posterior/added", "soft link");
  expect_refused(changed([](hid_t id) {
                   H5Lcreate_external("/etc/passwd", "/x", id, "posterior/added", H5P_DEFAULT,
                                      H5P_DEFAULT);
                 }),
                 "/posterior/added", "external");
  expect_refused(changed([](hid_t id) {
                   H5Lcreate_hard(id, "posterior/draw", id, "posterior/added", H5P_DEFAULT,
                                  H5P_DEFAULT);
                 }),
                 "/posterior/draw", "several names");
  expect_refused(
      changed([](hid_t id) { H5Lcreate_hard(id, "/", id, "loop", H5P_DEFAULT, H5P_DEFAULT); }),
      "/loop", "several names");
  expect_refused(
      changed([](hid_t id) {
        H5Gclose(H5Gcreate2(id, "posterior/deeper", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
      }),
      "/posterior/deeper", "only datasets");
  expect_refused(changed([](hid_t id) {
                   H5Gclose(H5Gcreate2(id, "a b", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
                 }),
                 "/", "invalid name");
}

TEST_F(Hostile, Types) {
  expect_refused(changed([](hid_t id) {
                   const hid_t type = H5Tcopy(H5T_NATIVE_DOUBLE);
                   H5Tcommit2(id, "kept_type", type, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
                   H5Tclose(type);
                 }),
                 "/kept_type", "expected a group or a dataset");
  expect_refused(changed([](hid_t id) {
                   const hid_t type = H5Tcopy(H5T_C_S1);
                   H5Tset_size(type, H5T_VARIABLE);
                   add_dataset(id, type, {}, H5P_DEFAULT);
                   H5Tclose(type);
                 }),
                 "/posterior/added", "type");
  expect_refused(changed([](hid_t id) {
                   const hid_t type = H5Tvlen_create(H5T_NATIVE_DOUBLE);
                   add_dataset(id, type, {3}, H5P_DEFAULT);
                   H5Tclose(type);
                 }),
                 "/posterior/added", "type");
  expect_refused(changed([](hid_t id) { add_dataset(id, H5T_IEEE_F64BE, {}, H5P_DEFAULT); }),
                 "/posterior/added", "type");
  expect_refused(changed([](hid_t id) {
                   const hid_t type = H5Tcopy(H5T_C_S1);
                   H5Tset_size(type, H5T_VARIABLE);
                   const hid_t space = H5Screate(H5S_SCALAR);
                   const char* text = "x";
                   const hid_t attribute =
                       H5Acreate2(id, "added", type, space, H5P_DEFAULT, H5P_DEFAULT);
                   H5Awrite(attribute, type, &text);
                   H5Aclose(attribute);
                   H5Sclose(space);
                   H5Tclose(type);
                 }),
                 "/", "added is not a fixed-length text");
}

/// Overwrites the text of a root attribute. The length of the attribute's type stays the same.
void overwrite_root_text(hid_t file, const char* name, const std::string& text) {
  const hid_t attribute = H5Aopen(file, name, H5P_DEFAULT);
  const hid_t type = H5Aget_type(attribute);
  std::string padded = text;
  padded.resize(H5Tget_size(type), '\0');
  H5Awrite(attribute, type, padded.data());
  H5Tclose(type);
  H5Aclose(attribute);
}

TEST_F(Hostile, Texts) {
  // 0xFF is invalid UTF-8, and 0x1B starts an escape sequence of a terminal.
  for (const char* text : {"a\xFF", "a\x1B"}) {
    expect_refused(changed([&](hid_t id) { overwrite_root_text(id, "world", text); }), "/",
                   "world contains control characters");
    const std::string file = changed([&](hid_t id) {
      const hid_t request = H5Dopen2(id, "request", H5P_DEFAULT);
      const hid_t type = H5Dget_type(request);
      std::string padded = text;
      padded.resize(H5Tget_size(type), '\0');
      H5Dwrite(request, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data());
      H5Tclose(type);
      H5Dclose(request);
    });
    try {
      open_file(file)->read("/", "request", 0, 1);
      FAIL() << "not refused";
    } catch (const base::Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("/request: the text contains control characters"));
    }
  }
}

TEST_F(Hostile, Storage) {
  expect_refused(changed([](hid_t id) {
                   const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
                   const hsize_t size = 4;
                   const hid_t space = H5Screate_simple(1, &size, nullptr);
                   H5Pset_virtual(list, space, "/etc/passwd", "x", space);
                   add_dataset(id, H5T_NATIVE_DOUBLE, {4}, list);
                   H5Sclose(space);
                   H5Pclose(list);
                 }),
                 "/posterior/added", "virtual");
  expect_refused(changed([](hid_t id) {
                   const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
                   H5Pset_external(list, "/etc/passwd", 0, 32);
                   add_dataset(id, H5T_NATIVE_DOUBLE, {4}, list);
                   H5Pclose(list);
                 }),
                 "/posterior/added", "another file");
  expect_refused(changed([](hid_t id) {
                   const hid_t list = chunked({4});
                   H5Pset_filter(list, 32015, H5Z_FLAG_OPTIONAL, 0, nullptr);
                   add_dataset(id, H5T_NATIVE_DOUBLE, {4}, list);
                   H5Pclose(list);
                 }),
                 "/posterior/added", "filter 32015");
  expect_refused(changed([](hid_t id) {
                   const hid_t list = chunked({4});
                   H5Pset_deflate(list, 9);
                   H5Pset_deflate(list, 9);
                   add_dataset(id, H5T_NATIVE_DOUBLE, {4}, list);
                   H5Pclose(list);
                 }),
                 "/posterior/added", "twice");
}

TEST_F(Hostile, Sizes) {
  expect_refused(changed([](hid_t id) { add_dataset(id, H5T_NATIVE_DOUBLE, {1000}, H5P_DEFAULT); }),
                 "/posterior/added", "too many for");
  const hsize_t huge = hsize_t{1} << 40;
  expect_refused(changed([&](hid_t id) {
                   const hid_t list = chunked({1024, 1});
                   add_dataset(id, H5T_NATIVE_DOUBLE, {huge, 8}, list);
                   H5Pclose(list);
                 }),
                 "/posterior/added", "expected at most");
  expect_refused(changed([&](hid_t id) {
                   const hid_t list = chunked({1024});
                   add_dataset(id, H5T_NATIVE_DOUBLE, {huge / 16}, list);
                   H5Pclose(list);
                 }),
                 "/posterior/added", "chunks, found");
  expect_refused(changed([&](hid_t id) {
                   const hid_t list = chunked({huge >> 12});
                   add_dataset(id, H5T_NATIVE_DOUBLE, {huge >> 12}, list);
                   H5Pclose(list);
                 }),
                 "/posterior/added", "chunks are larger");
  expect_refused(changed([](hid_t id) {
                   add_dataset(id, H5T_NATIVE_DOUBLE, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}, H5P_DEFAULT);
                 }),
                 "/posterior/added", "dimensions, found 10");
  expect_refused(changed([](hid_t id) {
                   for (int i = 0; i < 2100; ++i) {
                     H5Gclose(H5Gcreate2(id, fmt::format("g{}", i).c_str(), H5P_DEFAULT,
                                         H5P_DEFAULT, H5P_DEFAULT));
                   }
                 }),
                 "/", "objects");
  expect_refused(changed([](hid_t id) {
                   const hid_t space = H5Screate(H5S_SCALAR);
                   for (int i = 0; i < 70; ++i) {
                     H5Aclose(H5Acreate2(id, fmt::format("a{}", i).c_str(), H5T_NATIVE_DOUBLE,
                                         space, H5P_DEFAULT, H5P_DEFAULT));
                   }
                   H5Sclose(space);
                 }),
                 "/", "attributes");
}

TEST_F(Hostile, Dimensions) {
  expect_refused(changed([](hid_t id) { add_dataset(id, H5T_IEEE_F64LE, {0}, H5P_DEFAULT); }),
                 "/posterior/added", "dimension 0 has no scale");
  expect_refused(changed([](hid_t id) {
                   add_dataset(id, H5T_IEEE_F64LE, {0}, H5P_DEFAULT);
                   const hid_t added = H5Dopen2(id, "posterior/added", H5P_DEFAULT);
                   for (const char* name : {"posterior/draw", "posterior/chain"}) {
                     const hid_t scale = H5Dopen2(id, name, H5P_DEFAULT);
                     H5DSattach_scale(added, scale, 0);
                     H5Dclose(scale);
                   }
                   H5Dclose(added);
                 }),
                 "/posterior/added", "two scales");
}

}  // namespace
}  // namespace sleight::archive::hdf5
