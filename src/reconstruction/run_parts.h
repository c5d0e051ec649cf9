// The parts of a run, which `reconstruct` and the program put together alike.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backend/backend.h"
#include "plumbline/calibration.h"
#include "plumbline/imu_stream.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/parameters.h"
#include "plumbline/pipeline.h"
#include "plumbline/reconstruct.h"
#include "plumbline/sequence.h"
#include "reconstruction/frame_loop.h"
#include "reconstruction/frame_source.h"

namespace plumbline {

/// The same frames with the distortion of their depth taken out, if `frames` tell it; `run` gets what was found. What
/// cannot be read here is told by the run, which keeps all that came before it. `options.stopping` ends it early.
std::unique_ptr<Sequence> undistort_depth(std::unique_ptr<Sequence> sequence, const std::vector<int>& frames,
                                          const CalibrationOptions& options, Reconstruction* run);

/// Readings of a sensor for the frames of a run; either may be missing.
struct SensorStreams {
  std::optional<OrientationStream> orientation;
  std::optional<ImuStream> inertial;
};

/// Finds by how much the sensor's clock is off, and takes it out of the streams, where the sensor is used and judged,
/// measures headings or turns, and no offset was given; `run` gets what was found. As for the depth, what cannot be
/// read is told by the run.
void set_clock(const Sequence& sequence, const std::vector<int>& frames, const CalibrationOptions& options,
               SensorStreams* sensor, Reconstruction* run);

/// "distortion of the depth looked for and not found, because …".
std::string depth_refusal_text(const std::string& refusal);

/// As `Pipeline`, but an Error that says how large the volume is where its memory is not there.
std::unique_ptr<Pipeline> make_pipeline(const Parameters& parameters, const FrameSource& source, Backend& backend,
                                        const SE3& initial_pose, bool with_color, const OrientationSensor& sensor);

/// "512x512x512 voxels of 15.62 mm, side 8 m, truncation 0.08 m".
std::string volume_text(const VolumeParameters& volume);

/// Who looks on, when to end, and where lines for the user go.
struct RunHooks {
  std::vector<FrameObserver*> observers;
  std::function<bool()> stopping;
  Note note;
};

/// Every frame of the source through the pipeline, and into `run` what came of it: also before it throws what source,
/// pipeline and observers throw.
void process_frames(FrameSource& source, Pipeline& pipeline, const RunHooks& hooks, Reconstruction* run);

/// The final surface, and where the map stands.
void take_surface(const Pipeline& pipeline, bool with_mesh, Reconstruction* run);

}  // namespace plumbline
