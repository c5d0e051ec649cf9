// Which version of the library a program runs with.
#pragma once

#include <string_view>

#include "plumbline/export.h"

namespace plumbline {

/// "0.1.0", after Semantic Versioning. Of the library that is loaded, which may be newer than the headers; within one
/// version of its binary interface (docs/library.md) that is no difference. Costs nothing.
PLUMBLINE_EXPORT std::string_view version();

}  // namespace plumbline
