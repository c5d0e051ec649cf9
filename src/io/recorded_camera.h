// The camera as a recording's own files tell it.
#pragma once

#include <optional>
#include <string>

#include "io/camera.h"
#include "plumbline/pinhole.h"

namespace plumbline {

/// The same camera, of images of width × height: pixel centres keep their place, c' = (c + ½)·s − ½. Empty if the
/// images are of another shape (beyond rounding to pixels), so that one was cut out of the other.
std::optional<Pinhole> scaled_to(const Pinhole& camera, int width, int height);

/// fx 0 cx, 0 fy cy, 0 0 1 (or 4×4), numbers between blanks or commas, with or without brackets. Width and height stay
/// 0. Throws Error for other matrices.
Pinhole read_matrix_file(const std::string& path);

}  // namespace plumbline
