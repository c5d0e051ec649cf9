// The driver of the BNO055, through a real serial line (a pseudo-terminal) to a chip that misbehaves as real ones do.
#include "capture/bno055.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <thread>

#include "capture/clock.h"
#include "capture/i2c_bus.h"
#include "capture/imu_source.h"
#include "capture/serial_bus.h"
#include "plumbline/time.h"
#include "support/error_of.h"
#include "support/fake_bno055.h"
#include "support/temp_folder.h"
#include "support/terminal.h"

namespace plumbline::capture {
namespace {

using test::FakeBno055;
using test::kFakeRate;
using test::TempFolder;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class Bno055Test : public testing::Test {
 protected:
  void SetUp() override { PLUMBLINE_TERMINAL_OR_SKIP(); }

  std::unique_ptr<Bno055> connect(const Bno055Options& options = {}) {
    return std::make_unique<Bno055>(open_bus(chip_.connection()), options);
  }
  /// Seconds between a reading's stamp and when the turning chip was where it says.
  static double stamp_error(const ImuReading& reading) {
    const double angle = 2 * std::atan2(reading.quaternion.z(), reading.quaternion.w());
    return std::remainder(angle - kFakeRate * to_seconds(reading.time), 2 * M_PI) / kFakeRate;
  }
  /// Of readings with an orientation.
  static std::vector<double> stamp_errors(Bno055& chip, int count) {
    std::vector<double> errors;
    for (int i = 0; i < count; ++i)
      if (const auto reading = chip.read()) errors.push_back(std::abs(stamp_error(*reading)));
    std::sort(errors.begin(), errors.end());
    return errors;
  }

  TempFolder folder_;
  FakeBno055 chip_{folder_.path()};
};

TEST_F(Bno055Test, DeliversTheQuaternionInOurOrderWithTheTimeItWasTaken) {
  const auto chip = connect();
  EXPECT_EQ(chip->firmware(), "3.11");
  EXPECT_EQ(chip_.mode(), 0x0C);
  EXPECT_EQ(chip_.resets(), 1);
  const std::vector<double> errors = stamp_errors(*chip, 50);
  ASSERT_EQ(errors.size(), 50u);
  EXPECT_LT(errors[25], 0.02);  // seconds; a wrong order of components would be wrong by more
}

TEST_F(Bno055Test, DeliversRawReadingsInSiUnitsAndTheCalibrationState) {
  chip_.calibration_status = 0b11'10'01'00;
  const auto reading = connect()->read();
  ASSERT_TRUE(reading && reading->raw);
  EXPECT_NEAR((reading->raw->angular_rate - Eigen::Vector3d(0, 0, kFakeRate)).norm(), 0, 1e-3);
  EXPECT_NEAR((reading->raw->specific_force - Eigen::Vector3d(0.5, -0.25, 9.81)).norm(), 0, 1e-9);
  EXPECT_NEAR((reading->raw->magnetic_field - Eigen::Vector3d(20, -5, -44)).norm(), 0, 1e-9);
  EXPECT_EQ(reading->calibration, (CalibrationStatus{3, 2, 1, 0}));
}

TEST_F(Bno055Test, CanReadTheOrientationAlone) {
  const auto reading = connect({.raw = false})->read();
  ASSERT_TRUE(reading);
  EXPECT_FALSE(reading->raw);
  EXPECT_LT(std::abs(stamp_error(*reading)), 0.1);
}

TEST_F(Bno055Test, WaitsOutTheChangesOfModeAsTheDataSheetSays) {
  const auto chip = connect();
  for (int i = 0; i < 3; ++i) chip->read_calibration();
  chip->read();
  EXPECT_EQ(chip_.requests_while_deaf(), 0);
}

TEST_F(Bno055Test, AsksABusyChipAgain) {
  const auto chip = connect();
  chip_.overruns = 0.4;
  const std::vector<double> errors = stamp_errors(*chip, 100);
  EXPECT_EQ(errors.size(), 100u);
  EXPECT_LT(errors[50], 0.02);
  EXPECT_GT(chip->bus().counters().overruns, 20u);
}

TEST_F(Bno055Test, SetsUpAChipThatIsBusyAndLosesBytes) {
  chip_.overruns = 0.3;
  chip_.lost_bytes = 0.1;
  EXPECT_NO_THROW(connect());
}

TEST_F(Bno055Test, LostBytesAndGarbageNeverMakeAWrongOrientation) {
  const auto chip = connect({.raw = false});
  chip_.lost_bytes = 0.1;
  chip_.garbage = 0.05;
  std::vector<double> errors;
  for (int i = 0; i < 60; ++i) {
    try {
      if (const auto reading = chip->read()) errors.push_back(std::abs(stamp_error(*reading)));
    } catch (const BusError&) {
    }
  }
  EXPECT_GT(errors.size(), 50u);
  EXPECT_LT(*std::max_element(errors.begin(), errors.end()), 0.5);
  EXPECT_GT(chip->bus().counters().repeats, 3u);
}

TEST_F(Bno055Test, ASilentChipIsTold) {
  chip_.silent = true;
  EXPECT_THAT(test::error_of([&] { connect(); }),
              AllOf(HasSubstr(chip_.port()), HasSubstr("no answer"), HasSubstr("RX to TX")));
}

TEST_F(Bno055Test, AnotherChipIsTold) {
  chip_.chip_id = 0xFB;
  EXPECT_THAT(test::error_of([&] { connect(); }), AllOf(HasSubstr("0xfb"), HasSubstr("0xa0")));
}

TEST_F(Bno055Test, AChipThatRestartsIsSetUpAgain) {
  const Bno055Calibration calibration = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22};
  const auto chip = connect({.calibration = calibration});
  chip_.brown_out();
  std::optional<ImuReading> reading;
  for (const Nanoseconds limit = now() + 20 * kNanosecondsPerSecond; !reading && now() < limit;) {
    try {
      reading = chip->read();
    } catch (const BusError&) {
    }
  }
  ASSERT_TRUE(reading);
  EXPECT_EQ(chip->restarts(), 1);
  EXPECT_EQ(chip_.calibration(), calibration);
  EXPECT_LT(std::abs(stamp_error(*reading)), 0.5);
}

TEST_F(Bno055Test, TheCalibrationGoesToAFileAndBackIntoTheChip) {
  Bno055Calibration calibration;
  for (std::size_t i = 0; i < calibration.size(); ++i) calibration[i] = static_cast<std::uint8_t>(11 * i + 3);
  const std::string path = folder_ / "imu-calibration.txt";
  {
    const auto chip = connect();
    chip_.set_calibration(calibration);  // as the chip itself finds it while it moves
    write_bno055_calibration(path, chip->read_calibration());
    EXPECT_TRUE(chip->read());  // it goes on measuring
  }
  chip_.brown_out();
  connect({.calibration = read_bno055_calibration(path)});
  EXPECT_EQ(chip_.calibration(), calibration);
  EXPECT_EQ(chip_.mode(), 0x0C);
}

TEST_F(Bno055Test, DamagedCalibrationFilesAreRefused) {
  const std::string path = folder_ / "calibration.txt";
  test::write_text(path, "01 02 03\n");
  EXPECT_THAT(test::error_of([&] { read_bno055_calibration(path); }), AllOf(HasSubstr(path), HasSubstr("3 bytes")));
  test::write_text(path, "01 02 100\n");
  EXPECT_THAT(test::error_of([&] { read_bno055_calibration(path); }),
              AllOf(HasSubstr(path + ":1"), HasSubstr("'100'")));
}

TEST_F(Bno055Test, PortsThatCannotBeOpened) {
  EXPECT_THAT(test::error_of([] { open_bus("serial:/dev/none"); }), HasSubstr("/dev/none"));
  EXPECT_THAT(test::error_of([] { open_bus("serial:/dev/null"); }), AllOf(HasSubstr("/dev/null"), HasSubstr("serial")));
  EXPECT_THAT(test::error_of([] { open_bus("i2c:/dev/i2c-none"); }), HasSubstr("/dev/i2c-none"));
  EXPECT_THAT(test::error_of([] { open_bus("i2c:/dev/i2c-1:0x99"); }), HasSubstr("7-bit"));
  EXPECT_THAT(test::error_of([] { open_bus("usb:1"); }), AllOf(HasSubstr("'usb:1'"), HasSubstr("serial:")));
}

// ---- I2C ----

TEST(I2cBus, ReadsWithAWriteOfTheAddressAndAReadBehindIt) {
  std::vector<int> log;
  int failures = 1;
  I2cBus bus("i2c", 0x29, [&](std::vector<i2c_msg>& messages) {
    if (failures-- > 0) return EREMOTEIO;  // the chip stretches the clock for longer than the adapter waits
    for (const i2c_msg& m : messages) {
      log.insert(log.end(), {m.addr, m.flags, m.len});
      if (m.flags & I2C_M_RD)
        for (int i = 0; i < m.len; ++i) m.buf[i] = static_cast<std::uint8_t>(10 + i);
      else
        for (int i = 0; i < m.len; ++i) log.push_back(m.buf[i]);
    }
    return 0;
  });
  Nanoseconds time = 0;
  const Nanoseconds begin = now();
  EXPECT_THAT(bus.read(0x20, 3, &time), ElementsAre(10, 11, 12));
  EXPECT_THAT(log, ElementsAre(0x29, 0, 1, 0x20, 0x29, I2C_M_RD, 3));
  EXPECT_GE(time, begin);
  EXPECT_LE(time, now());
  EXPECT_EQ(bus.counters().repeats, 1u);
  log.clear();
  bus.write(0x3D, {0x0C});
  EXPECT_THAT(log, ElementsAre(0x29, 0, 2, 0x3D, 0x0C));
}

TEST(I2cBus, TellsSilenceFromALostAdapter) {
  int error = EREMOTEIO;
  I2cBus bus("i2c", 0x28, [&](std::vector<i2c_msg>&) { return error; });
  EXPECT_THROW(bus.read(0, 1, nullptr), BusError);
  EXPECT_NO_THROW(bus.write_unanswered(0x3F, 0x20));  // a chip that resets does not acknowledge
  error = ENODEV;
  EXPECT_THROW(bus.read(0, 1, nullptr), Disconnected);
  EXPECT_THROW(bus.write_unanswered(0x3F, 0x20), Disconnected);
}

// ---- The thread around it ----

class ImuSourceTest : public Bno055Test {
 protected:
  ImuSource::Sink sink() {
    return [this](const ImuReading& reading) {
      const std::lock_guard lock(mutex_);
      readings_.push_back(reading);
    };
  }
  std::size_t count() {
    const std::lock_guard lock(mutex_);
    return readings_.size();
  }
  /// Waits until `condition` holds, for at most 20 s.
  template <class Condition>
  static bool eventually(Condition&& condition) {
    for (const Nanoseconds limit = now() + 20 * kNanosecondsPerSecond; now() < limit;) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }
  void expect_good_readings() {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < readings_.size(); ++i) {
      EXPECT_LT(std::abs(stamp_error(readings_[i])), 0.5) << i;
      if (i > 0) {
        EXPECT_GT(readings_[i].time, readings_[i - 1].time);
      }
    }
  }

