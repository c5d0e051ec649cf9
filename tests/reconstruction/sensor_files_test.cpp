// Whole runs with every combination of sensors, from files as users have them, and with clocks that are off.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "plumbline/calibration.h"
#include "plumbline/evaluation.h"
#include "plumbline/files.h"
#include "plumbline/reconstruct.h"
#include "plumbline/se3.h"
#include "plumbline/simulate.h"
#include "plumbline/time.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::TempFolder;
using test::write_text;
using testing::HasSubstr;

constexpr int kFrames = 60;

/// A simulated recording of a hand that turns, and what its sensors read, which all tests share.
class SensorFiles : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    SimulateOptions options;
    options.path = "dance";
    options.duration = 9;
    options.rate = 20;
    options.color = false;
    options.camera = {131.25f, 131.25f, 79.5f, 59.5f, 160, 120};
    truth_ = new Simulation(simulate(*folder_ / "recording", options));
    imu_ = new ImuRecording(read_imu(*folder_ / "recording/imu.csv"));
    orientations_ = new std::vector<OrientationSample>(read_orientations(*folder_ / "recording/orientation.txt", {}));
  }
  static void TearDownTestSuite() {
    delete orientations_;
    delete imu_;
    delete truth_;
    delete folder_;
  }

  static Reconstruction run(const SensorReadings& sensor, int frames) {
    const auto sequence = open_sequence(*folder_ / "recording");
    ReconstructOptions options;
    options.parameters.volume.resolution = 160;
    options.parameters.volume.side = 5;
    options.global = GlobalCorrection::off;
    options.mesh = false;
    options.sensor = sensor;
    for (int i = 0; i < frames; ++i) options.frames.push_back(i);
    return reconstruct(*sequence, options);
  }

  static double error(const Reconstruction& run) {
    return eval::absolute_trajectory_error(truth_->world_from_camera, run.trajectory).translation.rmse;
  }

  static int used(const Reconstruction& run) {
    int count = 0;
    for (const FrameReport& frame : run.frames) count += frame.orientation == OrientationUse::used ? 1 : 0;
    return count;
  }

  /// A line a reading, `late` seconds later than it was.
  static std::string file_of(const std::string& name, const std::string& head,
                             const std::function<std::string(const ImuSample&)>& line, double late = 0) {
    std::string text = head + "\n";
    for (const ImuSample& sample : imu_->samples)
      text += format_seconds(sample.time + from_seconds(late), 6) + line(sample) + "\n";
    write_text(*folder_ / name, text);
    return *folder_ / name;
  }

  static std::string triple(const Eigen::Vector3d& v) {
    return fmt::format(",{:.7g},{:.7g},{:.7g}", v.x(), v.y(), v.z());
  }
  static std::string rates(const ImuSample& sample) { return triple(sample.angular_rate); }
  static std::string forces(const ImuSample& sample) { return triple(sample.specific_force); }

  static inline TempFolder* folder_ = nullptr;
  static inline Simulation* truth_ = nullptr;
  static inline ImuRecording* imu_ = nullptr;
  static inline std::vector<OrientationSample>* orientations_ = nullptr;
};

TEST_F(SensorFiles, EveryCombinationOfSensorsIsUsedAndDoesNoHarm) {
  const std::string gyroscope = "t,gyro_x,gyro_y,gyro_z", accelerometer = "acc_x,acc_y,acc_z";
  const std::string quaternion = "qx,qy,qz,qw";
  const OrientationStream stream(*orientations_, {});
  const auto chip = [&](const ImuSample& sample) {
    const Eigen::Quaterniond q(stream.lookup(sample.time).earth_from_body);
    return fmt::format(",{:.9f},{:.9f},{:.9f},{:.9f}", q.x(), q.y(), q.z(), q.w());
  };
  const struct {
    const char* what;
    std::string path;
    bool is_inertial, has_up, has_heading;
  } files[] = {
      {"gyroscope", file_of("g.csv", gyroscope, rates), true, false, true},
      {"accelerometer", file_of("a.csv", "t," + accelerometer, forces), false, true, false},
      {"both",
       file_of("ga.csv", gyroscope + "," + accelerometer, [](const ImuSample& s) { return rates(s) + forces(s); }),
       true, true, true},
      {"orientation", *folder_ / "recording/orientation.txt", false, true, true},
      {"all",
       file_of("qga.csv", "t," + quaternion + ",gyro_x,gyro_y,gyro_z," + accelerometer,
               [&](const ImuSample& s) { return chip(s) + rates(s) + forces(s); }),
       true, true, true},
  };
  const Reconstruction without = run({}, kFrames);
  EXPECT_EQ(used(without), 0);
  for (const auto& [what, path, is_inertial, has_up, has_heading] : files) {
    const SensorReadings sensor = read_sensor(path);
    ASSERT_TRUE(sensor.orientation) << what;
    EXPECT_EQ(sensor.inertial.has_value(), is_inertial) << what;
    EXPECT_EQ(sensor.orientation->options().convention.has_up, has_up) << what;
    EXPECT_EQ(sensor.sensor.has_heading, has_heading) << what;
    const Reconstruction with = run(sensor, kFrames);
    EXPECT_EQ(with.lost(), 0) << what;
    EXPECT_GE(used(with), 0.98 * (kFrames - 1)) << what;
    EXPECT_LT(error(with), 1.02 * error(without) + 0.001) << what;
  }
}

