#include "lab/angular_report.h"
#include "plumbline/angles.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace plumbline::app {
namespace {

using Json = nlohmann::ordered_json;

std::string cells(const char* name, const std::array<int, 9>& values) {
  std::string line = fmt::format("  {:<11}", name);
  for (const int value : values) line += fmt::format("{:>5}", value);
  return line;
}

Json angle_json(const AngleResult& result) {
  const AngleSummary s = summarise(result);
  const bool any = s.pairs > s.failures;
  return {{"angle_deg", result.angle},
          {"pairs", s.pairs},
          {"failures", s.failures},
          {"failure_percent", s.pairs > 0 ? Json(s.failure_percent()) : Json()},
          {"lost", s.lost},
          {"without_reading", s.missing},
          {"median_translation_error_m", any ? Json(s.median_translation) : Json()},
          {"median_rotation_error_deg", any ? Json(degrees(s.median_rotation)) : Json()}};
}

}  // namespace

std::string table_header() {
  return fmt::format("{:>7}{:>7}{:>10}{:>11}{:>7}{:>17}{:>12}", "angle", "pairs", "failures", "failure %", "lost",
                     "translation mm", "rotation °");
}

std::string table_row(const AngleResult& result) {
  const AngleSummary s = summarise(result);
  const std::string angle = fmt::format("{:g}°", result.angle);
  if (s.pairs == 0) return fmt::format("{:>7}{:>7}{:>10}{:>11}{:>7}{:>17}{:>12}", angle, 0, "–", "–", "–", "–", "–");
  const bool any = s.pairs > s.failures;
  return fmt::format("{:>7}{:>7}{:>10}{:>11.1f}{:>7}{:>17}{:>12}", angle, s.pairs, s.failures, s.failure_percent(),
                     s.lost, any ? fmt::format("{:.1f}", 1e3 * s.median_translation) : "–",
                     any ? fmt::format("{:.3f}", degrees(s.median_rotation)) : "–");
}

PaperAngles paper_angles() {
  return {{kPaperAngles.begin(), kPaperAngles.end()},
          {kPaperOriginal.begin(), kPaperOriginal.end()},
          {kPaperImu.begin(), kPaperImu.end()}};
}

std::vector<std::string> paper_rows() {
  return {"failure % in the paper (Giancola et al. 2018):", cells("angle", kPaperAngles),
          cells("original", kPaperOriginal), cells("with IMU", kPaperImu)};
}

std::string angular_json(const AngularReport& report) {
  Json json = {{"plumbline", PLUMBLINE_VERSION},
               {"command", report.command_line},
               {"sequence", report.sequence},
               {"groundtruth", report.groundtruth},
               {"frames", report.frames},
               {"preset", report.preset},
               {"backend", report.backend},
               {"orientation", report.orientation.empty() ? Json() : Json(report.orientation)},
               {"pairs_wanted", report.pairs_wanted},
               {"tolerance_deg", report.tolerance},
               {"max_translation_m", report.max_translation},
               {"success_translation_m", report.limits.translation},
               {"success_rotation_deg", degrees(report.limits.rotation)}};
  json["angles"] = Json::array();
  for (const AngleResult& result : report.angles) json["angles"].push_back(angle_json(result));
  json["paper"] = {{"source", "Giancola, Schneider, Wonka, Ghanem 2018"},
                   {"angle_deg", kPaperAngles},
                   {"original_failure_percent", kPaperOriginal},
                   {"imu_failure_percent", kPaperImu}};
  // Paths may hold bytes that are not UTF-8, which JSON cannot.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string pairs_csv(const std::vector<AngleResult>& angles) {
  std::string text =
      "angle_deg,first,second,true_rotation_deg,true_translation_m,status,reason,orientation,translation_error_m,"
      "rotation_error_deg,success\n";
  for (const AngleResult& angle : angles) {
    for (const PairOutcome& o : angle.outcomes) {
      const std::string errors = o.status == TrackingStatus::lost
                                     ? ","
                                     : fmt::format("{:.6f},{:.4f}", o.translation_error, degrees(o.rotation_error));
      text += fmt::format("{:g},{},{},{:.4f},{:.6f},{},{},{},{},{}\n", angle.angle, o.pair.first, o.pair.second,
                          degrees(o.pair.angle), o.pair.translation, to_string(o.status), to_string(o.reason),
                          to_string(o.orientation), errors, o.success ? 1 : 0);
    }
  }
  return text;
}

}  // namespace plumbline::app
