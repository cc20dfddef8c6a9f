// The common part of our HDF5 file drivers (reader.cpp, output_file.cpp). The file-access list
// refers to a State, which represents the file. HDF5 sees an unlimited address space and no block
// structure.
//
// A State has a member `allocated`: the end of the space that HDF5 allocated. The functions are C
// callbacks.
#pragma once

#include <hdf5.h>

#include <algorithm>
#include <iterator>

namespace sleight::archive::hdf5 {

/// HDF5's struct for an open file, followed by the driver's own field.
template <class State>
struct DriverFile {
  H5FD_t base;
  State* state;
};

/// The driver's data in a file-access list. HDF5 copies them bytewise.
template <class State>
struct DriverInfo {
  State* state;
};

template <class State>
State& state_of(H5FD_t* file) {
  return *reinterpret_cast<DriverFile<State>*>(file)->state;
}
template <class State>
const State& state_of(const H5FD_t* file) {
  return *reinterpret_cast<const DriverFile<State>*>(file)->state;
}

template <class State>
H5FD_t* open_driver_file(const char*, unsigned, hid_t list, haddr_t) {
  const auto* info = static_cast<const DriverInfo<State>*>(H5Pget_driver_info(list));
  if (info == nullptr) return nullptr;
  auto* file = new DriverFile<State>{};
  file->state = info->state;
  return &file->base;
}

template <class State>
herr_t close_driver_file(H5FD_t* file) {
  delete reinterpret_cast<DriverFile<State>*>(file);
  return 0;
}

template <class State>
haddr_t allocated_end(const H5FD_t* file, H5FD_mem_t) {
  return state_of<State>(file).allocated;
}

template <class State>
herr_t set_allocated_end(H5FD_t* file, H5FD_mem_t, haddr_t address) {
  state_of<State>(file).allocated = address;
  return 0;
}

/// Returns a driver with the open and close functions above. The caller adds the driver's features
/// and its read and write functions.
template <class State>
H5FD_class_t driver_for(const char* name) {
  H5FD_class_t driver{};
  driver.name = name;
  driver.maxaddr = (haddr_t{1} << 62) - 1;
  driver.fc_degree = H5F_CLOSE_STRONG;
  driver.fapl_size = sizeof(DriverInfo<State>);
  driver.open = open_driver_file<State>;
  driver.close = close_driver_file<State>;
  driver.get_eoa = allocated_end<State>;
  driver.set_eoa = set_allocated_end<State>;
  const H5FD_mem_t map[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(map), std::end(map), std::begin(driver.fl_map));
  return driver;
}

/// Makes a file-access list use the driver with `state`. Returns a negative value on failure, like
/// HDF5.
template <class State>
herr_t use_driver(hid_t file_access_list, hid_t driver_id, State& state) {
  if (driver_id < 0) return -1;
  const DriverInfo<State> info{&state};
  return H5Pset_driver(file_access_list, driver_id, &info);
}

}  // namespace sleight::archive::hdf5
