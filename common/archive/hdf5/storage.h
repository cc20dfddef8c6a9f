// HDF5 representation of the model's types and attributes, shared by writer and reader.
#pragma once

#include <string_view>

namespace sleight::archive::hdf5 {

/// Attribute that marks booleans for xarray, because netCDF has no booleans. They are stored as
/// int8.
inline constexpr const char* k_dtype_attribute = "dtype";
inline constexpr const char* k_dtype_bool = "bool";

/// Text arrays are character arrays with one more dimension. This attribute gives their encoding.
inline constexpr const char* k_encoding_attribute = "_Encoding";
inline constexpr const char* k_encoding_utf8 = "utf-8";

/// Attributes of HDF5's dimension scales and of netCDF-4, which aren't archive content.
inline constexpr const char* k_class_attribute = "CLASS";
inline constexpr const char* k_class_scale = "DIMENSION_SCALE";
inline constexpr const char* k_name_attribute = "NAME";
inline constexpr const char* k_reference_list = "REFERENCE_LIST";
inline constexpr const char* k_dimension_list = "DIMENSION_LIST";
inline constexpr const char* k_netcdf_dimension_id = "_Netcdf4Dimid";
inline constexpr const char* k_netcdf_coordinates = "_Netcdf4Coordinates";

/// netCDF-4's name for a scale that only defines a dimension's size. The size follows the name.
inline constexpr std::string_view k_bare_dimension =
    "This is a netCDF dimension but not a netCDF variable.";

}  // namespace sleight::archive::hdf5
