// A line of options as words.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plumbline::app {

/// Words between blanks, as a shell would split them; one in single or double quotes may hold blanks.
std::vector<std::string> split_words(std::string_view text);

}  // namespace plumbline::app
