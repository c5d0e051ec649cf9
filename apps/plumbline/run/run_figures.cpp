#include "run/run_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/text_file.h"
#include "io/trajectory.h"
#include "plumbline/error.h"
#include "plumbline/evaluation.h"
#include "plumbline/se3.h"
#include "plumbline/statistics.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

/// Splits the text into rows of fields.
std::vector<std::vector<std::string>> parse_csv(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row;
  std::string field;
  bool quoted = false;
  const auto end_row = [&] {
    row.push_back(std::move(field));
    field.clear();
    rows.push_back(std::move(row));
    row.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      field += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      row.push_back(std::move(field));
      field.clear();
    } else if (c == '\n' && !quoted) {
      end_row();
    } else if (c != '\r' || quoted) {
      field += c;
    }
  }
  if (!field.empty() || !row.empty()) end_row();
  return rows;
}

/// An error that cannot be had is none: too few frames, no truth there.
template <class Evaluate>
std::optional<double> rmse(Evaluate&& evaluate) {
  try {
    return evaluate().translation.rmse;
  } catch (const Error&) {
    return std::nullopt;
  }
}

double median(const std::vector<double>& values) { return eval::statistics(values).median; }

void add_errors(const nlohmann::json& summary, const Trajectory& estimate, RunFigures* figures) {
  if (summary.at("ate").is_null()) return;
  if (summary["ate"].contains("rmse_m")) figures->ate = summary["ate"]["rmse_m"];
  const Trajectory truth = read_trajectory(summary["ate"].at("groundtruth"));
  figures->ate_all = rmse([&] { return eval::absolute_trajectory_error(truth, estimate); });
  figures->rpe = rmse([&] { return eval::relative_trajectory_error(truth, estimate); });
  eval::RelativeErrorOptions all;
  all.all_pairs = true;
  figures->rpe_all_pairs = rmse([&] { return eval::relative_trajectory_error(truth, estimate, all); });
}

void add_frames(const CsvRows& rows, RunFigures* figures) {
  std::vector<double> inliers;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    figures->frame_ms.push_back(rows.number(i, "total_ms"));
    if (rows.text(i, "status") == "tracked") inliers.push_back(rows.number(i, "inlier_fraction"));
  }
  figures->inliers = median(inliers);
}

RunFigures read_figures(const std::string& folder) {
  const std::string summary_file = (fs::path(folder) / "summary.json").string();
  const nlohmann::json summary = nlohmann::json::parse(read_file(summary_file));
  const CsvRows rows((fs::path(folder) / "frames.csv").string());
  RunFigures figures;
  figures.frames = summary.at("frames");
  figures.lost = summary.at("lost");
  figures.mean_iterations = summary.at("mean_iterations");
  figures.track_ms = summary.at("median_ms").at("track");
  figures.total_ms = summary.at("median_ms").at("total");
  add_frames(rows, &figures);
  add_errors(summary, all_frames(rows), &figures);
  return figures;
}

}  // namespace

CsvRows::CsvRows(const std::string& path) : path_(path), rows_(parse_csv(read_file(path))) {
  if (rows_.empty()) throw Error("the table is empty", path, "");
  columns_ = rows_.front();
  rows_.erase(rows_.begin());
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (rows_[i].size() != columns_.size())
      throw Error(fmt::format("row {} has {} fields, the header {}", i + 1, rows_[i].size(), columns_.size()), path,
                  "");
}

std::size_t CsvRows::index_of(const std::string& column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end()) throw Error("there is no column " + column, path_, "");
  return static_cast<std::size_t>(found - columns_.begin());
}

const std::string& CsvRows::text(std::size_t row, const std::string& column) const {
  return rows_.at(row)[index_of(column)];
}

double CsvRows::number(std::size_t row, const std::string& column) const {
  const std::optional<double> value = parse_double(text(row, column));
  if (!value) throw Error(fmt::format("{} of row {} is no number", column, row + 1), path_, "");
  return *value;
}

Trajectory all_frames(const CsvRows& frames) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto field = [&](const char* column) { return frames.number(i, column); };
    const Eigen::Quaterniond q(field("qw"), field("qx"), field("qy"), field("qz"));
    const std::optional<Nanoseconds> time = parse_seconds(frames.text(i, "time_s"));
    if (!time) throw Error(fmt::format("time_s of row {} is no time", i + 1), "frames.csv", "");
    trajectory.push_back({*time, SE3(q, {field("tx"), field("ty"), field("tz")})});
  }
  return trajectory;
}

RunFigures run_figures(const std::string& folder) {
  try {
    return read_figures(folder);
  } catch (const nlohmann::json::exception& error) {
    throw Error(fmt::format("the summary cannot be read ({})", error.what()), folder,
                "Remove the folder, and run again.");
  }
}

}  // namespace plumbline::app
