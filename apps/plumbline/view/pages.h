// The pages that web/ builds, as bytes within the program.
#pragma once

#include <string>

namespace plumbline::app {

/// False if the program was built without them (PLUMBLINE_REPORT); then those below are empty.
bool has_pages();
/// Whole, with the packages that both use: the program holds those once.
std::string live_page();
/// The same, with one mark for the data.
std::string report_template();

}  // namespace plumbline::app
