// Whether colour lies where depth's edges are.
#pragma once

#include <optional>

#include "plumbline/sequence.h"

namespace plumbline {

/// Colour of another camera or mirrored colour, painted on as if registered, has its edges elsewhere than depth.
/// Compares how strong colour's edges are at depth's with how strong they would be if colour were larger, smaller or
/// mirrored. Empty if colour fits as it is, or half a dozen frames do not tell.
std::optional<Warning> check_color_registration(const Sequence& sequence);

}  // namespace plumbline
