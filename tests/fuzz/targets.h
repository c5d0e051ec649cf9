// One target a parser: what is done with the bytes of a file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plumbline::fuzz {

std::vector<std::string> target_names();

/// Feeds the bytes to a parser. An Error is what a parser may answer; anything else that leaves this function is a
/// finding. Returns false if there is no such target.
bool run_target(std::string_view target, std::string_view bytes);

}  // namespace plumbline::fuzz
