// Names for the rows of tables and the keys of plots.
#pragma once

#include <string>
#include <vector>

namespace plumbline::app {

/// What tells several paths from each other: without the folders, and the file name, that all share. A single path
/// stays as it is.
std::vector<std::string> short_names(std::vector<std::string> paths);

}  // namespace plumbline::app
