// What came out of an angular test, as a table for people, as JSON, and as a row a pair.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "lab/angular_test.h"

namespace plumbline::app {

// Giancola, Schneider, Wonka, Ghanem 2018: failures in % of the pairs, over degrees.
constexpr std::array<int, 9> kPaperAngles = {5, 10, 15, 20, 25, 30, 40, 50, 60};
constexpr std::array<int, 9> kPaperOriginal = {0, 10, 25, 55, 75, 90, 100, 100, 100};
constexpr std::array<int, 9> kPaperImu = {0, 0, 10, 0, 10, 0, 5, 10, 100};

/// What was tested, and how.
struct AngularReport {
  std::string command_line, sequence, groundtruth;
  std::string preset, backend;
  std::string orientation;  ///< source in words, or empty
  int frames = 0;
  int pairs_wanted = 0;
  double tolerance = 0;        ///< degrees
  double max_translation = 0;  ///< metres
  SuccessLimits limits;
  std::vector<AngleResult> angles;
};

std::string table_header();
std::string table_row(const AngleResult& result);
/// Failures in % of the pairs in Giancola, Schneider, Wonka, Ghanem 2018, one an angle (degrees).
struct PaperAngles {
  std::vector<double> angles, original, imu;
};
PaperAngles paper_angles();
/// The paper's figures, to compare with.
std::vector<std::string> paper_rows();

std::string angular_json(const AngularReport& report);
/// A header, and a row for each pair.
std::string pairs_csv(const std::vector<AngleResult>& angles);

}  // namespace plumbline::app
