#include "cli/browser.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "io/atomic_file.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBrowserAdvice = "Open it in a browser, here or on another machine.";

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// xdg-open with its output thrown away; its process.
pid_t start_browser(const std::string& page) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  std::string program = "xdg-open", file = fs::absolute(page).string();
  char* words[] = {program.data(), file.data(), nullptr};
  pid_t pid = 0;
  const int error = posix_spawnp(&pid, program.c_str(), &actions, nullptr, words, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw Error("xdg-open cannot be started", page, std::string("Install xdg-utils. ") + kBrowserAdvice);
  return pid;
}

}  // namespace

bool has_desktop() {
  return !environment("DISPLAY").empty() || !environment("WAYLAND_DISPLAY").empty() || !environment("BROWSER").empty();
}

void open_in_browser(const std::string& page) {
  if (!has_desktop())
    throw Error("there is no display to open a browser on", page,
                std::string(kBrowserAdvice) + " --no-open only writes it.");
  int status = 0;
  waitpid(start_browser(page), &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw Error("xdg-open found no browser for it", page, std::string(kBrowserAdvice) + " --no-open only writes it.");
}

std::string page_folder() {
  const std::string cache = environment("XDG_CACHE_HOME"), home = environment("HOME");
  fs::path folder = !cache.empty() ? fs::path(cache) : !home.empty() ? fs::path(home) / ".cache" : fs::path();
  try {
    if (folder.empty()) throw Error("no home", "HOME", "");
    folder = folder / "plumbline" / "view";
    ensure_directory(folder.string());
  } catch (const Error&) {
    folder = fs::temp_directory_path() / fmt::format("plumbline-view-{}", getuid());
    ensure_directory(folder.string());
  }
  return folder.string();
}

BrowserRedirect::BrowserRedirect(const std::string& url)
    : path_((fs::path(page_folder()) / fmt::format("live-{}.html", getpid())).string()) {
  const std::string page = fmt::format(
      "<!doctype html>\n<meta charset=\"utf-8\">\n<meta name=\"referrer\" content=\"no-referrer\">\n"
      "<meta http-equiv=\"refresh\" content=\"0; url={}\">\n<title>Plumbline</title>\n",
      url);
  fs::remove(path_);
  const int file = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  const bool is_written = file >= 0 && write(file, page.data(), page.size()) == static_cast<ssize_t>(page.size());
  if (file >= 0) close(file);
  if (!is_written) throw Error("the page that leads the browser there cannot be written", path_, kBrowserAdvice);
  start_browser(path_);  // not waited for: some desktops stay until the browser is closed
}

BrowserRedirect::~BrowserRedirect() {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

}  // namespace plumbline::app
