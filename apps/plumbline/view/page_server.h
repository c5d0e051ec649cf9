// Serves the live page, its socket and, in the end, the report: to those who know the token.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "view/board.h"
#include "view/request.h"

namespace plumbline::app {

struct ViewOptions {
  int port = 0;                       ///< 0: one that is free
  std::string address = "127.0.0.1";  ///< of the interface that is listened on
};

/// One thread answers all pages and sends each what it lacks, as fast as it says that it has drawn what came before. A
/// page that does not answer is left alone and costs nothing.
class PageServer {
 public:
  using RequestSink = std::function<void(const Request&)>;

  /// `board` must outlive it. `sink` is called by the server's thread. Throws Error where the port cannot be had.
  PageServer(const ViewOptions& options, Board* board, RequestSink sink);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// With the token.
  std::string url() const;
  int pages() const;  ///< that watch
  /// The file that is served as report.html from now on.
  void set_report(const std::string& path);
  int reports_served() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether a request that names this host may be answered by a server on `port`: by the loopback's name, by an address,
/// or by the name that is listened on. Another name is one that somebody made point here.
bool is_own_host(const std::string& host, int port, const std::string& address);

}  // namespace plumbline::app
