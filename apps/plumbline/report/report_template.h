// The page that web/ builds, as bytes within the program.
#pragma once

#include <string_view>

namespace plumbline::app {

/// The whole page with one mark for the data; empty if the program was built without the report (PLUMBLINE_REPORT).
std::string_view report_template();

}  // namespace plumbline::app
