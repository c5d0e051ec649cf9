// The live page that web/ builds, as bytes within the program.
#pragma once

#include <string_view>

namespace plumbline::app {

/// Empty if the program was built without the pages (PLUMBLINE_REPORT).
std::string_view live_page();

}  // namespace plumbline::app
