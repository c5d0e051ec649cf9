#include "capture/recorder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <deque>
#include <filesystem>
#include <functional>
#include <iterator>
#include <utility>
#include <vector>

#include "capture/clock.h"
#include "io/append_file.h"
#include "io/atomic_file.h"
#include "io/images/png.h"
#include "io/recorded_camera.h"
#include "plumbline/error.h"
#include "plumbline/time.h"

namespace plumbline::capture {
namespace {

namespace fs = std::filesystem;

constexpr double kTumScale = 5000;           // readings per metre
constexpr std::size_t kBallast = 256 << 10;  // bytes

/// Blocks of the disk that nothing else can take. A disk too full for them is one too full to record on.
std::string make_ballast(const fs::path& folder) {
  const std::string path = (folder / ".reserve").string();
  AtomicFile file(path, Durable::no);
  file.write(std::string(kBallast, '\0'));
  file.commit();
  return path;
}

}  // namespace

/// Images of one kind: those that wait to be encoded, those that wait to be listed, and their list.
class Recorder::ImageStream {
 public:
  /// Writes one image to a path.
  using Write = std::function<void(const std::string& path, const CapturedFrame& frame)>;

  ImageStream(const fs::path& folder, std::string kind, const std::string& list, Write write, Recorder& recorder)
      : folder_(folder),
        kind_(std::move(kind)),
        write_(std::move(write)),
        recorder_(recorder),
        list_((folder / list).string()) {
    ensure_directory((folder / kind_).string());
    list_.append("# timestamp filename\n");
    thread_ = std::thread([this] { run(); });
  }
  ~ImageStream() { stop(); }

  std::size_t waiting() const {
    const std::lock_guard lock(mutex_);
    return queue_.size();
  }

  void add(Nanoseconds stamp, std::shared_ptr<const CapturedFrame> frame) {
    {
      const std::lock_guard lock(mutex_);
      queue_.emplace_back(stamp, std::move(frame));
    }
    changed_.notify_all();
  }

  /// Encodes what waits, and ends.
  void stop() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  /// Takes note of the images that are written by now: they may be listed once the disk has them. Returns their number.
  std::size_t gather() {
    const std::lock_guard lock(mutex_);
    std::move(written_.begin(), written_.end(), std::back_inserter(unlisted_));
    written_.clear();
    return unlisted_.size();
  }

  /// Lists those.
  void list() {
    if (unlisted_.empty()) return;
    list_.append(fmt::format("{}", fmt::join(unlisted_, "")));
    unlisted_.clear();
  }
  void sync() { list_.sync(); }

 private:
  using Item = std::pair<Nanoseconds, std::shared_ptr<const CapturedFrame>>;

  void run() {
    while (std::optional<Item> item = take()) {
      if (recorder_.has_failed()) continue;
      try {
        const std::string stamp = format_seconds(item->first), name = fmt::format("{}/{}.png", kind_, stamp);
        write_((folder_ / name).string(), *item->second);
        const std::lock_guard lock(mutex_);
        written_.push_back(fmt::format("{} {}\n", stamp, name));
      } catch (...) {
        recorder_.fail(std::current_exception());
      }
    }
  }

  std::optional<Item> take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
    if (queue_.empty()) return std::nullopt;
    Item item = std::move(queue_.front());
    queue_.pop_front();
    return item;
  }

  fs::path folder_;
  std::string kind_;
  Write write_;
  Recorder& recorder_;
  AppendFile list_;                    // of the syncing thread
  std::vector<std::string> unlisted_;  // of the syncing thread: lines of images

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> queue_;            // guarded by mutex_
  std::vector<std::string> written_;  // guarded by mutex_
  bool stopping_ = false;             // guarded by mutex_
  std::thread thread_;                // last: starts when all else stands
};

/// orientation.txt and imu.csv.
class Recorder::Readings {
 public:
  Readings(const fs::path& folder, bool raw) : orientation_((folder / "orientation.txt").string()) {
    orientation_.append("# earth_from_body as the sensor reports it\n# timestamp qx qy qz qw\n");
    if (!raw) return;
    imu_ = std::make_unique<AppendFile>((folder / "imu.csv").string());
    imu_->append(
        "timestamp,gyro_x,gyro_y,gyro_z,accelerometer_x,accelerometer_y,accelerometer_z,"
        "magnetometer_x,magnetometer_y,magnetometer_z\n");
  }

  void add(Nanoseconds stamp, const ImuReading& reading) {
    const std::string time = format_seconds(stamp, 6);
    const Eigen::Vector4d& q = reading.quaternion;
    const std::lock_guard lock(mutex_);
    orientation_.append(fmt::format("{} {:.7f} {:.7f} {:.7f} {:.7f}\n", time, q.x(), q.y(), q.z(), q.w()));
    if (imu_ == nullptr || !reading.raw) return;
    std::string line = time;
    for (const Eigen::Vector3d& v :
         {reading.raw->angular_rate, reading.raw->specific_force, reading.raw->magnetic_field})
      for (int axis = 0; axis < 3; ++axis) line += fmt::format(",{:.7g}", v[axis]);
    imu_->append(line + '\n');
  }

