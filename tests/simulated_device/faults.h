// What the simulated device finds wrong.
#pragma once

#include <string>

namespace plumbline::simulated {

/// Keeps the sentence for `take_faults`; the same one is kept once.
void report(const std::string& sentence);
/// So much was reported that more would only take time.
bool enough_is_reported();

/// "reduce<29, …>+0x1c4": the function that an instruction belongs to.
std::string name_of(const void* instruction);

}  // namespace plumbline::simulated
