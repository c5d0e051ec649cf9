#pragma once

namespace plumbline {

/// Pixels. A header that claims a longer side is damaged: no sensor has it, and its memory must not be allocated.
constexpr int kMaxImageSide = 16384;

}  // namespace plumbline
