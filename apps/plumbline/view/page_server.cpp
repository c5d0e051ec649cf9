#include "view/page_server.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <mutex>
#include <optional>
#include <set>
#include <string_view>
#include <thread>
#include <utility>

#include "io/text_file.h"
#include "plumbline/error.h"
#include "view/pages.h"

namespace plumbline::app {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using ErrorCode = beast::error_code;
using HttpRequest = http::request<http::empty_body>;

constexpr int kMaxPages = 8, kMaxVisits = 32;
constexpr std::uint64_t kWindow = 1;  ///< updates that a page may have before it: none grows old on the way
constexpr std::size_t kMaxHeader = 8192;
constexpr std::chrono::seconds kVisitLimit{10}, kIdleLimit{20};

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw Error("the system gives no random numbers", "getrandom", "Run without --view.");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

/// In a time that does not tell where they differ.
bool is_equal(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

bool is_address(const std::string& host) {
  ErrorCode error;
  asio::ip::make_address(host, error);
  return !error;
}

std::string in_url(const std::string& address) {
  return address.find(':') == std::string::npos ? address : "[" + address + "]";
}

std::string_view view_of(boost::string_view text) { return {text.data(), text.size()}; }

/// "/live" and "token=…" of "/live?token=…".
std::pair<std::string_view, std::string_view> split_target(std::string_view target) {
  const std::size_t mark = target.find('?');
  if (mark == std::string_view::npos) return {target, {}};
  return {target.substr(0, mark), target.substr(mark + 1)};
}

class Page;

/// What all connections share; used by the server's thread alone, but for what is atomic or under the mutex.
struct Shared {
  Shared(const ViewOptions& o, Board* b, PageServer::RequestSink s) : options(o), board(*b), sink(std::move(s)) {}

  ViewOptions options;
  Board& board;
  PageServer::RequestSink sink;
  std::string token = random_token();
  int port = 0;
  std::atomic<int> pages = 0, reports = 0;
  std::atomic<bool> has_news = false;
  int visits = 0;
  std::set<Page*> watching;
  std::mutex mutex;
  std::string report;  ///< path

  /// Empty, or why nothing is answered: neither a page of another site nor a name that was made to point here.
  std::string_view objection(const HttpRequest& request, bool must_have_origin) const;
  http::response<http::string_body> answer(const HttpRequest& request);
  std::string report_page();
};

std::string_view Shared::objection(const HttpRequest& request, bool must_have_origin) const {
  const std::string host(request[http::field::host]);
  if (!is_own_host(host, port, options.address)) return "This server has another name.\n";
  const std::string_view origin = view_of(request[http::field::origin]);
  if (origin.empty() ? must_have_origin : origin != "http://" + host) return "This page is not for other sites.\n";
  const std::string_view query = split_target(view_of(request.target())).second;
  if (!query.starts_with("token=") || !is_equal(query.substr(6), token))
    return "The address lacks its token. Use the one that plumbline has printed.\n";
  return {};
}

/// Empty if there is none.
std::string Shared::report_page() {
  const std::lock_guard lock(mutex);
  try {
    return report.empty() ? std::string() : read_file(report);
  } catch (const Error&) {
    return {};
  }
}

http::response<http::string_body> respond(const HttpRequest& request, http::status status, std::string_view type,
                                          std::string content) {
  http::response<http::string_body> response(status, request.version());
  response.set(http::field::content_type, fmt::format("{}; charset=utf-8", type));
  response.set(http::field::cache_control, "no-store");
  response.set(http::field::x_frame_options, "DENY");
  response.set("Referrer-Policy", "no-referrer");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.keep_alive(false);
  response.body() = std::move(content);
  response.prepare_payload();
  return response;
}

http::response<http::string_body> refuse(const HttpRequest& request, http::status status, std::string_view why) {
  return respond(request, status, "text/plain", std::string(why));
}

http::response<http::string_body> Shared::answer(const HttpRequest& request) {
  if (request.method() != http::verb::get)
    return refuse(request, http::status::method_not_allowed, "Only GET is answered.\n");
  if (const std::string_view why = objection(request, false); !why.empty())
    return refuse(request, http::status::forbidden, why);
  const std::string_view path = split_target(view_of(request.target())).first;
  if (path == "/") return respond(request, http::status::ok, "text/html", live_page());
  if (path != "/report.html") return refuse(request, http::status::not_found, "There is no such page.\n");
  std::string page = report_page();
  if (page.empty()) return refuse(request, http::status::not_found, "There is no report yet.\n");
  return respond(request, http::status::ok, "text/html", std::move(page));
}

/// One page that watches.
class Page : public std::enable_shared_from_this<Page> {
 public:
  Page(tcp::socket socket, Shared* shared) : socket_(std::move(socket)), shared_(*shared) {
    ++shared_.pages;
    shared_.watching.insert(this);
  }
  ~Page() {
    shared_.watching.erase(this);
    --shared_.pages;
  }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  void begin(const HttpRequest& request) {
    websocket::stream_base::timeout limits = websocket::stream_base::timeout::suggested(beast::role_type::server);
    limits.idle_timeout = kIdleLimit;
    limits.keep_alive_pings = true;
    socket_.set_option(limits);
    socket_.read_message_max(kMaxRequestBytes);
    socket_.binary(true);
    socket_.auto_fragment(false);
    socket_.async_accept(request, [page = shared_from_this()](ErrorCode error) {
      if (error) return;
      page->is_open_ = true;
      page->read();
      page->send();
    });
  }

  /// What the page lacks, if it has drawn what it has.
  void send() {
    if (!is_open_ || next_ < messages_.size() || cursor_.number >= shown_ + kWindow) return;
    messages_ = shared_.board.next(&cursor_);
    next_ = 0;
    write();
  }

 private:
  void write() {
    if (next_ == messages_.size()) return;
    const std::string& message = *messages_[next_];
    socket_.async_write(asio::buffer(message), [page = shared_from_this()](ErrorCode error, std::size_t) {
      if (error) return page->close();
      if (++page->next_ == page->messages_.size()) return page->send();
      page->write();
    });
  }

  void read() {
    socket_.async_read(buffer_, [page = shared_from_this()](ErrorCode error, std::size_t) {
      if (error || !page->take()) return page->close();
      page->read();
    });
  }

  /// False for what is no request.
  bool take() {
    const auto bytes = buffer_.data();
    const std::optional<Request> request =
        socket_.got_text() ? parse_request({static_cast<const char*>(bytes.data()), bytes.size()}) : std::nullopt;
    buffer_.clear();
    if (!request) return false;
    if (request->kind != RequestKind::shown) {
      shared_.sink(*request);
    } else {
      shown_ = std::max(shown_, std::min(request->number, cursor_.number));
      send();
    }
    return true;
  }

  void close() {
    is_open_ = false;
    beast::get_lowest_layer(socket_).close();  // whatever waits for it ends
  }

  websocket::stream<beast::tcp_stream> socket_;
  Shared& shared_;
  beast::flat_buffer buffer_;
  Board::Cursor cursor_;
  std::uint64_t shown_ = 0;
  std::vector<Message> messages_;
  std::size_t next_ = 0;
  bool is_open_ = false;
};

/// One connection, until it is answered or has become a page that watches.
class Visit : public std::enable_shared_from_this<Visit> {
 public:
  Visit(tcp::socket socket, Shared* shared) : stream_(std::move(socket)), shared_(*shared) { ++shared_.visits; }
  ~Visit() { --shared_.visits; }
  Visit(const Visit&) = delete;
  Visit& operator=(const Visit&) = delete;

  void begin() {
    if (shared_.visits > kMaxVisits) return;
    stream_.expires_after(kVisitLimit);
    parser_.header_limit(kMaxHeader);
    parser_.body_limit(0);
    http::async_read(stream_, buffer_, parser_, [visit = shared_from_this()](ErrorCode error, std::size_t) {
      if (!error) visit->serve();
    });
  }

 private:
  void serve() {
    const HttpRequest& request = parser_.get();
    const bool wants_socket = websocket::is_upgrade(request);
    if (!wants_socket) return send(shared_.answer(request));
    if (split_target(view_of(request.target())).first != "/live")
      return send(refuse(request, http::status::not_found, "There is no such socket.\n"));
    if (const std::string_view why = shared_.objection(request, true); !why.empty())
      return send(refuse(request, http::status::forbidden, why));
    if (shared_.pages >= kMaxPages)
      return send(refuse(request, http::status::service_unavailable, "Too many pages watch already.\n"));
    stream_.expires_never();
    std::make_shared<Page>(stream_.release_socket(), &shared_)->begin(request);
  }

  void send(http::response<http::string_body> response) {
    response_ = std::move(response);
    http::async_write(stream_, response_, [visit = shared_from_this()](ErrorCode error, std::size_t) {
      const std::string_view path = split_target(view_of(visit->parser_.get().target())).first;
      if (!error && visit->response_.result() == http::status::ok && path == "/report.html") ++visit->shared_.reports;
      visit->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
    });
  }

  beast::tcp_stream stream_;
  Shared& shared_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> response_;
};

}  // namespace

bool is_own_host(const std::string& host, int port, const std::string& address) {
  const std::string suffix = fmt::format(":{}", port);
  std::string name = host;
  if (name.ends_with(suffix))
    name.resize(name.size() - suffix.size());
  else if (port != 80)
    return false;
  if (name.starts_with('[') && name.ends_with(']')) name = name.substr(1, name.size() - 2);
  return name == "localhost" || name == address || is_address(name);
}

struct PageServer::State {
  State(const ViewOptions& options, Board* board, RequestSink sink) : shared(options, board, std::move(sink)) {}

