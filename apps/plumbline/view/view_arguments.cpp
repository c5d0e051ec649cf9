#include "view/view_arguments.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <system_error>

#include "cli/arguments.h"
#include "cli/browser.h"
#include "cli/console.h"
#include "plumbline/error.h"
#include "view/pages.h"

namespace plumbline::app {
namespace {

/// CLI11 takes a flag's 0 for "no", hence a word for a free port.
int port_of(const std::string& text) {
  if (text == kFreePort) return 0;
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || port < 0 || port > 65535)
    throw UsageError("'" + text + "' is no port", "--view", "Give --view, or --view=PORT with a number up to 65535.");
  return port;
}

/// The page, and what leads the browser to it, for as long as it is served.
struct OpenView {
  explicit OpenView(const ViewOptions& options) : view(options) {}
  LiveView view;
  std::unique_ptr<BrowserRedirect> redirect;
};

void show_in_browser(OpenView* open) {
  if (!has_desktop()) return say("view       open it in a browser; there is no desktop here to do so");
  try {
    open->redirect = std::make_unique<BrowserRedirect>(open->view.url());
  } catch (const Error& error) {
    warn(error.what());
  }
}

}  // namespace

void add_view_arguments(CLI::App& command, ViewArguments& arguments) {
  command
      .add_flag(
          std::string("--view{") + kFreePort + "}", arguments.port,
          "Show it while it grows, in a page of this machine, and open the browser; --view=PORT for a certain port")
      ->type_name("");
  command
      .add_option("--view-address", arguments.address,
                  "Serve the page on this address, for browsers of other machines; 0.0.0.0 is all of this machine's")
      ->capture_default_str()
      ->type_name("ADDRESS");
}

std::shared_ptr<LiveView> open_view(const ViewArguments& arguments) {
  if (arguments.port.empty()) {
    if (arguments.address != ViewOptions().address)
      throw UsageError("an address is of a page that is served", "--view-address", "Give --view as well.");
    return nullptr;
  }
  if (!has_pages())
    throw UsageError("this program was built without the page (PLUMBLINE_REPORT)", "--view", "Leave it out.");
  const auto open = std::make_shared<OpenView>(ViewOptions{port_of(arguments.port), arguments.address});
  say("view       {}", open->view.url());
  show_in_browser(open.get());
  flush_output();
  return {open, &open->view};
}

}  // namespace plumbline::app
