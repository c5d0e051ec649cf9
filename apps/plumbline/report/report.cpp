#include "report/report.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "io/atomic_file.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "plumbline/pinhole.h"
#include "plumbline/trajectory.h"
#include "report/base64.h"
#include "report/report_frames.h"
#include "view/packed_mesh.h"
#include "view/pages.h"

namespace plumbline::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kMark = "<!-- the report's data -->";
constexpr std::size_t kMaxTraces = 20;  // of --dump-icp; each is about 50 kB

/// The data of a page: JSON, and buffers that it names.
struct PageData {
  Json json;
  std::vector<std::pair<std::string, std::string>> buffers;  ///< id and bytes

  void add(const std::string& id, std::string bytes) { buffers.emplace_back(id, std::move(bytes)); }
  void add(const std::string& id, const std::vector<float>& values) {
    add(id, std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)));
  }
};

Json facts_json(const std::vector<Fact>& facts) {
  Json json = Json::array();
  for (const Fact& fact : facts) json.push_back({{"label", fact.label}, {"value", fact.value}, {"note", fact.note}});
  return json;
}

/// Which way is up. People hold a camera upright, more or less: the mean of the images' upper sides. A world that the
/// user has chosen (--initial-pose) has a vertical axis: the one nearest to that mean.
Eigen::Vector3d up_of(const Trajectory& path, bool image_is_upside_down) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : path) up -= pose.world_from_camera.rotation().col(1);
  if (image_is_upside_down) up = -up;
  if (up.norm() < 1e-6) return -Eigen::Vector3d::UnitY();
  const bool world_is_first_camera = path.front().world_from_camera.log().norm() < 1e-9;
  if (world_is_first_camera) return up.normalized();
  int axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  return Eigen::Vector3d::Unit(axis) * (up[axis] < 0 ? -1.0 : 1.0);
}

void add_mesh(const Report& report, PageData* page) {
  if (report.mesh == nullptr || report.mesh->positions.empty()) return;
  const PackedMesh packed = pack_mesh(*report.mesh, report.surface_errors, report.error_range);
  page->json["mesh"] = {{"vertices", packed.vertices},
                        {"triangles", packed.triangles},
                        {"whole_triangles", report.mesh->triangles.size()},
                        {"whole_vertices", report.mesh->positions.size()},
                        {"origin", {packed.origin.x(), packed.origin.y(), packed.origin.z()}},
                        {"step", packed.step},
                        {"error_range_m", report.error_range}};
  for (const auto& [id, bytes] : {std::pair{"mesh-positions", &packed.positions},
                                  {"mesh-normals", &packed.normals},
                                  {"mesh-colors", &packed.colors},
                                  {"mesh-errors", &packed.errors},
                                  {"mesh-indices", &packed.indices}})
    if (!bytes->empty()) page->add(id, *bytes);
}

/// The first frames that --dump-icp asked for, as icp_N.json has them.
Json traces_json(const Reconstruction& run) {
  Json traces = Json::array();
  for (std::size_t i = 0; i < std::min(run.icp_traces.size(), kMaxTraces); ++i)
    traces.push_back(Json::parse(run.icp_traces[i]));
  return traces;
}

void add_run(const Reconstruction& run, PageData* page) {
  const FrameTable table = frame_table(run);
  const Pinhole& k = run.sequence.camera;
  page->json["frames"] = {{"rows", table.rows}, {"stride", table.stride}, {"columns", table.columns}};
  page->json["names"] = {{"status", Json::array()}, {"reason", Json::array()}};
  for (int i = 0; i <= static_cast<int>(TrackingStatus::lost); ++i)
    page->json["names"]["status"].push_back(to_string(static_cast<TrackingStatus>(i)));
  for (int i = 0; i <= static_cast<int>(LostReason::unconfirmed); ++i)
    page->json["names"]["reason"].push_back(to_string(static_cast<LostReason>(i)));
  page->json["camera"] = {{"width", k.width}, {"height", k.height}, {"fx", k.fx},
                          {"fy", k.fy},       {"cx", k.cx},         {"cy", k.cy}};
  page->json["config"] = to_toml(run.parameters);
  page->json["icp"] = traces_json(run);
  page->add("frames", table.values);
  page->add("true-path", true_path(run));
}

void add_path(const Trajectory& path, PageData* page) {
  std::vector<float> positions;
  for (const StampedPose& pose : path)
    for (const double x : {pose.world_from_camera.translation().x(), pose.world_from_camera.translation().y(),
                           pose.world_from_camera.translation().z()})
      positions.push_back(static_cast<float>(x));
  page->add("path", positions);
}

Json words_json(const Report& report) {
  return {{"plumbline", PLUMBLINE_VERSION},
          {"title", report.title},
          {"verdict", {{"level", to_string(report.verdict.level)}, {"text", report.verdict.text}}},
          {"remarks", report.remarks},
          {"facts", facts_json(report.facts)},
          {"details", facts_json(report.details)}};
}

PageData page_data(const Report& report) {
  PageData page;
  page.json = words_json(report);
  const Trajectory& path = report.run != nullptr ? report.run->trajectory : report.path;
  const bool upside_down = report.run != nullptr && report.run->sequence.camera.fy < 0;
  const Eigen::Vector3d up = up_of(path, upside_down);
  page.json["up"] = {up.x(), up.y(), up.z()};
  add_mesh(report, &page);
  if (report.run != nullptr)
    add_run(*report.run, &page);
  else if (!path.empty())
    add_path(path, &page);
  return page;
}

/// JSON within a script element: only '<' could end it, or begin a comment.
std::string script_json(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  return safe;
}

}  // namespace

Report report_of(const Reconstruction& run) {
  Report report;
  const std::string name = std::filesystem::path(run.sequence.path).lexically_normal().filename().string();
  report.title = name.empty() ? run.sequence.path : name;
  report.verdict = verdict_of(run);
  report.remarks = remarks_of(run);
  report.facts = facts_of(run);
  report.details = details_of(run);
  report.run = &run;
  report.mesh = &run.mesh;
  return report;
}

bool can_report() { return has_pages(); }

std::function<void(const std::string&, const Reconstruction&)> report_writer() {
  if (!can_report()) return {};
  return [](const std::string& path, const Reconstruction& run) { write_report(path, report_of(run)); };
}

void write_report(const std::string& path, const Report& report) {
  if (!has_pages())
    throw Error("this program was built without the report", path,
                "Install nodejs and npm (`./dev install`), configure with -DPLUMBLINE_REPORT=ON, and build again.");
  const std::string page = report_template();
  const std::size_t mark = page.find(kMark);
  if (mark == std::string_view::npos) throw Error("the page has no place for the data", path, "Build web/ again.");
  const PageData data = page_data(report);
  AtomicFile file(path, Durable::no);  // it can be made again
  file.write(page.substr(0, mark));
  file.write("<script type=\"application/json\" id=\"report\">" + script_json(data.json) + "</script>\n");
  for (const auto& [id, bytes] : data.buffers)
    file.write("<script type=\"text/plain\" id=\"" + id + "\">" + base64(bytes) + "</script>\n");
  file.write(page.substr(mark + kMark.size()));
  file.commit();
}

}  // namespace plumbline::app