  std::mutex mutex_;
  std::vector<ImuReading> readings_;
};

TEST_F(ImuSourceTest, ReadsAtTheRateThatWasAskedFor) {
  ImuSource source({.connection = chip_.connection(), .rate = 50, .chip = {}}, sink());
  ASSERT_TRUE(eventually([&] { return count() >= 50; }));
  source.finish();
  const double seconds = to_seconds(readings_[49].time - readings_[0].time);
  EXPECT_GT(seconds, 0.9);  // never faster; how much slower is for the machine to say
  expect_good_readings();
  EXPECT_EQ(source.status().readings, readings_.size());
}

TEST_F(ImuSourceTest, UnpluggedAndPluggedInAgainInMidStream) {
  ImuSource source({.connection = chip_.connection(), .rate = 100, .chip = {}}, sink());
  ASSERT_TRUE(eventually([&] { return count() > 10; }));
  chip_.unplug();
  ASSERT_TRUE(eventually([&] { return !source.status().connected; }));
  EXPECT_THAT(source.take_messages(), ElementsAre(AllOf(HasSubstr(chip_.port()), HasSubstr("gone"))));
  chip_.plug_in();
  const std::size_t before = count();
  ASSERT_TRUE(eventually([&] { return count() > before + 10; }));
  EXPECT_THAT(source.take_messages(), ElementsAre(HasSubstr("is back after")));
  EXPECT_EQ(source.status().reconnections, 1);
  expect_good_readings();
}

