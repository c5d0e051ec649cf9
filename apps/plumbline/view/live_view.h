// A run as a live page sees it: what the frame loop hands over, and what the page asks for.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "plumbline/pinhole.h"
#include "plumbline/pipeline.h"
#include "reconstruction/frame_loop.h"
#include "view/board.h"
#include "view/crop_box.h"
#include "view/guidance.h"
#include "view/mailbox.h"
#include "view/map_preview.h"
#include "view/page_server.h"
#include "view/picture.h"
#include "view/request.h"

namespace plumbline::app {

/// `ready`: a camera's frames are shown, and a start is waited for.
enum class ViewPhase { ready, running, paused, going_back, finishing, finished, failed };

struct ViewScene {
  std::string title;
  Pinhole camera;
  int total = -1;  ///< frames; negative if nobody knows
  bool is_live = false;
  bool has_map = true;   ///< false: a recording is made, images alone are shown
  double max_depth = 0;  ///< metres
  std::string output;    ///< folder, whose disk is watched
};

/// The frame loop hands its newest state over without waiting for anybody; a thread of lower priority makes of it what
/// pages are sent, and another, of still lower priority, the surface. All calls but those of the server come from the
/// thread of the frame loop.
class LiveView : public FrameObserver {
 public:
  /// Throws Error where the port cannot be had.
  explicit LiveView(const ViewOptions& options);
  ~LiveView() override;

  std::string url() const { return server_.url(); }
  void set_scene(const ViewScene& scene);
  /// Whose map is shown from now on; what was shown before is dropped, unless `and_keep`. Null: none.
  void follow(Pipeline* pipeline, bool and_keep = false);

  void before(const Frame& frame, FrameDiagnostics* diagnostics) override;
  void observe(const ProcessedFrame& processed) override;
  /// A frame that is not processed: its images alone.
  void show(const DepthImage& depth, const ColorImage& color, double depth_scale);
  /// How a recording goes, which has no map.
  void set_recording(std::uint64_t frames, double rate, std::uint64_t dropped, const std::string& sensor);
  /// While the run stands still: what the page still lacks of the map.
  void idle();
  void set_phase(ViewPhase phase, const std::string& text = "", double progress = 0);
  /// How a live sensor of orientations is, in words; one that begins with "not" is told as a hint.
  void set_sensor(const std::string& text) { sensor_ = text; }
  /// Whether the latest seconds can be undone: empty, or why not.
  void set_undo(const std::string& obstacle);

  /// The next that a page asks for; nothing if there is none. Never `shown` or `crop`.
  std::optional<Request> take_request();
  /// What is to be kept of the surface; none: all.
  std::optional<CropBox> crop() const;

  /// The report takes the page's place, for those that watch; returns once they have it, or after some seconds. Without
  /// a report the page says `note`.
  void hand_over(const std::string& report, const std::string& note);
  /// Says what ended the run.
  void fail(const std::string& message);

 private:
  using Position = std::array<float, 3>;
  struct Facts {
    FrameReport report;
    double stamp = 0;  ///< milliseconds of the system's clock when the frame came
    int frames = 0, tracked = 0;
    double rate = 0;  ///< frames a second
    std::optional<LiveCounts> live;
    std::optional<Eigen::Vector3d> up;  ///< world axes, as measured
    std::string sensor;
  };
  /// What the frame loop hands over: the newest, and all positions.
  struct Packet {
    int epoch = 0;
    std::optional<Facts> facts;
    std::optional<SmallFrame> picture;
    std::vector<Position> path;
    void follow(Packet&& older);
  };

  bool wants_picture();
  void note_view(const FrameReport& report);
  void take_changes();
  void receive(const Request& request);

  // Of the thread that makes messages.
  void work();
  void work_once();
  void apply(const Packet& packet);
  void apply_facts(const Facts& facts);
  void apply_picture(const SmallFrame& picture);
  void end(const std::string& why);

  Board board_;
  Mailbox<Packet> mailbox_;
  std::atomic<bool> stopping_ = false;
  std::atomic<int> epoch_ = 0;             ///< of the pipeline that is followed
  std::atomic<bool> has_picture_ = false;  ///< one that the worker has not taken

  // Of the frame loop.
  Pipeline* pipeline_ = nullptr;
  ViewScene scene_;
  double stamp_ = 0;
  int frames_ = 0, tracked_ = 0;
  std::deque<double> recent_;  ///< stamps of frames
  double picture_stamp_ = 0;
  std::vector<SE3> views_;  ///< world_from_camera of frames whose changes no page has yet been sent
  int view_step_ = 1, views_skipped_ = 0;
  Eigen::Vector3d up_ = Eigen::Vector3d::Zero();  ///< sum of what was measured
  int ups_ = 0;
  std::string sensor_;

  // Of the worker.
  int worker_epoch_ = 0;
  Guide guide_{8};
  DepthStatistics depth_;
  std::string good_;  ///< the final picture while tracked
  bool was_tracked_ = false, is_tracked_ = false;
  std::chrono::steady_clock::time_point disk_checked_;
  std::vector<Hint> standing_;  ///< hints of disk and sensor

  mutable std::mutex mutex_;  ///< of requests and box
  std::deque<Request> requests_;
  std::atomic<bool> has_request_ = false;
  std::optional<CropBox> crop_;

  MapPreview preview_;
  std::thread worker_;
  PageServer server_;  // last: it calls the others
};

}  // namespace plumbline::app