/// The same hand in finer images, for the offset of the clock alone.
class SensorClock : public testing::Test {
 protected:
  void SetUp() override {
    SimulateOptions options;
    options.path = "dance";
    options.duration = 8;
    options.rate = 20;
    options.color = false;
    options.noise = false;  // a distortion of the depth, which a run takes out before, would drag the turns
    options.camera = {262.5f, 262.5f, 159.5f, 119.5f, 320, 240};
    simulate(folder_ / "recording", options);
    sequence_ = open_sequence(folder_ / "recording");
    for (int i = 0; i < sequence_->size(); ++i) frames_.push_back(i);
  }

  ClockOffset offset_of(const std::vector<OrientationSample>& samples) const {
    return find_clock_offset(*sequence_, frames_, OrientationStream(samples, {}));
  }

  static std::vector<OrientationSample> shifted(std::vector<OrientationSample> samples, double seconds) {
    for (OrientationSample& sample : samples) sample.time += from_seconds(seconds);
    return samples;
  }

  TempFolder folder_;
  std::unique_ptr<Sequence> sequence_;
  std::vector<int> frames_;
};

TEST_F(SensorClock, IsFoundByAGyroscopeAndByOrientations) {
  ImuRecording gyroscope = read_imu(folder_ / "recording/imu.csv");
  gyroscope.has_accelerometer = false;
  write_imu(folder_ / "gyro.csv", gyroscope);
  const SensorReadings turns = read_sensor(folder_ / "gyro.csv");
  std::vector<OrientationSample> truth;
  for (const StampedPose& pose : sequence_->read_groundtruth())
    truth.push_back({pose.time, pose.world_from_camera.rotation()});
  for (const double late : {0.1, -0.8}) {
    for (const auto& samples : {turns.orientation->samples(), truth}) {
      const ClockOffset clock = offset_of(shifted(samples, late));
      ASSERT_TRUE(clock.is_sure) << clock.text;
      EXPECT_NEAR(clock.offset, -late, 0.003);
      EXPECT_LT(clock.sd, 0.005);
      EXPECT_THAT(clock.text, HasSubstr(late > 0 ? "ms late" : "ms early"));
    }
  }
  const ClockOffset in_step = offset_of(truth);
  EXPECT_TRUE(in_step.is_sure) << in_step.text;
  EXPECT_EQ(in_step.offset, 0);
}

TEST_F(SensorClock, StaysAsItIsWhereTheTurnsDoNotTell) {
  std::vector<OrientationSample> other = read_orientations(folder_ / "recording/orientation.txt", {});
  const Nanoseconds begin = other.front().time;
  for (OrientationSample& sample : other) {
    const double t = to_seconds(sample.time - begin);
    sample.earth_from_body = so3::exp(Eigen::Vector3d(0.4 * std::sin(2.1 * t), 0.5 * t, 0.3 * std::cos(3.3 * t)));
  }
  const ClockOffset clock = offset_of(other);
  EXPECT_FALSE(clock.is_sure);
  EXPECT_EQ(clock.offset, 0);
  EXPECT_THAT(clock.text, HasSubstr("stays unknown"));
}

}  // namespace
}  // namespace plumbline
