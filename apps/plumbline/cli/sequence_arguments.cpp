#include "cli/sequence_arguments.h"

#include <CLI/CLI.hpp>

#include "cli/arguments.h"
#include "plumbline/calibration.h"
#include "plumbline/pinhole.h"

namespace plumbline::app {

void add_sequence_arguments(CLI::App& command, SequenceArguments& arguments, bool sequence_required) {
  command
      .add_option("sequence", arguments.path,
                  "Folder of the sequence (TUM RGB-D, ICL-NUIM, 7-Scenes or depth PNGs), an Azure Kinect's .mkv, or a "
                  "ROS 1 .bag")
      ->required(sequence_required)
      ->type_name("SEQUENCE");
  command.add_option("--camera", arguments.camera, "Intrinsics by name: fr1, fr2, fr3, icl, 7scenes, …")
      ->type_name("NAME");
  command.add_option("--intrinsics", arguments.intrinsics, "Intrinsics in pixels; fy may be negative (y up)")
      ->type_name("FX,FY,CX,CY");
  command.add_option("--distortion", arguments.distortion, "Lens distortion (Brown-Conrady)")
      ->type_name("K1,K2,P1,P2,K3");
  command.add_flag("--no-undistort", arguments.no_undistort, "Take the images as if the lens had no distortion");
  command.add_option("--depth-scale", arguments.depth_scale, "Depth readings per metre")
      ->check(CLI::Range(1e-3, 1e9))
      ->type_name("S");
  command
      .add_option("--depth-calibration", arguments.depth_calibration,
                  "Take out the depth's own distortion, which `plumbline calibrate` found")
      ->type_name("FILE");
  command.add_option("--depth-topic", arguments.depth_topic, "Of a ROS bag (default: the one that fits best)")
      ->type_name("TOPIC");
  command.add_option("--color-topic,--colour-topic", arguments.color_topic, "The same for colour")->type_name("TOPIC");
  command
      .add_option("--min-confidence", arguments.min_confidence,
                  "Leave out readings whose confidence image has less (default 1: those of the lowest level; 0: none)")
      ->check(CLI::Range(0, 255))
      ->type_name("LEVEL");
  command.add_flag("--strict", arguments.strict, "Stop where something in the recording does not add up");
  command.add_flag("--no-color,--no-colour", arguments.no_color, "Do not read colour");
}

SequenceOptions sequence_options(const SequenceArguments& arguments) {
  SequenceOptions options;
  options.camera = arguments.camera;
  options.depth_topic = arguments.depth_topic;
  options.color_topic = arguments.color_topic;
  options.undistort = !arguments.no_undistort;
  options.depth_scale = arguments.depth_scale;
  options.color = !arguments.no_color;
  options.min_confidence = arguments.min_confidence;
  options.strict = arguments.strict;
  if (!arguments.depth_calibration.empty())
    options.depth_distortion = read_depth_calibration(arguments.depth_calibration);
  if (!arguments.intrinsics.empty()) {
    const auto n = parse_numbers(arguments.intrinsics, 4, "--intrinsics", "fx,fy,cx,cy");
    options.intrinsics = Pinhole{
        static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2]), static_cast<float>(n[3]), 0, 0};
  }
  if (!arguments.distortion.empty()) {
    const auto n = parse_numbers(arguments.distortion, 5, "--distortion", "k1,k2,p1,p2,k3");
    options.distortion = Distortion{n[0], n[1], n[2], n[3], n[4]};
  }
  return options;
}

}  // namespace plumbline::app