  Shared shared;
  asio::io_context context{1};
  tcp::acceptor acceptor{context};
  std::thread thread;

  void listen() {
    const tcp::endpoint endpoint(asio::ip::make_address(shared.options.address),
                                 static_cast<std::uint16_t>(shared.options.port));
    acceptor.open(endpoint.protocol());
    acceptor.set_option(asio::socket_base::reuse_address(true));
    acceptor.bind(endpoint);
    acceptor.listen();
    shared.port = acceptor.local_endpoint().port();
  }
  void accept() {
    acceptor.async_accept([this](ErrorCode error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error) {
        socket.set_option(tcp::no_delay(true), error);
        std::make_shared<Visit>(std::move(socket), &shared)->begin();
      }
      accept();
    });
  }
  /// From any thread.
  void tell_pages() {
    if (shared.has_news.exchange(true)) return;
    asio::post(context, [this] {
      shared.has_news = false;
      for (Page* page : shared.watching) page->send();
    });
  }
};

PageServer::PageServer(const ViewOptions& options, Board* board, RequestSink sink)
    : state_(std::make_unique<State>(options, board, std::move(sink))) {
  try {
    state_->listen();
  } catch (const std::exception&) {
    throw Error("the live page cannot listen there", fmt::format("{}:{}", in_url(options.address), options.port),
                "Another program has the port, or the address is not one of this machine: give --view=PORT or "
                "--view-address.");
  }
  board->set_listener([state = state_.get()] { state->tell_pages(); });
  state_->accept();
  state_->thread = std::thread([state = state_.get()] {
    while (!state->context.stopped()) {
      try {
        state->context.run();
      } catch (const std::exception&) {  // what one page did is no matter of the others, nor of the run
      }
    }
  });
}

PageServer::~PageServer() {
  state_->context.stop();
  state_->thread.join();
}

std::string PageServer::url() const {
  const ViewOptions& options = state_->shared.options;
  const bool is_any = options.address == "0.0.0.0" || options.address == "::";
  return fmt::format("http://{}:{}/?token={}", is_any ? "localhost" : in_url(options.address), state_->shared.port,
                     state_->shared.token);
}

int PageServer::pages() const { return state_->shared.pages; }
int PageServer::reports_served() const { return state_->shared.reports; }

void PageServer::set_report(const std::string& path) {
  const std::lock_guard lock(state_->shared.mutex);
  state_->shared.report = path;
}

}  // namespace plumbline::app
