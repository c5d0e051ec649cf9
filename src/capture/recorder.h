// A recording on disk: a TUM folder that is good at every moment, up to the final second.
#pragma once

#include <Eigen/Core>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "capture/depth_device.h"
#include "capture/imu_reading.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"

namespace plumbline::capture {

struct RecorderOptions {
  std::string folder;                                    ///< created if missing; must hold no recording yet
  std::optional<Pinhole> camera;                         ///< empty: no images
  double depth_scale = 1000;                             ///< of the frames, readings per metre; written as TUM's 5000
  std::optional<Eigen::Matrix3d> body_from_camera = {};  ///< of the orientation sensor; empty: not known
  bool color = false;                                    ///< frames have colour
  bool orientation = false;                              ///< there is an orientation sensor
  bool raw = false;                                      ///< and it delivers its raw readings
  std::size_t queue = 30;                                ///< frames that may wait for the disk
  double sync_interval = 0.4;  ///< seconds between two moments at which all is known to be on the disk
};

struct RecorderStatus {
  std::uint64_t frames = 0;    ///< depth images that are listed and on the disk
  std::uint64_t dropped = 0;   ///< frames for which the disk was too slow
  std::uint64_t readings = 0;  ///< orientations
  double slowest_sync = 0;     ///< seconds
};

/// Images are written beside and renamed, and listed in depth.txt and rgb.txt only when they are known to be on the
/// disk; readings are appended at once. A program that is killed loses what was captured since the previous sync; so
/// does a computer without power. Images are encoded in two threads, and a third one syncs.
///
/// An error (a full disk) ends the recording: what comes later is ignored, what was written stays. `check` and
/// `finish` throw it.
class Recorder {
 public:
  /// Writes camera.json, which says all of the camera that the folder is opened with. Throws Error if the folder cannot
  /// be written to or holds a recording.
  explicit Recorder(const RecorderOptions& options);
  /// Without finish(): keeps what is there, ignoring errors.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Both may be called from any thread, and return at once.
  void add(CapturedFrame frame);
  void add(const ImuReading& reading);

  /// Whether a frame that is added now will not be dropped.
  bool has_room() const;
  /// Throws the Error that ended the recording, if one did.
  void check() const;
  RecorderStatus status() const;

  /// Waits until everything is on the disk. Throws the Error that ended the recording, if one did.
  void finish();

 private:
  class ImageStream;
  class Readings;

  void sync_regularly();
  void sync();
  void fail(std::exception_ptr error);
  bool has_failed() const;

  RecorderOptions options_;
  Nanoseconds unix_offset_;
  int folder_fd_ = -1;
  std::unique_ptr<ImageStream> depth_, color_;
  std::unique_ptr<Readings> readings_;
  std::string ballast_;  // a file that is given up when the disk is full, so that the lists can be ended

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::exception_ptr error_;  // this and all below guarded by mutex_
  RecorderStatus status_;
  bool stopping_ = false, finished_ = false;
  std::thread syncer_;
};

}  // namespace plumbline::capture
