// Where the page's files lie: beside the program, as they are built and installed.
#pragma once

#include <string>

namespace sleight::gallery {

/// <folder of the running program>/../share/sleight/gallery. Throws base::Error(environment) that
/// says what to do where the page is not there: it is built with npm's packages alone.
std::string page_folder();
/// The page for saved galleries: .../share/sleight/gallery-saved. Likewise.
std::string saved_page_folder();

}  // namespace sleight::gallery
