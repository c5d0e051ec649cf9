// Tables of inertial readings in which a row holds one sensor alone.
#pragma once

#include <string>
#include <vector>

#include "io/columns.h"

namespace plumbline {

/// Whether a column of the first row names its sensor: `12.5,gyro,0.1,0,0`, `ACC 12.5 0 0 9.8`, or a number under the
/// heading `sensor` or `type` (Android's: 1 accelerometer, 2 magnetometer, 4 gyroscope).
bool names_sensors_in_rows(const Table& table);

/// A table whose rows hold gyroscope and accelerometer together. Where they alternate in the file, by a column that
/// names the sensor or by cells that are empty, each of the gyroscope's rows gets the accelerometer's readings of that
/// moment, between its rows before and after. Other tables stay as they are.
class JoinedRows {
 public:
  explicit JoinedRows(Table table);
  JoinedRows(const JoinedRows&) = delete;
  JoinedRows& operator=(const JoinedRows&) = delete;

  const Table& table() const { return table_; }
  /// What was joined, or empty.
  const std::string& note() const { return note_; }

 private:
  void join_named();
  void join_empty_cells();

  Table table_;
  std::string note_, head_;
  std::vector<std::string> text_;  // what the lines look at
};

}  // namespace plumbline
