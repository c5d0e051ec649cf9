// ScanNet's .sens (Dai et al. 2017), version 4: calibration, colour, depth, poses and inertial readings of an iPad with
// a Structure sensor.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "plumbline/sequence.h"

namespace plumbline {

/// By the first 16 bytes: the version, then the length of the sensor's name. There is no word that tells the format.
bool is_sens(std::string_view bytes);

/// Depth (raw or zlib), colour (raw, PNG or JPEG) brought to depth through both cameras, the frames' poses as truth.
/// Throws Error as open_sequence does.
std::unique_ptr<Sequence> open_sens_recording(const std::string& path, const SequenceOptions& options);

}  // namespace plumbline