TEST_F(ImuSourceTest, AStallIsToldAndSurvived) {
  ImuSource source({.connection = chip_.connection(), .rate = 100, .chip = {}}, sink());
  ASSERT_TRUE(eventually([&] { return count() > 10; }));
  chip_.silent = true;
  ASSERT_TRUE(eventually([&] { return source.status().failed > 0; }));
  chip_.silent = false;
  const std::size_t before = count();
  ASSERT_TRUE(eventually([&] { return count() > before + 10; }));
  EXPECT_THAT(source.take_messages(), ElementsAre(HasSubstr("no answer"), HasSubstr("is back after")));
  EXPECT_EQ(source.status().reconnections, 0);
  expect_good_readings();
}

TEST_F(ImuSourceTest, GivesTheCalibrationAtTheEnd) {
  ImuSource source({.connection = chip_.connection(), .rate = 100, .chip = {}}, sink());
  Bno055Calibration calibration;
  calibration.fill(0x5A);
  chip_.set_calibration(calibration);
  EXPECT_EQ(source.finish(), calibration);
}

TEST_F(ImuSourceTest, AWrongPortIsToldAtOnce) {
  EXPECT_THROW(ImuSource({.connection = "serial:/dev/none", .rate = 100, .chip = {}}, sink()), Error);
}

}  // namespace
}  // namespace plumbline::capture