  void sync() {
    orientation_.sync();
    if (imu_) imu_->sync();
  }

 private:
  std::mutex mutex_;
  AppendFile orientation_;
  std::unique_ptr<AppendFile> imu_;
};

Recorder::Recorder(const RecorderOptions& options) : options_(options), unix_offset_(unix_offset()) {
  const fs::path folder = options.folder;
  ensure_directory(options.folder);
  for (const char* name : {"depth.txt", "orientation.txt"})
    if (std::error_code error; fs::exists(folder / name, error))
      throw Error(fmt::format("the folder holds a recording already ({})", name), options.folder,
                  "give another folder; recordings are never overwritten");
  ballast_ = make_ballast(folder);
  if (options.orientation) readings_ = std::make_unique<Readings>(folder, options.raw);
  if (options.camera) {
    write_camera_json(options.folder, *options.camera, kTumScale, options.body_from_camera);
    depth_ = std::make_unique<ImageStream>(
        folder, "depth", "depth.txt",
        [scale = options.depth_scale](const std::string& path, const CapturedFrame& frame) {
          write_depth_png(path, at_scale(frame.depth, scale, kTumScale));
        },
        *this);
    if (options.color)
      color_ = std::make_unique<ImageStream>(
          folder, "rgb", "rgb.txt",
          [](const std::string& path, const CapturedFrame& frame) { write_color_png(path, frame.color); }, *this);
  }
  folder_fd_ = open(options.folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_fd_ < 0) throw_write_error(options.folder, errno);
  syncer_ = std::thread([this] { sync_regularly(); });
}

Recorder::~Recorder() {
  try {
    finish();
  } catch (...) {  // told by check() or finish(), if anyone asked
  }
  close(folder_fd_);
}

void Recorder::add(CapturedFrame captured) {
  if (depth_ == nullptr || has_failed()) return;
  // With depth and colour dropped together, an image of the one is never without the other.
  if (!has_room()) {
    const std::lock_guard lock(mutex_);
    ++status_.dropped;
    return;
  }
  const auto frame = std::make_shared<const CapturedFrame>(std::move(captured));
  depth_->add(frame->time + unix_offset_, frame);
  if (color_ && !frame->color.empty()) color_->add(frame->color_time + unix_offset_, frame);
}

bool Recorder::has_room() const {
  return depth_ == nullptr || std::max(depth_->waiting(), color_ ? color_->waiting() : 0) < options_.queue;
}

void Recorder::add(const ImuReading& reading) {
  if (readings_ == nullptr || has_failed()) return;
  try {
    readings_->add(reading.time + unix_offset_, reading);
    const std::lock_guard lock(mutex_);
    ++status_.readings;
  } catch (...) {
    fail(std::current_exception());
  }
}

void Recorder::sync_regularly() {
  const std::chrono::duration<double> interval(options_.sync_interval);
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      if (changed_.wait_for(lock, interval, [this] { return stopping_; })) return;
    }
    if (has_failed()) continue;
    try {
      sync();
    } catch (...) {
      fail(std::current_exception());
    }
  }
}

/// First the images and their folders' entries, then their names: a listed image is there.
void Recorder::sync() {
  const Nanoseconds begin = now();
  const std::size_t depth = depth_ ? depth_->gather() : 0, color = color_ ? color_->gather() : 0;
  // One call for all the images. An fsync for each of sixty a second is more than a plain disk can do.
  if (depth + color > 0 && syncfs(folder_fd_) != 0) throw_write_error(options_.folder, errno);
  // Colour first, so that a depth image is never listed without the colour that belongs to it.
  if (color_) color_->list();
  if (depth_) depth_->list();
  if (color_) color_->sync();
  if (depth_) depth_->sync();
  if (readings_) readings_->sync();
  const std::lock_guard lock(mutex_);
  status_.frames += depth;
  status_.slowest_sync = std::max(status_.slowest_sync, to_seconds(now() - begin));
}

void Recorder::fail(std::exception_ptr error) {
  {
    const std::lock_guard lock(mutex_);
    if (error_ != nullptr) return;
    error_ = std::move(error);
  }
  unlink(ballast_.c_str());
}

bool Recorder::has_failed() const {
  const std::lock_guard lock(mutex_);
  return error_ != nullptr;
}

void Recorder::check() const {
  const std::lock_guard lock(mutex_);
  if (error_ != nullptr) std::rethrow_exception(error_);
}

RecorderStatus Recorder::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void Recorder::finish() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (syncer_.joinable()) syncer_.join();
  if (depth_) depth_->stop();
  if (color_) color_->stop();
  if (!std::exchange(finished_, true)) {
    try {
      sync();
    } catch (...) {
      fail(std::current_exception());
    }
    unlink(ballast_.c_str());
  }
  check();
}

}  // namespace plumbline::capture
