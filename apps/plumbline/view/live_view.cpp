#include "view/live_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "io/images/jpeg.h"
#include "plumbline/time.h"
#include "view/message.h"
#include "view/priority.h"

namespace plumbline::app {
namespace {

using Clock = std::chrono::steady_clock;
using Json = Board::Json;

constexpr int kBricksPerFrame = 160;                       ///< that are copied for pages: what a frame's time allows
constexpr double kPictureInterval = 30;                    ///< milliseconds
constexpr int kPictureWidth = 240, kRecordingWidth = 320;  ///< pixels at most: as wide as the page shows them
constexpr std::size_t kMaxViews = 64;
constexpr std::chrono::milliseconds kLingerPoll{20};
constexpr std::size_t kMaxRequests = 16;
constexpr int kWorkerPriority = 5;  ///< steps of the worker, which the tracker goes before
constexpr int kQuality = 75;        ///< of JPEG

double now_milliseconds() {
  return std::chrono::duration<double, std::milli>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string_view name_of(ViewPhase phase) {
  constexpr std::array<std::string_view, 7> kNames = {"ready",     "running",  "paused", "going_back",
                                                      "finishing", "finished", "failed"};
  return kNames.at(static_cast<std::size_t>(phase));
}

Json json_of(const SE3& pose) {
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Quaterniond q = pose.quaternion();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

Json json_of(const std::vector<Hint>& hints) {
  Json json = Json::array();
  for (const Hint& hint : hints) json.push_back({{"kind", hint.kind}, {"text", hint.text}, {"detail", hint.detail}});
  return json;
}

std::string picture_message(const std::string& kind, const ColorImage& image) {
  const std::string jpeg = encode_jpeg(image, kQuality);
  return encode_message({{"type", "picture"}, {"kind", kind}, {"width", image.width}, {"height", image.height}},
                        {{"jpeg", jpeg}});
}

/// Which way is up where this frame was taken, world axes: by the sensor of orientations, by the accelerometer, which
/// feels the ground's push, or by the image's upper side, as people hold a camera upright.
Eigen::Vector3d up_of(const Frame& frame, const SE3& world_from_camera, double fy) {
  const Eigen::Matrix3d rotation = world_from_camera.rotation();
  if (frame.earth_from_camera) return rotation * frame.earth_from_camera->transpose() * Eigen::Vector3d::UnitZ();
  Eigen::Vector3d push = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : frame.inertial) push += sample.specific_force;
  if (push.norm() > 1) return rotation * push.normalized();
  return rotation * Eigen::Vector3d(0, fy < 0 ? 1 : -1, 0);
}

std::vector<Hint> hints_of(const std::string& folder, const std::string& sensor) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  return standing_hints(error ? std::nullopt : std::optional(space.available), folder, sensor);
}

}  // namespace

LiveView::LiveView(const ViewOptions& options)
    : preview_(&board_, [this](const std::string& why) { end(why); }),
      server_(options, &board_, [this](const Request& request) { receive(request); }) {
  worker_ = std::thread([this] { work(); });
}

LiveView::~LiveView() {
  stopping_ = true;
  mailbox_.ring();
  worker_.join();
  preview_.stop();  // both tell the server's pages
}

void LiveView::set_scene(const ViewScene& scene) {
  scene_ = scene;
  const Pinhole& k = scene.camera;
  board_.set_scene(
      {{"title", scene.title},
       {"total", scene.total},
       {"live", scene.is_live},
       {"map", scene.has_map},
       {"output", scene.output},
       {"plumbline", PLUMBLINE_VERSION},
       {"camera", {{"width", k.width}, {"height", k.height}, {"fx", k.fx}, {"fy", k.fy}, {"cx", k.cx}, {"cy", k.cy}}}});
}

void LiveView::follow(Pipeline* pipeline, bool and_keep) {
  pipeline_ = pipeline;
  if (and_keep) return;
  frames_ = tracked_ = ups_ = 0;
  up_.setZero();
  views_.clear();
  view_step_ = 1;
  board_.clear_map(++epoch_);
  board_.set_state({{"frame", nullptr}, {"frames", 0}, {"tracked", 0}, {"hints", Json::array()}});
}

void LiveView::before(const Frame& /*frame*/, FrameDiagnostics* /*diagnostics*/) { stamp_ = now_milliseconds(); }

void LiveView::observe(const ProcessedFrame& processed) {
  auto packet = std::make_unique<Packet>();
  packet->epoch = epoch_;
  const FrameReport& report = processed.report;
  const bool is_tracked = has_pose(report.tracking.status);
  ++frames_;
  if (is_tracked) ++tracked_;
  recent_.push_back(stamp_);
  while (recent_.front() < stamp_ - 1500) recent_.pop_front();
  Facts facts{report, stamp_, frames_, tracked_, 0, processed.live, std::nullopt, sensor_};
  if (recent_.size() > 1) facts.rate = 1e3 * static_cast<double>(recent_.size() - 1) / (stamp_ - recent_.front());
  if (is_tracked) {
    up_ += up_of(processed.frame, report.world_from_camera, scene_.camera.fy);
    ++ups_;
    note_view(report);
    const Eigen::Vector3f t = report.world_from_camera.translation().cast<float>();
    packet->path.push_back({t.x(), t.y(), t.z()});
  }
  if (ups_ > 0) facts.up = up_.normalized();
  packet->facts = std::move(facts);
  if (wants_picture())
    packet->picture =
        small_frame(processed.frame.depth, processed.frame.color, processed.frame.depth_scale, kPictureWidth);
  mailbox_.put(std::move(packet));
  take_changes();
}

void LiveView::show(const DepthImage& depth, const ColorImage& color, double depth_scale) {
  stamp_ = now_milliseconds();
  if (!wants_picture()) return;
  auto packet = std::make_unique<Packet>();
  packet->epoch = epoch_;
  packet->picture = small_frame(depth, color, depth_scale, scene_.has_map ? kPictureWidth : kRecordingWidth);
  mailbox_.put(std::move(packet));
}

void LiveView::set_recording(std::uint64_t frames, double rate, std::uint64_t dropped, const std::string& sensor) {
  std::vector<Hint> hints = hints_of(scene_.output, sensor);
  board_.set_state(
      {{"frames", frames}, {"rate", rate}, {"dropped", dropped}, {"sensor", sensor}, {"hints", json_of(hints)}});
}

void LiveView::idle() { take_changes(); }

bool LiveView::wants_picture() {
  if (server_.pages() == 0 || has_picture_ || stamp_ - picture_stamp_ < kPictureInterval) return false;
  picture_stamp_ = stamp_;
  return has_picture_ = true;
}

/// While no page watches, evenly spaced ones of all frames are kept.
void LiveView::note_view(const FrameReport& report) {
  if (++views_skipped_ < view_step_) return;
  views_skipped_ = 0;
  views_.push_back(report.world_from_camera);
  if (views_.size() < kMaxViews) return;
  for (std::size_t i = 0; 2 * i < views_.size(); ++i) views_[i] = views_[2 * i];
  views_.resize((views_.size() + 1) / 2);
  view_step_ *= 2;
}

void LiveView::take_changes() {
  if (pipeline_ == nullptr || server_.pages() == 0 || preview_.is_busy()) return;
  MapUpdate update = pipeline_->take_changes(kBricksPerFrame);
  if (update.bricks.empty()) return;
  const bool is_all = update.waiting == 0;
  preview_.hand(std::make_unique<MapChange>(MapChange{epoch_, stamp_, {scene_.camera, views_}, std::move(update)}));
  if (!is_all && view_step_ > 1) return;  // what comes next was seen while no page watched, too
  view_step_ = 1;
  views_.clear();
}

void LiveView::Packet::follow(Packet&& older) {
  if (!picture) picture = std::move(older.picture);
  if (older.epoch != epoch) return;
  path.insert(path.begin(), older.path.begin(), older.path.end());
  if (!facts) facts = std::move(older.facts);
}

void LiveView::set_phase(ViewPhase phase, const std::string& text, double progress) {
  board_.set_state({{"phase", name_of(phase)}, {"note", text}, {"progress", progress}});
}

void LiveView::set_undo(const std::string& obstacle) {
  board_.set_state({{"undo", obstacle.empty()}, {"undo_note", obstacle}});
}

std::optional<Request> LiveView::take_request() {
  if (!has_request_) return std::nullopt;
  const std::lock_guard lock(mutex_);
  const Request request = requests_.front();
  requests_.pop_front();
  has_request_ = !requests_.empty();
  return request;
}

std::optional<CropBox> LiveView::crop() const {
  const std::lock_guard lock(mutex_);
  return crop_;
}

void LiveView::receive(const Request& request) {
  {
    const std::lock_guard lock(mutex_);
    if (request.kind == RequestKind::crop) {
      crop_ = request.box;
    } else if (requests_.size() < kMaxRequests) {
      requests_.push_back(request);
      has_request_ = true;
    }
  }
  if (request.kind == RequestKind::crop) board_.set_state({{"crop", box_json(request.box)}});
}

void LiveView::hand_over(const std::string& report, const std::string& note) {
  constexpr std::chrono::seconds kLinger{15};
  server_.set_report(report);
  const int pages = server_.pages();
  set_phase(ViewPhase::finished, report.empty() ? note : "");
  if (report.empty()) return std::this_thread::sleep_for(std::chrono::seconds(1));
  const auto end = Clock::now() + kLinger;
  while (Clock::now() < end && server_.pages() > 0 && server_.reports_served() < pages)
    std::this_thread::sleep_for(kLingerPoll);
  std::this_thread::sleep_for(4 * kLingerPoll);  // what was sent arrives
}

void LiveView::fail(const std::string& message) {
  set_phase(ViewPhase::failed, message);
  if (server_.pages() > 0) std::this_thread::sleep_for(std::chrono::seconds(1));
}

void LiveView::work() {
  lower_priority(kWorkerPriority);
  try {
    while (!stopping_) work_once();
  } catch (const std::exception& error) {
    end(error.what());
  }
}

/// The page ends, not the run.
void LiveView::end(const std::string& why) {
  board_.set_state({{"phase", name_of(ViewPhase::failed)}, {"note", fmt::format("The page cannot go on: {}", why)}});
}

void LiveView::work_once() {
  const unsigned rung = mailbox_.rung();
  if (const std::unique_ptr<Packet> packet = mailbox_.take())
    apply(*packet);
  else
    mailbox_.wait(rung);
}

void LiveView::apply(const Packet& packet) {
  if (worker_epoch_ != packet.epoch) {
    worker_epoch_ = packet.epoch;
    guide_ = Guide(scene_.max_depth);
  }
  if (!packet.path.empty()) board_.add_path(packet.path, packet.epoch);
  if (packet.picture) apply_picture(*packet.picture);
  if (packet.facts)
    apply_facts(*packet.facts);
  else
    board_.set_state(Json::object());  // sends the picture
}

void LiveView::apply_facts(const Facts& facts) {
  const FrameReport& report = facts.report;
  is_tracked_ = has_pose(report.tracking.status);
  if (Clock::now() - disk_checked_ > std::chrono::seconds(2)) {
    disk_checked_ = Clock::now();
    standing_ = hints_of(scene_.output, facts.sensor);
  }
  std::vector<Hint> hints = guide_.advise(report, depth_);
  hints.insert(hints.end(), standing_.begin(), standing_.end());
  if (preview_.is_full())
    hints.push_back({"full", "The preview is full", "The map goes on growing; this page shows no more of it."});
  Json frame = {{"index", report.index},
                {"time", to_seconds(report.time)},
                {"stamp", facts.stamp},
                {"status", to_string(report.tracking.status)},
                {"reason", to_string(report.tracking.reason)},
                {"pose", json_of(report.world_from_camera)},
                {"matched", report.tracking.inlier_fraction},
                {"milliseconds", report.milliseconds.total()}};
  Json state = {{"frame", std::move(frame)},
                {"frames", facts.frames},
                {"tracked", facts.tracked},
                {"rate", facts.rate},
                {"hints", json_of(hints)},
                {"sensor", facts.sensor},
                {"orientation", to_string(report.orientation)}};
  if (facts.live) state["dropped"] = facts.live->dropped;
  if (facts.up) state["up"] = {facts.up->x(), facts.up->y(), facts.up->z()};
  board_.set_state(state);
  if (was_tracked_ && !is_tracked_ && !good_.empty()) board_.set_picture("good", good_);
  was_tracked_ = is_tracked_;
}

void LiveView::apply_picture(const SmallFrame& picture) {
  depth_ = depth_statistics(picture.depth, picture.depth_scale);
  if (!picture.color.empty()) guide_.observe_sharpness(sharpness(picture.color));
  const ColorImage depth = depth_colors(picture.depth, picture.depth_scale);
  board_.set_picture("depth", picture_message("depth", depth));
  if (!picture.color.empty()) board_.set_picture("color", picture_message("color", picture.color));
  if (is_tracked_) good_ = picture_message("good", picture.color.empty() ? depth : picture.color);
  has_picture_ = false;
}

}  // namespace plumbline::app
