// The map as pages see it: a copy that is meshed block by block, beside the run.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "map/brick_mirror.h"
#include "plumbline/map.h"
#include "view/board.h"
#include "view/mailbox.h"

namespace plumbline::app {

/// The bricks that changed with a frame.
struct MapChange {
  int epoch = 0;     ///< of the map, see `Board`
  double stamp = 0;  ///< milliseconds of the system's clock when the frame came
  MapViews views;
  MapUpdate update;
};

/// A thread of low priority, which takes the time that the tracker leaves, meshes what changed: what is new at once,
/// what is seen once more after a while.
class MapPreview {
 public:
  /// `fail` is told, by the thread, why it has ended. `board` must outlive it.
  MapPreview(Board* board, std::function<void(const std::string&)> fail);
  ~MapPreview();
  MapPreview(const MapPreview&) = delete;
  MapPreview& operator=(const MapPreview&) = delete;

  /// Ends the thread; nothing is told to the board any more.
  void stop();
  /// Of the frame loop: whether so many changes wait that no more should be copied.
  bool is_busy() const { return waiting_ >= kMaxWaiting; }
  /// Of the frame loop; never waits.
  void hand(std::unique_ptr<MapChange> change);
  /// Whether no more of the map fits.
  bool is_full() const { return is_full_; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int kMaxWaiting = 3;
  struct Changes {
    std::vector<std::unique_ptr<MapChange>> list;
    void follow(Changes&& older);
  };
  /// A block that is to be meshed.
  struct Dirty {
    Clock::time_point due;
    double stamp = 0;  ///< of the first frame that brought something new; 0: none did
  };

  void work();
  void work_once();
  void apply(const MapChange& change);
  bool mesh_one();

  Board& board_;
  std::function<void(const std::string&)> fail_;
  Mailbox<Changes> mailbox_;
  std::atomic<bool> stopping_ = false, is_full_ = false;
  std::atomic<int> waiting_ = 0;  ///< changes that the thread has not taken

  // Of the thread.
  int epoch_ = 0;
  BrickMirror mirror_;
  std::map<MapBlock, Dirty> dirty_;
  bool has_unannounced_ = false;  ///< surfaces on the board
  std::thread thread_;
};

}  // namespace plumbline::app
