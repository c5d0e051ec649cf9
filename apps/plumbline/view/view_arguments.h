// The options of the live page.
#pragma once

#include <memory>
#include <string>

#include "view/live_view.h"

namespace CLI {
class App;
}

namespace plumbline::app {

constexpr const char* kFreePort = "auto";

struct ViewArguments {
  std::string port;  ///< a number, or kFreePort; empty: no page
  std::string address = ViewOptions().address;
};

void add_view_arguments(CLI::App& command, ViewArguments& arguments);

/// The page, with its address told to the user and opened in the desktop's browser where there is one; null without
/// --view. Throws UsageError for options that do not go together, Error where the port cannot be had.
std::shared_ptr<LiveView> open_view(const ViewArguments& arguments);

}  // namespace plumbline::app
