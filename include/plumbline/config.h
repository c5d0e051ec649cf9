// Parameters in and out of text: TOML files, `group.name=value` settings, and the listing for people.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/parameters.h"

namespace plumbline {

/// Overlays the values that a TOML file names. Unknown keys, wrong types and values out of range throw Error with the
/// file, the line, and the nearest known key or the permitted values; `parameters` is then unchanged.
PLUMBLINE_EXPORT void load_parameters(const std::string& path, Parameters* parameters);

/// Same for text; `where` names it in errors.
PLUMBLINE_EXPORT void parse_parameters(std::string_view toml, const std::string& where, Parameters* parameters);

/// One setting from the command line: "tracking.normal_gate=25", "tracking.iterations=[2,3]", "volume.placement=fit"
/// (strings need no quotes). Throws as `load_parameters` does.
PLUMBLINE_EXPORT void apply_setting(std::string_view assignment, Parameters* parameters);

/// TOML that `parse_parameters` reads back to the same values, each with its unit and help as a comment.
PLUMBLINE_EXPORT std::string to_toml(const Parameters& parameters);

/// Every key as "group.name", in the order of `fields()`.
PLUMBLINE_EXPORT std::vector<std::string> parameter_keys();

/// Throws Error if a value is out of its range or two values contradict each other.
PLUMBLINE_EXPORT void validate(const Parameters& parameters);

}  // namespace plumbline
