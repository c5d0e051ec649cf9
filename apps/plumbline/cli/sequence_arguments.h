// The options that every command which opens a sequence has.
#pragma once

#include <optional>
#include <string>

#include "plumbline/sequence.h"

namespace CLI {
class App;
}

namespace plumbline::app {

struct SequenceArguments {
  std::string path, camera, intrinsics, distortion, depth_calibration, depth_topic, color_topic;
  std::optional<double> depth_scale;
  int min_confidence = SequenceOptions{}.min_confidence;
  bool no_undistort = false, no_color = false, strict = false;
};

void add_sequence_arguments(CLI::App& command, SequenceArguments& arguments, bool sequence_required);

/// Throws UsageError for values that are not of the option's form.
SequenceOptions sequence_options(const SequenceArguments& arguments);

}  // namespace plumbline::app
