// Where this checkout is, for tests that start its scripts or read its files.
#pragma once

#include <filesystem>

namespace plumbline::test {

std::filesystem::path source_root();

}  // namespace plumbline::test
