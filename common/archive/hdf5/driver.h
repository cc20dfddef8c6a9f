// What our HDF5 file drivers have in common (input_file.cpp, output_file.cpp): a file is a state of
// ours, which the file-access list names; HDF5 sees addresses without end and no blocks of its own.
//
// A State has `allocated`, HDF5's end of allocation. Functions are C's, for HDF5 to call.
#pragma once

#include <hdf5.h>

#include <algorithm>
#include <iterator>

namespace sleight::archive::hdf5 {

/// HDF5's view of an open file: its own fields first, then ours.
template <class State>
struct DriverFile {
  H5FD_t base;
  State* state;
};

/// The driver's part of a file-access list, which HDF5 copies as bytes.
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

/// A driver that opens and closes as above; what it can do, and how it reads and writes, is the
/// caller's to add.
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

/// Makes a file-access list use the driver with this state. Negative on failure, as HDF5 has it.
template <class State>
herr_t use_driver(hid_t file_access_list, hid_t driver_id, State& state) {
  if (driver_id < 0) return -1;
  const DriverInfo<State> info{&state};
  return H5Pset_driver(file_access_list, driver_id, &info);
}

}  // namespace sleight::archive::hdf5
