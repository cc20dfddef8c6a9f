// Finds the page's files, which are built and installed beside the program.
#pragma once

#include <string>

namespace sleight::gallery {

/// Returns <folder of the running program>/../share/sleight/gallery. If the page is missing, throws
/// base::Error(environment) with instructions: building it requires npm packages.
std::string page_folder();
/// The page for saved galleries: .../share/sleight/gallery-saved. Throws as page_folder().
std::string saved_page_folder();

}  // namespace sleight::gallery
