// A whole run: sequence in, folder of results out. What `plumbline run` and `plumbline demo` share.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/calibration.h"
#include "plumbline/consistency.h"
#include "plumbline/evaluation.h"
#include "plumbline/fusion.h"
#include "plumbline/imu_stream.h"
#include "plumbline/loops.h"
#include "plumbline/mesh.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/parameters.h"
#include "plumbline/pipeline.h"
#include "plumbline/reconstruct.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "plumbline/trajectory.h"
#include "reconstruction/frame_source.h"
#include "view/live_view.h"

namespace plumbline::app {

struct Reconstruction;

struct ReconstructionOptions {
  std::string sequence;
  std::string output;  ///< folder; created, files in it replaced whole
  SequenceOptions input;
  std::shared_ptr<const Sequence> opened;  ///< `sequence`, where it is open already
  std::string unused;                      ///< which input is not used, and why; a note in the results
  Parameters parameters;
  std::string backend = "auto";
  int threads = 0;     ///< 0 = all cores
  int max_frames = 0;  ///< 0 = no limit; counted after `stride`
  int stride = 1;
  std::vector<TimeSpan> left_out;  ///< of the recording
  double realtime = 0;      ///< play the sequence at so many times its speed and drop what comes too fast; 0 = wait
  SE3 initial_pose;         ///< world_from_camera of the first frame
  std::string groundtruth;  ///< trajectory file; empty = the sequence's own, if it has one
  GlobalCorrection global = GlobalCorrection::off;  ///< of the path's drift, where the frames can be read again
  bool mesh = true;
  std::vector<std::string> mesh_files;  ///< besides mesh.ply, in `output`; the ending says the format
  bool final_fusion = false;  ///< the mesh is fused again along the final path, where the frames can be read again
  FusionOptions fusion;       ///< of it; range of depth, threads and what is told are filled in
  bool report = true;         ///< write report.html, by
  std::function<void(const std::string& path, const Reconstruction& run)> write_report;  ///< none: it cannot
  std::optional<OrientationStream> orientation;
  OrientationSensor sensor;                    ///< of `orientation`, or of the live source
  std::optional<ImuStream> inertial;           ///< its gyroscope and accelerometer, where it has them
  std::string orientation_source;              ///< in words, for the summary
  std::vector<std::string> orientation_notes;  ///< what was odd about its file
  std::vector<int> pixel_use_frames;           ///< frames whose pixels' use is painted, by their index in the sequence
  std::vector<int> icp_frames;                 ///< frames whose iterations are written, by their index in the sequence
  std::function<std::unique_ptr<FrameSource>()> open_live;  ///< instead of `sequence`, `input` and `orientation`
  std::shared_ptr<LiveView> view;                           ///< the page that watches, or null
  bool quiet = false;
  std::string command_line;  ///< for the summary
};

/// What a run of the program did; the files in the output folder say the same.
struct Reconstruction : plumbline::Reconstruction {
  std::string command_line;
  std::vector<ReadTimes> reads;  ///< one a frame
  std::string groundtruth;       ///< path, or empty
  Trajectory truth;              ///< its poses, or empty
  std::optional<eval::AbsoluteError> ate;
  std::string ate_note;  ///< why there is no `ate` although there is a ground truth, or what makes it doubtful
  std::optional<LiveCounts> live;  ///< of a live run
  double wall_seconds = 0;
  std::vector<std::string> icp_traces;  ///< what was written for `icp_frames`, JSON
  std::string failure;                  ///< message of what ended the run early, or empty
  std::string report;                   ///< path of report.html, or empty if there is none
  std::optional<CropBox> crop;          ///< what was kept of the surface; none: all
  int signal = 0;                       ///< that ended the run early, or 0
};

/// Ctrl-C finishes the current frame; what was reached is written. If a frame cannot be read, what was reached is
/// written too, and then the Error is thrown.
Reconstruction reconstruct(const ReconstructionOptions& options);

}  // namespace plumbline::app
